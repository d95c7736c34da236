// Blocks of islands: some islands at a time through all substeps of a tick.
// SPDX-License-Identifier: MIT
//
// Islands are independent. Where only contacts act between bodies, an island can do a whole tick before the next island
// begins. A block of islands stays in a core's own cache for all passes. Threads take blocks and need not wait for each
// other. Each body meets its contacts and steps in the order of plain passes: the same bits.
#pragma once

#include "engine/model/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Whether the contacts of this set can be solved in blocks: nothing else acts between its bodies, and nothing needs
/// the contacts between substeps or later. Requires: prepare_mouse_joints, prepare_joints.
bool allows_blocks(const Model& model, const State& state, const Scratch& scratch, const SolverSet& set);

/// All substeps of a set, block by block. Stores impulses in state.contacts. Requires: color_contacts has split the
/// contacts; the integrator has begun.
void solve_blocks(const Model& model, State& state, Scratch& scratch, const SolverSet& set);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
