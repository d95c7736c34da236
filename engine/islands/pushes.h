// The loads of what kinematic bodies push before them.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/islands/islands.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Estimates the loads and errors of bodies that moving kinematic bodies push: work.pushes. False: nothing is pushed,
/// and work.pushes is as before. Requires: list_supports, work.known_force. `dt`: s, of the tick.
bool estimate_pushes(const Model& model, const State& state, const TickLists& tick, IslandWork& work, Real dt);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
