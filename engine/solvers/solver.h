// The solvers. Each advances the state by one tick, in one function that shows its whole loop.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "engine/model/model.h"
#include "engine/model/stage.h"
#include "engine/solvers/solver_work.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The stage of this kind. It shares its workspace with Restitution.
std::unique_ptr<Stage> make_solver(SolverKind kind, std::shared_ptr<SolverWork> work);

void solve_free_flight(const Model& model, State& state, TickLists& tick, SolverWork& work, Real dt);
void solve_impulse(const Model& model, State& state, TickLists& tick, SolverWork& work, Real dt);
void solve_pgs(const Model& model, State& state, TickLists& tick, SolverWork& work, Real dt);
void solve_tgs_soft(const Model& model, State& state, TickLists& tick, SolverWork& work, Real dt);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
