// The passes over all joints of a set.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/joints/batched/driven_revolute_batch.h"
#include "engine/joints/batched/revolute_batch.h"
#include "engine/joints/joint.h"
#include "engine/joints/joint_inertia.h"
#include "engine/joints/joint_plan.h"
#include "engine/model/poison.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The workspace and the caches of the joint solver.
struct JointWorkspace {
  JointPlan plan;
  JointOrderWork order;
  JointTorqueWork torques;
  std::vector<JointWork> joints;  // of the scalar path
  RevoluteBatches revolutes;
  DrivenRevoluteBatches driven_revolutes;
  std::vector<JointImpulses> impulses;   // [joint of the scalar path] while joints holds those of find_joint_changes
  std::vector<std::uint8_t> is_jointed;  // [body]; empty if the set has no joints of the plan
  bool uses_wavefront = false;           // joints are solved by a wavefront sweep
};

template <typename Visit>
void list_fields(JointWorkspace& of, const Visit& visit) {
  auto& [plan, order, torques, joints, revolutes, driven_revolutes, impulses, is_jointed, uses_wavefront] = of;
  visit(plan, order, torques, joints, revolutes, driven_revolutes, impulses, is_jointed, uses_wavefront);
}

/// Orders the joints of a set. `may_use_wavefront`: only joints act on its bodies in this tick. `left_out`: as for
/// order_joints. Requires: prepare_bodies.
void plan_joints(const SolvedSet& solved, bool may_use_wavefront, std::span<const std::uint8_t> left_out,
                 JointWorkspace& work);
/// Prepares the joints of a set. Requires: plan_joints; JointTorqueWork::of_gears is filled.
void prepare_joints(const SolvedSet& solved, JointWorkspace& work);
/// The bodies of the joints of a set: JointWorkspace::is_jointed.
std::span<const std::uint8_t> find_jointed_bodies(const SolvedSet& solved, JointWorkspace& work);
/// Saves the velocities before a substep. Call before the integrator predicts.
void save_joint_velocities(const SolvedSet& solved, JointWorkspace& work);
void warm_start_joints(const SolvedSet& solved, JointWorkspace& work);
void solve_joints(const SolvedSet& solved, JointWorkspace& work, Bias bias);
// The same for some joints, in front `front` of a wavefront sweep (wavefront.h).
void save_velocities_of(const SolvedSet& solved, JointWorkspace& work, const JointRange& range);
void warm_start_range(const SolvedSet& solved, JointWorkspace& work, const JointRange& range, Poses poses,
                      std::size_t front);
void solve_range(const SolvedSet& solved, JointWorkspace& work, const JointRange& range, Bias bias, std::size_t front);
/// Stores the impulses in state.joints, as forces.
void store_joints(const SolvedSet& solved, const JointWorkspace& work, State& state);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
