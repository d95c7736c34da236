// Blocks of islands: some islands at a time through all substeps of a tick.
// SPDX-License-Identifier: MIT
//
// Islands are independent. Where only contacts act between bodies, an island can do a whole tick before the next island
// begins. A block of islands stays in a core's own cache for all passes. Threads take blocks without waiting for each
// other. Each body meets its contacts and steps in the order of plain passes, so the bits are the same.
#pragma once

#include "engine/contacts/contact_batch.h"
#include "engine/integrators/motion_rows.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Whether the contacts of this set can be solved in blocks: only contacts act between its bodies, and nothing reads
/// the contacts between substeps or later.
bool allows_blocks(const SolvedSet& solved);

/// All substeps of a set, block by block. Stores impulses in state.contacts. Requires: color_contacts has split the
/// contacts; the integrator has begun.
void solve_blocks(SolvedSet& solved, ContactWorkspace& work, const MotionWorkspace& motion, State& state);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
