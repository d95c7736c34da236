// Solver sets: bodies and contacts solved together with one number of substeps. Without islands there is one set.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Makes one set of all moving bodies and all contacts. Requires: prepare_bodies.
void put_all_into_one_set(const Model& model, const State& state, const SolverBodies& bodies, TickLists& tick);

/// The set of this index. Requires: prepare_bodies.
SolvedSet solver_set(const Model& model, const State& state, TickLists& tick, SolverBodies& bodies,
                     std::uint32_t index);
/// Begins the set, with substeps of length h: resets kinematic bodies, which are in every set, to the start of the
/// tick.
SolvedSet enter_solver_set(const Model& model, const State& state, TickLists& tick, SolverBodies& bodies,
                           std::uint32_t index, Real h);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
