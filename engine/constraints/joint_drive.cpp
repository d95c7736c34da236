// Joints with a bounded force: motor (drives B to a pose beside A), friction (slows B against A), target (pulls B).
// SPDX-License-Identifier: MIT
// Source: Catto, "Modeling and Solving Constraints", GDC 2009; bounds as in Coulomb friction: the sum of impulses of a
// substep stays within h times the largest force. Rows: joint_rows.h.
//
// linear = the point's two rows, angular = the angle (motor, friction).
// Motor: B's origin to `offset` in A's frame, the angle to `angle_offset`; rigid, or by `spring` where there is one.
// Friction: at B's centre of mass, against the point of A that lies there.
// Target: anchor_a is the point of the world, A the resting record.
#include "engine/constraints/joint_rows.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

void warm_start_drive(const JointWork& joint, JointBodies& pair) {
  angle_row(joint).apply(joint, pair, joint.impulses.angular);
  point_row(joint, pair, ActsAt::anchor_b).apply(joint, pair, joint.impulses.linear);
}

void note_drive(JointWork& joint, const JointBodies& pair) {
  joint.start_speed = angle_row(joint).speed(pair);
  joint.start_velocity = point_row(joint, pair, ActsAt::anchor_b).velocity(pair);
}

void solve_point(JointWork& joint, JointBodies& pair, Bias bias) {
  const PointRow point = point_row(joint, pair, ActsAt::anchor_b);
  if (joint.model->rigid)
    solve_rigid_point(joint, point, pair, softness(joint, bias), joint.impulse_max, joint.impulses.linear);
  else if (bias == Bias::on)
    solve_point_spring(joint, point, pair, joint.impulse_max);
}

// ---- Motor ----

void prepare_motor(JointWork& joint, Real h) {
  joint.spring = spring_step(joint.model->spring, angle_row(joint).mobility, h);
  prepare_point_spring(joint, joint.model->spring, ActsAt::anchor_b, h);
}

void solve_motor_joint(JointWork& joint, JointBodies& pair, Real, Bias bias) {
  const AngleRow row = angle_row(joint);
  if (!joint.model->rigid) {
    if (bias == Bias::on)
      solve_spring(joint, row, pair, joint.spring, relative_angle(joint, pair), joint.start_speed,
                   joint.angular_impulse_max, joint.impulses.angular);
  } else if (row.mobility > 0) {
    const Softness soft = softness(joint, bias);
    const Real rate = row.speed(pair) + soft.bias_rate * relative_angle(joint, pair);
    const Real old_impulse = joint.impulses.angular;
    const Real total = clamped((old_impulse - soft.mass_scale * rate / row.mobility) - soft.impulse_scale * old_impulse,
                               joint.angular_impulse_max);
    row.apply(joint, pair, total - old_impulse);
    joint.impulses.angular = total;
  }
  solve_point(joint, pair, bias);
}

// ---- Friction ----

void prepare_friction(JointWork&, Real) {}

void solve_friction_joint(JointWork& joint, JointBodies& pair, Real, Bias) {
  solve_motor(joint, angle_row(joint), pair, Real(0), joint.angular_impulse_max, joint.impulses.angular);
  solve_rigid_point(joint, point_row(joint, pair, ActsAt::anchor_b), pair, Softness{}, joint.impulse_max,
                    joint.impulses.linear);
}

// ---- Target ----

void prepare_target(JointWork& joint, Real h) {
  prepare_point_spring(joint, joint.model->spring, ActsAt::anchor_b, h);
}

void solve_target(JointWork& joint, JointBodies& pair, Real, Bias bias) {
  solve_point(joint, pair, bias);
}

}  // namespace

constexpr JointFunctions motor_joint{JointKind::motor, prepare_motor, note_each<note_drive>,
                                     warm_start_each<warm_start_drive>, solve_each<solve_motor_joint>};
constexpr JointFunctions friction_joint{JointKind::friction, prepare_friction, note_each<note_drive>,
                                        warm_start_each<warm_start_drive>, solve_each<solve_friction_joint>};
constexpr JointFunctions target_joint{JointKind::target, prepare_target, note_each<note_drive>,
                                      warm_start_each<warm_start_drive>, solve_each<solve_target>};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
