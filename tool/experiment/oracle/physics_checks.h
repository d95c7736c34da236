// Rules of physics that are checked on runs of a world.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tool/experiment/oracle/runs.h"

namespace ticktrue::soak {

/// The dynamic bodies of a world and the joints between them, without gravity, forces, inputs, damping, sleep and
/// bounds. Nothing outside acts on the bodies. Absent if fewer than two bodies are left, or if the scene is invalid.
std::optional<SoakCase> in_free_space(const SoakCase& soak_case);

/// Runs the world in free space, and compares its momentum before and after each tick. The bound is the rounding error.
/// In each of the 4 n passes, a constraint row changes the velocity of its two bodies. Each change rounds at most three
/// times, by half a unit in the last place of the largest velocity. The bound is twice that sum, because displacements
/// only estimate the velocities inside a tick.
std::optional<Finding> check_momentum(const RunContext& context, const BaseRun& base);

/// Checks whose violations are counted but not refused: docs/soak.md.
inline constexpr std::array<std::string_view, 5> physics_checks{"energy", "joint_gap", "overlap", "ran_away",
                                                                "non_finite"};
struct PhysicsCounts {
  std::string cause;                                 // "tgs_soft rk4 with joints"
  std::array<bool, physics_checks.size()> broken{};  // [check]
  bool is_judged = false;                            // by the law of soft constraints: promises_accuracy
  std::vector<std::string> texts;                    // what is off, where, and when
};
PhysicsCounts count_physics(const RunContext& context, const BaseRun& base);

}  // namespace ticktrue::soak
