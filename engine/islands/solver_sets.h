// Groups: what is solved together with one number of substeps. Without islands there is one group of everything.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// One group of all bodies that move and all contacts. Requires: prepare_bodies.
void put_all_into_one_set(const Model& model, const State& state, Scratch& scratch);

/// Begins the work on a group, with substeps of length h: sets scratch.moving_rows, and puts what is kinematic, and
/// thus in every group, back to where it was. Requires: prepare_bodies.
void enter_solver_set(const State& state, Scratch& scratch, SolverSet& set, Real h);

/// Notes in scratch.is_constrained which bodies have contacts or impacts in this tick. False: not worth it, or bodies
/// depend on each other in other ways.
bool find_constrained(const Model& model, const State& state, Scratch& scratch);
/// Lets the bodies of the group that are not tied pass their substeps at once, and leaves the others in
/// scratch.moving_rows. Requires: find_constrained, and the integrator has begun.
void integrate_free_bodies(Scratch& scratch, const SolverSet& set);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
