// Gears: the coordinates of two joints are coupled by a ratio, on up to four bodies.
// SPDX-License-Identifier: MIT
//
// Gears are solved one at a time in the order of the scene, after all other joints of a pass. Their rows act on up to
// four bodies, so they are in no level and no batch of joints.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/joints/joint.h"
#include "engine/joints/joint_inertia.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// A gear prepared for one tick.
struct GearJoint {
  std::uint32_t row;       // in State::joints
  std::uint32_t gear_row;  // in State::gears
  const GearModel* model;
  std::array<JointWork, 2> parts;  // its joints: their bodies, anchors and axes; impulses are not used
  Real ratio;
  std::array<double, 2> coordinates;  // of the parts when they were last seen, with all turns, rad or m
  bool may_have_moved;                // the bodies have moved since
  Real impulse;                       // on the first coordinate, N s or N m s
};

/// The torques that the forces of gears in the last substep exert on their bodies, for prepare_joints.
void find_gear_torques(const SolvedSet& solved, std::vector<BodyTorque>& torques);
/// Prepares the gears of a set. Requires: prepare_joints.
void prepare_gears(const SolvedSet& solved, std::vector<GearJoint>& gears);
void warm_start_all_gears(const SolvedSet& solved, const std::vector<GearJoint>& gears);
void solve_all_gears(const SolvedSet& solved, std::vector<GearJoint>& gears, Bias bias);
// Most scenes have no gears: they are asked inline.
inline void warm_start_gears(const SolvedSet& solved, const std::vector<GearJoint>& gears) {
  if (!gears.empty()) warm_start_all_gears(solved, gears);
}
inline void solve_gears(const SolvedSet& solved, std::vector<GearJoint>& gears, Bias bias) {
  if (!gears.empty()) solve_all_gears(solved, gears, bias);
}
/// Stores impulses in state.joints, as forces, and coordinates in state.gears.
void store_gears(const SolvedSet& solved, std::vector<GearJoint>& gears, State& state);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
