// The vector instructions of the engine's kernels. The choice changes no bit.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "base/result.h"

namespace ticktrue::engine {

enum class InstructionSet : std::uint8_t { baseline, avx2 };

struct InstructionSetInfo {
  InstructionSet kind;
  std::string_view name;
};
/// Narrowest first. `baseline`: the instructions of every machine of this build's target.
inline constexpr std::array<InstructionSetInfo, 2> instruction_sets{{
    {InstructionSet::baseline, "baseline"},
    {InstructionSet::avx2, "avx2"},
}};

/// Whether this build has kernels for the set and this machine runs them.
bool can_use(InstructionSet set);

/// The set of engines made from now on, unless their options name one. Initially the widest set that this machine can
/// use.
InstructionSet instruction_set_in_use();
/// Requires: no engine is being made at the same time. Errors: usage, for a set that is unknown or cannot be used.
Status use_instruction_set(std::string_view name);

/// The environment variable by which users of programs choose the set.
inline constexpr const char* instruction_set_variable = "TICKTRUE_ISA";

}  // namespace ticktrue::engine
