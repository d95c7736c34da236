// Shock propagation: a body that hits a pile at rest is stopped by the whole pile within one substep.
// SPDX-License-Identifier: MIT
//
// One pass per substep propagates an impact through few contacts only. Meanwhile the boxes of a tower move with a share
// of its speed. In a substep with an impact, the contacts of the island are therefore solved, rigid, until velocities
// converge. Only with automatic substeps.
#pragma once

#include "engine/model/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Notes how fast landings close, and the impulses of all contacts. Call before they are warm started.
void begin_resting_impacts(Scratch& scratch, const SolverSet& set);
/// If a resting impact has hit in the pass before: the change of speed, m/s, below which the shock has propagated. Else
/// 0.
Real settled_speed(const State& state, const Scratch& scratch, const SolverSet& set);
/// Rigid passes until no body's velocity changes by more than `settled`.
void propagate_shock(const Model& model, const State& state, Scratch& scratch, const SolverSet& set, Real settled);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
