// Crowds: bodies that overlap several others deeply, as bodies put down in one place do.
// SPDX-License-Identifier: MIT
//
// A contact pushes an overlap out at up to 3 m/s, and the relax pass removes that speed again. In a crowd it cannot:
// 200 bodies in one place burst apart at 100 m/s. The impulses that push a crowd apart are therefore taken back after
// they have moved the bodies.
#pragma once

#include "engine/model/model.h"
#include "engine/model/state.h"
#include "engine/model/tick_lists.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Finds TickLists::deep_counts. Requires: the contacts of all sets are listed.
void find_crowds(const Model& model, const State& state, TickLists& tick);

/// Whether a body of a contact is in a crowd. Requires: some body is.
bool is_crowded(const TickLists& tick, std::uint32_t contact);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
