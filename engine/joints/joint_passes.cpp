// The passes over all joints of a set.
// SPDX-License-Identifier: MIT
#include "engine/joints/joint_passes.h"

#include "engine/integrators/integrator.h"
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

/// The impulses of rows that hold a position.
JointImpulses rigid_impulses(const JointWork& joint) {
  const JointModel& model = *joint.model;
  JointImpulses impulses = joint.impulses;
  if (!traits_of(model.kind).is_rigid) return {};
  impulses.spring = impulses.motor = 0;
  if (model.kind == JointKind::weld) {
    if (!model.rigid) impulses.linear = {};
    if (!model.rigid_angle) impulses.angular = 0;
  }
  return impulses;
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

void prepare_joint_changes(const SolvedSet& solved, MotionWorkspace& motion) {
  motion.drift.joint_changes.clear();
  if (solved.state.joints.empty() || !(integrator(solved.model.scene.settings.integrator).drift_share > 0)) return;
  motion.drift.joint_changes.assign(solved.state.bodies.size(), Twist{});
}

void find_joint_changes(const SolvedSet& solved, JointWorkspace& work, const std::vector<GearJoint>& gears,
                        const DirectComponents& direct, MotionWorkspace& motion) {
  std::vector<Twist>& changes = motion.drift.joint_changes;
  if (changes.empty()) return;
  work.impulses.clear();
  for (JointWork& joint : work.joints) {
    work.impulses.push_back(joint.impulses);
    joint.impulses = rigid_impulses(joint);
  }
  // Impulses as they are now, on bodies that do not move: what they get is the change by all passes of the substep.
  motion.drift.velocities.clear();
  for (const std::uint32_t row : solved.rows) {
    MovingBody& body = solved.bodies.records[row];
    motion.drift.velocities.push_back({body.velocity, body.angular_velocity});
    body.velocity = {};
    body.angular_velocity = 0;
  }
  warm_start_joints(solved, work);
  warm_start_gears(solved, gears);
  for (std::size_t i = 0; i < solved.rows.size(); ++i) {
    const std::uint32_t row = solved.rows[i];
    MovingBody& body = solved.bodies.records[row];
    if (direct.component_of(row) == DirectComponents::none) changes[row] = {body.velocity, body.angular_velocity};
    body.velocity = motion.drift.velocities[i].linear;
    body.angular_velocity = motion.drift.velocities[i].angular;
  }
  for (std::size_t i = 0; i < work.joints.size(); ++i) work.joints[i].impulses = work.impulses[i];
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
