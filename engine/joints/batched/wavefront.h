// The wavefront (time-skewed) sweep over joints: each pass follows the pass before it through the levels.
// SPDX-License-Identifier: MIT
//
// A substep is a sequence of passes over all joints, level by level, with a step of all bodies before some passes. A
// joint reads and writes only its two bodies. Its next pass may begin when no joint of a later level in the pass before
// uses these bodies. In a net this distance is a few levels, so that dozens of levels of different passes are in
// progress together. Bodies and joints are then loaded from memory once per tick instead of once per pass. Each thread
// takes some consecutive passes, a front, and waits only for the front ahead of it. Each body meets its joints and
// steps in the order of plain passes, so the bits are the same.
#pragma once

#include <cstddef>

#include "engine/integrators/motion_rows.h"
#include "engine/joints/joint_passes.h"
#include "engine/joints/mouse_joint.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Whether, in this scene, bodies only take independent steps between two passes over joints.
bool allows_wavefront(const Model& model);
/// Whether only joints act on the bodies of a set in this tick.
bool is_left_to_joints(const SolvedSet& solved, const std::vector<MouseJoint>& mouse_joints);
/// The largest number of fronts: one for each thread.
std::size_t front_count(const Parallel& parallel);
/// Gives each level its own sink, since several levels are solved at once. Call before batches are filled.
void separate_level_sinks(const SolvedSet& solved, JointWorkspace& work);

/// All substeps of a set. Requires: prepare_joints has set JointWorkspace::uses_wavefront; the integrator has begun.
void solve_wavefront(const SolvedSet& solved, JointWorkspace& work, const MotionWorkspace& motion, State& state);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
