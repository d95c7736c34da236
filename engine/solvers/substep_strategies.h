// The orders in which tgs_soft does the substeps of a set.
// SPDX-License-Identifier: MIT
//
// solve_in_turn (tgs_soft.cpp) shows the algorithm: pass by pass, each over the whole set. Every other strategy does
// the same passes in an order in which each body meets its constraints and steps as before: the same bits. It is faster
// where less acts on the bodies.
#pragma once

#include "engine/model/solved_set.h"
#include "engine/solvers/solver_work.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Does all substeps of a set, from the velocities after the integrator's begin to the impulses of contacts in `state`.
using SubstepStrategy = void (*)(SolvedSet& solved, TickLists& tick, SolverWork& work, State& state);

/// Pass by pass.
void solve_in_turn(SolvedSet& solved, TickLists& tick, SolverWork& work, State& state);

/// Chooses the strategy of a set. Orders its joints and colours its contacts, which the choice depends on.
/// `some_are_free`: find_constrained. Requires: prepare_mouse_joints.
SubstepStrategy plan_substeps(const SolvedSet& solved, bool some_are_free, SolverWork& work);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
