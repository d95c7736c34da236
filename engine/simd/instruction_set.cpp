// The instruction sets of this machine, determined once.
// SPDX-License-Identifier: MIT
#include "engine/simd/instruction_set.h"

namespace ticktrue::engine {
namespace {

InstructionSet widest() {
  InstructionSet best = InstructionSet::baseline;
  for (const InstructionSetInfo& info : instruction_sets)
    if (can_use(info.kind)) best = info.kind;
  return best;
}

InstructionSet& present_set() {
  static InstructionSet set = widest();
  return set;
}

}  // namespace

bool can_use(InstructionSet set) {
  if (set == InstructionSet::baseline) return true;
#if defined(TICKTRUE_HAS_AVX2_KERNELS)
  return __builtin_cpu_supports("avx2");
#else
  return false;
#endif
}

InstructionSet instruction_set_in_use() {
  return present_set();
}

Status use_instruction_set(std::string_view name) {
  std::string names;
  for (const InstructionSetInfo& info : instruction_sets) {
    if (!can_use(info.kind)) continue;
    if (info.name == name) {
      present_set() = info.kind;
      return {};
    }
    names += (names.empty() ? "" : ", ") + std::string(info.name);
  }
  return Error{ErrorCode::usage,
               std::string(instruction_set_variable) + ": found \"" + std::string(name) + "\", expected " + names,
               "leave it unset for the widest that this machine has"};
}

}  // namespace ticktrue::engine
