// Joints with a bounded force: motor (drives B to a pose relative to A), friction (slows B relative to A), target
// (pulls B to a point).
// SPDX-License-Identifier: MIT
// Source: Catto, "Modeling and Solving Constraints", GDC 2009; bounds as in Coulomb friction: the sum of impulses of a
// substep stays within h times the largest force. Rows: joint_rows.h.
//
// linear = the point's two rows, angular = the angle (motor, friction).
// Motor: B's origin to `offset` in A's frame, the angle to `angle_offset`; by `spring`, or as stiffly as rigid rows if
// the scene has no spring.
// Friction: at B's centre of mass, against the point of A at the same place.
// Target: anchor_a is the point of the world, A the dummy body.
#include "engine/joints/joint_rows.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// The spring of the scene, or one as stiff as rigid rows. The relax pass leaves springs out, since a relax pass would
/// remove a bounded force.
SpringModel drive_of(const JointModel& model, Real h) {
  if (!model.rigid) return model.spring;
  const double omega = 2 * pi * static_cast<double>(joint_hertz_times_h / h);
  return {true, false, omega * omega, 2 * static_cast<double>(joint_damping_ratio) * omega};
}

void warm_start_drive(const JointWork& joint, JointBodies& pair) {
  angle_row(joint).apply(joint, pair, joint.impulses.angular);
  point_row(joint, pair, ActsAt::anchor_b).apply(joint, pair, joint.impulses.linear);
}

void save_drive(JointWork& joint, const JointBodies& pair) {
  joint.start_speed = angle_row(joint).speed(pair);
  joint.start_velocity = point_row(joint, pair, ActsAt::anchor_b).velocity(pair);
}

// ---- Motor ----

void describe_motor(JointModel& model, const Joint& joint, const JointCenters& centers) {
  model.anchor_a = from_center(joint.offset, centers.a);
  model.anchor_b = from_center({}, centers.b);
  model.reference = rotation_of(joint.angle_offset);
  model.rigid = !joint.spring;
}

void prepare_motor(JointWork& joint, Real h) {
  const SpringModel spring = drive_of(*joint.model, h);
  joint.spring = spring_step(spring, angle_row(joint).mobility, h);
  prepare_point_spring(joint, spring, ActsAt::anchor_b, h);
}

void solve_motor_joint(JointWork& joint, JointBodies& pair, Real, Bias bias) {
  if (bias != Bias::on) return;
  solve_spring(joint, angle_row(joint), pair, joint.spring, relative_angle(joint, pair), joint.start_speed,
               joint.angular_impulse_max, joint.impulses.angular);
  solve_point_spring(joint, point_row(joint, pair, ActsAt::anchor_b), pair, joint.impulse_max);
}

// ---- Friction ----

void describe_friction(JointModel& model, const Joint&, const JointCenters&) {
  model.anchor_a = {};
  model.anchor_b = {};
}

void prepare_friction(JointWork&, Real) {}

void solve_friction_joint(JointWork& joint, JointBodies& pair, Real, Bias bias) {
  if (bias == Bias::of_drift) return;
  solve_motor(joint, angle_row(joint), pair, Real(0), joint.angular_impulse_max, joint.impulses.angular);
  if (!moves_something(joint)) return;
  const PointRow point = point_row(joint, pair, ActsAt::anchor_b);
  const Vec2 total = clamped(joint.impulses.linear - point.solved(point.velocity(pair)), joint.impulse_max);
  point.apply(joint, pair, total - joint.impulses.linear);
  joint.impulses.linear = total;
}

// ---- Target ----

void describe_target(JointModel& model, const Joint& joint, const JointCenters&) {
  model.anchor_a = {static_cast<Real>(joint.offset.x), static_cast<Real>(joint.offset.y)};
  model.rigid = !joint.spring;
}

void prepare_target(JointWork& joint, Real h) {
  prepare_point_spring(joint, drive_of(*joint.model, h), ActsAt::anchor_b, h);
}

void solve_target(JointWork& joint, JointBodies& pair, Real, Bias bias) {
  if (bias != Bias::on) return;
  solve_point_spring(joint, point_row(joint, pair, ActsAt::anchor_b), pair, joint.impulse_max);
}

}  // namespace

constexpr JointFunctions motor_joint{describe_motor, prepare_motor, save_each<save_drive>,
                                     warm_start_each<warm_start_drive>, solve_each<solve_motor_joint>};
constexpr JointFunctions friction_joint{describe_friction, prepare_friction, save_each<save_drive>,
                                        warm_start_each<warm_start_drive>, solve_each<solve_friction_joint>};
constexpr JointFunctions target_joint{describe_target, prepare_target, save_each<save_drive>,
                                      warm_start_each<warm_start_drive>, solve_each<solve_target>};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
