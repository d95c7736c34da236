// Stages that consist of one function.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model/model.h"
#include "engine/model/state.h"
#include "engine/model/tick_lists.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void apply_inputs(const Model& model, State& state, TickLists& tick, Real dt);
/// Removes bodies that have left the scene's bounds.
void cull(const Model& model, State& state, TickLists& tick, Real dt);
void measure_idle_time(const Model& model, State& state, TickLists& tick, Real dt);

/// Removes the row, its contacts, its joints, the gears of these joints, and the pointers that hold it. The forces of
/// this tick's inputs stay with their bodies.
void remove_body(const Model& model, State& state, TickLists& tick, std::size_t row);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
