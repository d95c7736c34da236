// The passes over all joints of a set.
// SPDX-License-Identifier: MIT
#include "engine/joints/joint_passes.h"

#include "engine/joints/batched/wavefront.h"
#include "engine/joints/joint_rows.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

JointRun run_of(const SolvedSet& solved, JointWorkspace& work, const JointRange& range) {
  JointWork* joints = work.joints.data();
  return {joints + range.first, joints + range.last, solved.bodies.records.data()};
}

/// Calls body(first, last) for all batches of plain revolute joints, in chunks.
template <typename Body>
void for_revolutes(const Parallel& parallel, std::size_t count, const Body& body) {
  parallel.for_chunks(count, parallel.chunk_size(count, joint_batches_per_chunk_least, 1),
                      [&](const Chunk& chunk) { body(chunk.begin, chunk.end); });
}

}  // namespace

void plan_joints(const SolvedSet& solved, bool may_use_wavefront, std::span<const std::uint8_t> left_out,
                 JointWorkspace& work) {
  work.uses_wavefront = false;
  if (solved.state.joints.empty()) return work.plan.clear();
  work.plan.follow(solved, left_out, work.order);
  const LevelSchedule& schedule = work.plan.schedule();
  work.uses_wavefront =
      schedule.exists && may_use_wavefront && schedule.body_rows.size() == solved.rows.size();  // each has joints
}

void prepare_joints(const SolvedSet& solved, JointWorkspace& work) {
  const Softness soft = make_soft(joint_hertz_times_h / solved.set.h, joint_damping_ratio, solved.set.h);
  const JointPlan& plan = work.plan;
  work.joints.clear();
  work.revolutes.soft = soft;
  work.revolutes.order = plan.in_levels() ? RevoluteOrder::levels : RevoluteOrder::serial;
  work.driven_revolutes.soft = soft;
  if (solved.state.joints.empty()) return;
  raise_inertias(solved, plan.places(), work.torques);
  for (const std::uint32_t place : plan.scalar()) work.joints.push_back(make_joint(solved, plan.places()[place], soft));
  if (work.uses_wavefront) separate_level_sinks(solved, work);
  reserve_revolutes(solved, work);
  if (!work.uses_wavefront)
    for_revolutes(solved.parallel(), plan.revolutes().size(),
                  [&](std::size_t first, std::size_t last) { fill_revolutes(solved, work, first, last); });
  fill_driven_revolutes(solved, work);
  if (work.uses_wavefront) return;
  for (const JointRange& range : plan.ranges()) {
    if (range.path == JointPath::revolute) separate_revolute_sinks(solved.bodies, range, work.revolutes);
    if (range.path == JointPath::driven_revolute)
      separate_driven_revolute_sinks(solved.bodies, range, work.driven_revolutes);
  }
}

std::span<const std::uint8_t> find_jointed_bodies(const SolvedSet& solved, JointWorkspace& work) {
  work.is_jointed.clear();
  if (work.plan.places().empty() || solved.contacts().empty()) return {};
  work.is_jointed.resize(solved.state.bodies.size());
  for (const JointPlace& place : work.plan.places())
    for (const std::uint32_t row : {place.body_a, place.body_b})
      if (row != no_reference) work.is_jointed[row] = 1;
  return work.is_jointed;
}

void save_velocities_of(const SolvedSet& solved, JointWorkspace& work, const JointRange& range) {
  if (!range.springs) return;
  if (range.path == JointPath::driven_revolute)
    save_driven_revolutes(solved, work, range);
  else
    functions_of(range.kind).save_velocities(run_of(solved, work, range));
}

void warm_start_range(const SolvedSet& solved, JointWorkspace& work, const JointRange& range, Poses poses,
                      std::size_t front) {
  if (range.path == JointPath::revolute)
    warm_start_revolutes(solved, work, range, poses, front);
  else if (range.path == JointPath::driven_revolute)
    warm_start_driven_revolutes(solved, work, range);
  else
    functions_of(range.kind).warm_start(run_of(solved, work, range));
}

void solve_range(const SolvedSet& solved, JointWorkspace& work, const JointRange& range, Bias bias, std::size_t front) {
  if (range.path == JointPath::revolute)
    solve_revolutes(solved, work, range, bias, front);
  else if (range.path == JointPath::driven_revolute)
    solve_driven_revolutes(solved, work, range, bias);
  else
    functions_of(range.kind).solve(run_of(solved, work, range), solved.set.h, bias);
}

void save_joint_velocities(const SolvedSet& solved, JointWorkspace& work) {
  for (const JointRange& range : work.plan.ranges()) save_velocities_of(solved, work, range);
}

void warm_start_joints(const SolvedSet& solved, JointWorkspace& work) {
  for (const JointRange& range : work.plan.ranges()) warm_start_range(solved, work, range, Poses::moved, 0);
}

void solve_joints(const SolvedSet& solved, JointWorkspace& work, Bias bias) {
  for (const JointRange& range : work.plan.ranges()) solve_range(solved, work, range, bias, 0);
}

void store_joints(const SolvedSet& solved, const JointWorkspace& work, State& state) {
  const Real inv_h = 1 / solved.set.h;
  for (const JointWork& joint : work.joints) {
    const JointImpulses& impulses = joint.impulses;
    JointRow& row = state.joints[joint.row];
    row.linear_force = stored(inv_h * impulses.linear);
    row.torque = stored(inv_h * impulses.angular);
    row.spring_force = stored(inv_h * impulses.spring);
    row.lower_force = stored(inv_h * impulses.lower);
    row.upper_force = stored(inv_h * impulses.upper);
    row.motor_force = stored(inv_h * impulses.motor);
  }
  if (!work.uses_wavefront)
    for_revolutes(solved.parallel(), work.plan.revolutes().size(), [&](std::size_t first, std::size_t last) {
      store_revolutes(work.revolutes, first, last, solved.set.h, state);
    });
  store_driven_revolutes(solved, work, state);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
