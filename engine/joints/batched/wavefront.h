// The passes over joints in one go: level by level each pass follows the one before, as soon as its bodies are done.
// SPDX-License-Identifier: MIT
//
// A substep is passes over all joints, level after level, and between them steps of all bodies. A joint sees nothing
// but its two bodies, so its turn in a pass may come when these are done with the pass before: when that is beyond the
// last level that moves either. In a net that is a few levels on, and dozens of levels of different passes are in work
// at a time: bodies and joints come from memory once per tick instead of once per pass, and threads that each do some
// of the passes follow each other through the levels, waiting only for the one ahead. Each body meets its joints and
// its own steps in the order of the plain passes: the same bits.
#pragma once

#include "engine/model/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Whether the scene's solver, integrator and forces leave bodies to joints alone, but for steps of their own.
bool allows_wavefront(const Model& model);
/// Whether in this tick nothing but joints acts on the bodies of a group.
bool is_left_to_joints(const Scratch& scratch, const SolverSet& set);
/// How many lines of passes there are at most: one for each thread.
std::size_t wavefront_line_count(const Scratch& scratch);
/// Makes joints ready for it: what nobody reads is written to a record of the level's own. Call before batches are
/// filled.
void separate_level_sinks(Scratch& scratch);

/// All substeps of a group. Requires: JointPlan::uses_wavefront, is_left_to_joints; prepare_joints; the integrator's
/// begin.
void solve_wavefront(State& state, Scratch& scratch, const SolverSet& set);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
