// The wavefront (time-skewed) sweep over joints: each pass follows the pass before it through the levels.
// SPDX-License-Identifier: MIT
//
// A substep is a sequence of passes over all joints, level by level, with a step of all bodies before some passes. A
// joint reads and writes only its two bodies. Its next pass may begin when no joint of a later level in the pass before
// uses these bodies. In a net this distance is a few levels, so that dozens of levels of different passes are in
// progress together. Bodies and joints are then loaded from memory once per tick instead of once per pass. Several
// threads each take some of the passes, a front, and follow each other through the levels; a thread waits only for the
// front ahead. Each body meets its joints and steps in the order of plain passes: the same bits.
#pragma once

#include <cstddef>

#include "engine/integrators/motion_rows.h"
#include "engine/joints/joint_passes.h"
#include "engine/joints/mouse_joint.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Whether, in this scene, bodies between two passes over joints only take steps of their own.
bool allows_wavefront(const Model& model);
/// Whether in this tick nothing but joints acts on the bodies of a set.
bool is_left_to_joints(const SolvedSet& solved, const std::vector<MouseJoint>& mouse_joints);
/// The largest number of fronts: one for each thread.
std::size_t front_count(const Parallel& parallel);
/// Gives each level a sink of its own, since several levels are solved at once. Call before batches are filled.
void separate_level_sinks(const SolvedSet& solved, JointWorkspace& work);

/// All substeps of a set. Requires: prepare_joints has set JointWorkspace::uses_wavefront; the integrator's begin.
void solve_wavefront(const SolvedSet& solved, JointWorkspace& work, const MotionWorkspace& motion, State& state);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
