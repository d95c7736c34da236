// Groups: what is solved together with one number of substeps. Without islands there is one group of everything.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// One group of all bodies that move and all contacts. Requires: prepare_bodies.
void group_everything(const Model& model, const State& state, Scratch& scratch);

/// Begins the work on a group, with substeps of length h: sets scratch.moving_rows, and puts what is kinematic, and
/// thus in every group, back to where it was. Requires: prepare_bodies.
void enter_group(const State& state, Scratch& scratch, SolveGroup& group, Real h);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
