// The solvers: each advances the state by one tick, in one function that shows its whole loop.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "engine/model/model.h"
#include "engine/model/scratch.h"
#include "engine/model/stage.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The stage of this kind.
std::unique_ptr<Stage> make_solver(SolverKind kind);

void solve_free_flight(const Model& model, State& state, Scratch& scratch, Real dt);
void solve_impulse(const Model& model, State& state, Scratch& scratch, Real dt);
void solve_pgs(const Model& model, State& state, Scratch& scratch, Real dt);
void solve_tgs_soft(const Model& model, State& state, Scratch& scratch, Real dt);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
