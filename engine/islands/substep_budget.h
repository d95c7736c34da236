// The budget of automatic substeps: the work of a tick, bounded by that of a number of fixed substeps.
// SPDX-License-Identifier: MIT
//
// Work is counted, not timed, so that every machine cuts the same ticks. Its unit is one contact, solved once.
#pragma once

#include <cstdint>

#include "engine/model/model.h"
#include "engine/model/state.h"
#include "engine/model/tick_lists.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct IslandWork;

/// Limits the substeps of islands to the budget. The rest of the budget is left to resting impacts. Requires:
/// tick.island_level, work.island_awake. Only with a budget.
void apply_budget(const Model& model, State& state, TickLists& tick, IslandWork& work);

/// Saves the work that is left, and counts the tick if a shock was left before it had settled. Only with a budget.
void store_budget(const TickLists& tick, State& state);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
