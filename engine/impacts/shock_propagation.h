// Landings: what hits a pile at rest is stopped by the whole pile at once, so that nothing in it has time to move.
// SPDX-License-Identifier: MIT
//
// One pass per substep hands an impact on by a few contacts only; while it is on its way through a tower, its boxes
// move with a share of its speed. In a substep with an impact the contacts of the island are therefore solved, rigid,
// until velocities stay as they are. Where substeps are automatic.
#pragma once

#include "engine/model/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Notes how fast landings close, and the impulses of all contacts. Call before they are warm started.
void begin_resting_impacts(Scratch& scratch, const SolverSet& set);
/// Whether a landing has hit in the pass before: below which change of speed, m/s, it has been passed on; else 0.
Real settled_speed(const State& state, const Scratch& scratch, const SolverSet& set);
/// Rigid passes until no body's velocity changes by more than `settled`.
void propagate_shock(const Model& model, const State& state, Scratch& scratch, const SolverSet& set, Real settled);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
