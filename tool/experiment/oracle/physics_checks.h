// Rules of physics that runs of a world are held against.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tool/experiment/oracle/runs.h"

namespace ticktrue::verifier::soak {

/// The dynamic bodies of a world and the joints between them, without gravity, forces, inputs, damping, sleep and
/// bounds: nothing acts on them from outside. Nothing where fewer than two bodies are left or the scene is not legal.
std::optional<SoakCase> in_free_space(const SoakCase& soak_case);

/// Runs the world in free space and compares its momentum before and after each tick. The bound is that of rounding:
/// each of the 4 n substeps' velocity changes of a constraint row rounds at most three times, by half a unit in the
/// last place of the largest velocity, in each of its two bodies; twice that, since velocities inside a tick are only
/// known by how far bodies moved.
std::optional<Finding> check_momentum(const RunContext& context, const BaseRun& base);

/// What is counted, not refused: docs/soak.md.
inline constexpr std::array<std::string_view, 5> physics_checks{"energy", "joint_gap", "overlap", "ran_away",
                                                                "non_finite"};
struct PhysicsCounts {
  std::string cause;                                 // "tgs_soft rk4 with joints"
  std::array<bool, physics_checks.size()> broken{};  // [check]
};
PhysicsCounts count_physics(const RunContext& context, const BaseRun& base);

}  // namespace ticktrue::verifier::soak
