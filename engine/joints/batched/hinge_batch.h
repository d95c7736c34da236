// Hinges in batches: packed from the state, solved by kernels, stored back.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "engine/joints/batched/hinge_lanes.h"
#include "engine/joints/batched/pin_batch.h"
#include "engine/joints/joint.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct HingeBatches {
  std::vector<HingeBatch> batches;  // as many are in use as the plan has
  Softness soft;
};

/// Fills the batches of the plan.
void fill_hinges(const Model& model, const State& state, Scratch& scratch, const Softness& soft, Real h);
/// As share_pins (pin_batch.h).
std::size_t share_hinges(Scratch& scratch, std::uint32_t first, std::uint32_t last);
void note_hinges(Scratch& scratch, const JointRange& range);
void warm_start_hinges(Scratch& scratch, const JointRange& range);
void solve_hinges(Scratch& scratch, const JointRange& range, Real h, Bias bias);
/// Impulses back to state.joints, as forces.
void store_hinges(const Scratch& scratch, State& state, Real h);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
