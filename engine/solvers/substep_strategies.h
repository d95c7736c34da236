// The orders in which tgs_soft runs the substeps of a set.
// SPDX-License-Identifier: MIT
//
// solve_in_turn (tgs_soft.cpp) shows the algorithm: pass by pass, each over the whole set. Every other strategy runs
// the same passes in another order. Each body still meets its constraints and steps in the same order, so the bits are
// the same. Other strategies are faster where less acts on the bodies.
#pragma once

#include "engine/model/solved_set.h"
#include "engine/solvers/solver_work.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Runs all substeps of a set. Begins after the integrator's begin; ends with the impulses of contacts in `state`.
using SubstepStrategy = void (*)(SolvedSet& solved, TickLists& tick, SolverWork& work, State& state);

/// One pass after another, each over the whole set.
void solve_in_turn(SolvedSet& solved, TickLists& tick, SolverWork& work, State& state);

/// Chooses the strategy of a set. Orders its joints and colours its contacts, since the choice depends on them.
/// `some_are_free`: find_constrained. Requires: prepare_mouse_joints.
SubstepStrategy plan_substeps(const SolvedSet& solved, bool some_are_free, SolverWork& work);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
