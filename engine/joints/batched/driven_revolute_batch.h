// Revolute joints with a spring, limits or a motor, in batches: packed from the state, solved by kernels, stored back.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "engine/joints/batched/driven_revolute_lanes.h"
#include "engine/joints/batched/revolute_batch.h"
#include "engine/joints/joint.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct DrivenRevoluteBatches {
  std::vector<DrivenRevoluteBatch> batches;  // the plan says how many are in use
  Softness soft;
};

/// Fills the batches of the plan.
void fill_driven_revolutes(const Model& model, const State& state, Scratch& scratch, const Softness& soft, Real h);
/// As separate_revolute_sinks (revolute_batch.h).
void separate_driven_revolute_sinks(Scratch& scratch, const JointRange& range);
void save_driven_revolutes(Scratch& scratch, const JointRange& range);
void warm_start_driven_revolutes(Scratch& scratch, const JointRange& range);
void solve_driven_revolutes(Scratch& scratch, const JointRange& range, Real h, Bias bias);
/// Impulses back to state.joints, as forces.
void store_driven_revolutes(const Scratch& scratch, State& state, Real h);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
