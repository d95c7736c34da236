// Impulses become changes of velocity by a warm start of bodies at rest.
// SPDX-License-Identifier: MIT
#include "engine/solvers/joint_changes.h"

#include "engine/integrators/integrator.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

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

void prepare_joint_changes(const SolvedSet& solved, MotionWorkspace& motion) {
  motion.drift.joint_changes.clear();
  if (solved.state.joints.empty() || !(integrator(solved.model.scene.settings.integrator).drift_share > 0)) return;
  motion.drift.joint_changes.assign(solved.state.bodies.size(), Twist{});
}

void find_joint_changes(const SolvedSet& solved, JointWorkspace& work, const std::vector<GearJoint>& gears,
                        const DirectWorkspace& direct, MotionWorkspace& motion) {
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
    if (!direct.holds_body(row)) changes[row] = {body.velocity, body.angular_velocity};
    body.velocity = motion.drift.velocities[i].linear;
    body.angular_velocity = motion.drift.velocities[i].angular;
  }
  for (std::size_t i = 0; i < work.joints.size(); ++i) work.joints[i].impulses = work.impulses[i];
}

void solve_drift_velocities(const SolvedSet& solved, std::uint32_t iterations, JointWorkspace& work,
                            std::vector<GearJoint>& gears, ContactBatches& contacts, MotionWorkspace& motion) {
  auto& [predicted, offsets, changes, velocities, drifts] = motion.drift;
  const Real share = integrator(solved.model.scene.settings.integrator).drift_share;
  velocities.clear();
  drifts.clear();
  for (const std::uint32_t row : solved.rows) {
    MovingBody& body = solved.bodies.records[row];
    velocities.push_back({body.velocity, body.angular_velocity});
    drifts.push_back(drift_velocity(motion, row, body, share));
    body.velocity = drifts.back().linear;
    body.angular_velocity = drifts.back().angular;
  }
  // Twice in turn with joints: the friction of one pass turns a light body back from where a joint has turned it.
  if (iterations > 0 && !work.plan.places().empty()) {
    solve_contacts(solved, contacts);
    limit_push_friction(solved, contacts);
  }
  for (std::uint32_t i = 0; i < iterations; ++i) {
    solve_joints(solved, work, Bias::of_drift);
    solve_gears(solved, gears, Bias::of_drift);
  }
  solve_contacts(solved, contacts);
  limit_push_friction(solved, contacts);
  for (std::size_t i = 0; i < solved.rows.size(); ++i) {
    const std::uint32_t row = solved.rows[i];
    MovingBody& body = solved.bodies.records[row];
    const Twist change{body.velocity - drifts[i].linear, body.angular_velocity - drifts[i].angular};
    changes[row] = {changes[row].linear + change.linear, changes[row].angular + change.angular};
    body.velocity = velocities[i].linear + change.linear;
    body.angular_velocity = velocities[i].angular + change.angular;
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
