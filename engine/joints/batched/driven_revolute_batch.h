// Revolute joints with a spring, limits or a motor, in batches: packed from the state, solved by kernels, stored back.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "engine/joints/batched/driven_revolute_lanes.h"
#include "engine/joints/batched/revolute_batch.h"
#include "engine/joints/joint.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct DrivenRevoluteBatches {
  std::vector<DrivenRevoluteBatch> batches;  // the plan says how many batches are in use
  Softness soft;
};

template <typename Visit>
void list_fields(DrivenRevoluteBatches& of, const Visit& visit) {
  auto& [batches, soft] = of;
  visit(in_place(batches), soft);
}

/// Fills the batches of the plan.
void fill_driven_revolutes(const SolvedSet& solved, JointWorkspace& work);
/// Same as separate_revolute_sinks (revolute_batch.h).
void separate_driven_revolute_sinks(const SolverBodies& bodies, const JointRange& range, DrivenRevoluteBatches& driven);
void save_driven_revolutes(const SolvedSet& solved, JointWorkspace& work, const JointRange& range);
void warm_start_driven_revolutes(const SolvedSet& solved, JointWorkspace& work, const JointRange& range);
void solve_driven_revolutes(const SolvedSet& solved, JointWorkspace& work, const JointRange& range, Bias bias);
/// Stores the impulses in state.joints, as forces.
void store_driven_revolutes(const SolvedSet& solved, const JointWorkspace& work, State& state);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
