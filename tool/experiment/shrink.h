// Shrinks a failing world as far as it still fails.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "tool/experiment/soak_case.h"

namespace ticktrue::verifier::soak {

/// Whether the world still fails. Called only for worlds that check_scene accepts.
using CaseFails = std::function<bool(const SoakCase&)>;

struct ShrinkOptions {
  std::size_t test_count_max = 3000;              // calls of the predicate
  std::function<bool()> is_over;                  // asked before each call: true ends the search; may be empty
  std::optional<std::uint64_t> first_wrong_tick;  // where known: no later tick is tried
  bool keeps_method = false;                      // settings that say how the engine computes stay
  bool keeps_course = false;                      // ticks and gravity stay
};

struct ShrinkResult {
  SoakCase smallest;
  std::size_t test_count = 0;  // calls of the predicate
};

/// Removes ticks, inputs, bodies (with their joints, forces and inputs; ids follow), joints, forces and prototypes, and
/// resets the rest to defaults, until nothing more can be removed or the limit of tests is reached.
/// Requires: still_fails(failing).
ShrinkResult shrink(const SoakCase& failing, const CaseFails& still_fails, const ShrinkOptions& options = {});

/// The case with only these bodies, by index, ascending. Joints, forces and inputs of other bodies are removed; ids of
/// spawned bodies follow.
SoakCase with_bodies(const SoakCase& soak_case, const std::vector<std::size_t>& kept);
/// The same for joints, and inputs to them.
SoakCase with_joints(const SoakCase& soak_case, const std::vector<std::size_t>& kept);
/// The same for inputs. Ids follow where only `spawn` makes bodies.
SoakCase with_inputs(const SoakCase& soak_case, const std::vector<std::size_t>& kept);

}  // namespace ticktrue::verifier::soak
