// Shrinks a failing world as long as it still fails.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "tool/experiment/soak_case.h"

namespace ticktrue::soak {

/// Whether the world still fails. Only called for worlds that check_scene accepts.
using CaseFails = std::function<bool(const SoakCase&)>;

struct ShrinkOptions {
  std::size_t test_count_max = 3000;              // calls of the predicate
  std::function<bool()> is_over;                  // called before each test: true ends the search; may be empty
  std::optional<std::uint64_t> first_wrong_tick;  // if known: no later tick is tried
  bool keeps_method = false;                      // keeps the settings that define how the engine computes
  bool keeps_course = false;                      // keeps ticks and gravity
};

struct ShrinkResult {
  SoakCase smallest;
  std::size_t test_count = 0;  // calls of the predicate
};

/// Removes ticks, inputs, bodies (with their joints, forces and inputs), joints, forces and prototypes, and resets
/// other fields to defaults. Ids are renumbered. Ends when nothing more can be removed, or at the limit of tests.
/// Requires: still_fails(failing).
ShrinkResult shrink(const SoakCase& failing, const CaseFails& still_fails, const ShrinkOptions& options = {});

/// The case with only these bodies, by index, ascending. Joints, forces and inputs of other bodies are removed. Ids of
/// spawned bodies are renumbered.
SoakCase with_bodies(const SoakCase& soak_case, const std::vector<std::size_t>& kept);
/// The same for joints and their inputs.
SoakCase with_joints(const SoakCase& soak_case, const std::vector<std::size_t>& kept);
/// The same for inputs. Ids are renumbered if only `spawn` creates bodies.
SoakCase with_inputs(const SoakCase& soak_case, const std::vector<std::size_t>& kept);

}  // namespace ticktrue::soak
