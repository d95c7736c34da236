// Solver sets: bodies and contacts solved together with one number of substeps. Without islands there is one set.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Makes one set of all moving bodies and all contacts. Requires: prepare_bodies.
void put_all_into_one_set(const Model& model, const State& state, Scratch& scratch);

/// Begins a set, with substeps of length h: sets scratch.moving_rows and resets kinematic bodies, which are in every
/// set, to the start of the tick. Requires: prepare_bodies.
void enter_solver_set(const State& state, Scratch& scratch, SolverSet& set, Real h);

/// Finds the bodies with contacts or impacts in this tick: scratch.is_constrained. False: it does not pay, or bodies
/// interact in other ways.
bool find_constrained(const Model& model, const State& state, Scratch& scratch);
/// Integrates the unconstrained bodies of the set through all substeps and leaves the others in scratch.moving_rows.
/// Requires: find_constrained, and the integrator has begun.
void integrate_free_bodies(Scratch& scratch, const SolverSet& set);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
