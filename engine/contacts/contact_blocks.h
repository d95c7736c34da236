// Islands of contacts, some at a time through all substeps of a tick.
// SPDX-License-Identifier: MIT
//
// Bodies of an island see nothing of others: where nothing but contacts ties them, an island can pass a whole tick
// before the next begins. A block of islands stays in a core's own cache for all passes, and threads take blocks, with
// nothing to wait for. Each body meets its contacts and its steps in the order of plain passes: the same bits.
#pragma once

#include "engine/model/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Whether the contacts of this group can be solved in blocks: nothing else ties its bodies, or needs its contacts
/// between substeps or later. Requires: prepare_mouse_joints, prepare_joints.
bool allows_blocks(const Model& model, const State& state, const Scratch& scratch, const SolverSet& set);

/// All substeps of a group, block by block, with the impulses back in state.contacts. Requires: color_contacts has
/// split them; the integrator has begun.
void solve_blocks(const Model& model, State& state, Scratch& scratch, const SolverSet& set);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
