// The loads of what kinematic bodies and known forces push before them.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/islands/islands.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Estimates the loads and errors of bodies that moving kinematic bodies push: work.pushes. False: nothing is pushed,
/// and work.pushes is as before. Requires: list_supports, work.known_force. `dt`: s, of the tick.
bool estimate_pushes(const Model& model, const State& state, const TickLists& tick, IslandWork& work, Real dt);

/// Estimates the loads and errors of bodies that known forces press together: work.pushes. False: there are none, and
/// work.pushes is as before. Requires: as estimate_pushes, and work.directed.force.
bool estimate_directed_loads(const Model& model, const State& state, const TickLists& tick, IslandWork& work);

/// Sets the levels that measured loads ask for, `level`, to the least where kinematic bodies crush an island: most of
/// their power goes into contacts that give way. Their way alone decides how far these give way. More substeps make
/// them stiffer and raise the force.
void forget_crushed(const Model& model, const State& state, const TickLists& tick, IslandWork& work,
                    std::vector<std::uint32_t>& level);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
