// Joints with a point constraint: revolute (the bodies rotate freely) and weld (the bodies keep their relative angle).
// SPDX-License-Identifier: MIT
// Source: Catto, "Modeling and Solving Constraints", GDC 2009 (point constraint); rows and softness: joint_rows.h.
//
// Revolute: linear = the point's two rows; spring, motor, lower, upper act about the angle.
// Weld: linear = the point, rigid or sprung; angular = the angle, rigid or sprung; both rigid: one 3 x 3 system.
#include "engine/joints/joint_rows.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

// ---- Revolute ----

void describe_revolute(JointModel& model, const Joint& joint, const JointCenters& centers) {
  describe_reference(model, joint, centers);
  model.is_driven_revolute = model.spring.exists || model.has_limits || model.has_motor;
  model.is_plain_revolute = !model.is_driven_revolute;
}

void prepare_spring_of_angle(JointWork& joint, Real h) {
  if (!joint.model->spring.exists) return;
  const MovingBody at_start{{0, 0}, 0, {0, 0}, {1, 0}};
  const PointRow point = point_row(joint, {at_start, at_start}, ActsAt::middle);
  joint.spring = spring_step(joint.model->spring, constrained_angle_row(joint, point).mobility, h);
}

void prepare_revolute(JointWork& joint, Real h) {
  if (joint.model->is_driven_revolute)
    joint.turning = turning_of(joint.inv_inertia_a, joint.inv_inertia_b, joint.anchor_a, joint.anchor_b, h);
  prepare_spring_of_angle(joint, h);
}

void save_revolute(JointWork& joint, const JointBodies& pair) {
  joint.start_speed = angle_row(joint).speed(pair);
}

void warm_start_revolute(JointWork& joint, JointBodies& pair) {
  bound_impulses(joint, 0);
  warm_start_row(joint, angle_row(joint), pair);
  point_row(joint, pair, ActsAt::middle).apply(joint, pair, joint.impulses.linear);
}

/// The rows of the angle come last: their impulses leave the point as it is, and not the other way round.
void solve_revolute(JointWork& joint, JointBodies& pair, Real h, Bias bias) {
  const JointModel& model = *joint.model;
  const PointRow point = point_row(joint, pair, ActsAt::middle);
  const Vec2 arm_rate = corrects(bias) ? arm_rotation_rate(point.arm_a, point.arm_b, pair, h) : Vec2{0, 0};
  const Softness soft = softness(joint, bias);
  if (!model.is_driven_revolute) return solve_rigid_point(joint, point, pair, soft, arm_rate);
  const ConstrainedAngleRow row = constrained_angle_row(joint, point);
  solve_rigid_point(joint, point, pair, soft, arm_rate, impulse_along(joint.impulses) * row.reaction);
  const Real angle = model.spring.exists || model.has_limits ? relative_angle(joint, pair) : 0;
  if (model.spring.exists && bias == Bias::on)
    solve_spring(joint, row, pair, joint.spring, angle, joint.start_speed, no_impulse_limit, joint.impulses.spring);
  if (model.has_motor && bias != Bias::of_drift)
    solve_motor(joint, row, pair, joint.motor_speed, joint.motor_impulse_max, joint.impulses.motor);
  if (model.has_limits) solve_limits(joint, row, pair, angle, h, bias);
}

// ---- Weld ----

void describe_weld(JointModel& model, const Joint& joint, const JointCenters& centers) {
  describe_reference(model, joint, centers);
  model.rigid = !joint.linear_spring;
  model.rigid_angle = model.holds_angle = !joint.spring;
}

void prepare_weld(JointWork& joint, Real h) {
  if (joint.model->rigid)
    prepare_spring_of_angle(joint, h);
  else
    joint.spring = spring_step(joint.model->spring, angle_row(joint).mobility, h);
  prepare_point_spring(joint, joint.model->linear_spring, ActsAt::middle, h);
}

void save_weld(JointWork& joint, const JointBodies& pair) {
  joint.start_speed = angle_row(joint).speed(pair);
  joint.start_velocity = point_row(joint, pair, ActsAt::middle).velocity(pair);
}

void warm_start_weld(const JointWork& joint, JointBodies& pair) {
  angle_row(joint).apply(joint, pair, joint.impulses.angular);
  point_row(joint, pair, ActsAt::middle).apply(joint, pair, joint.impulses.linear);
}

/// K (p, t) = -(rates): the rows of the point and of the angle together, the angle eliminated first. The remaining
/// matrix of the point is m + a b / (a + b) (|d|^2 - d d^T), d = r_a - r_b. In this form no digits cancel with long
/// arms.
void solve_rigid_weld(JointWork& joint, PointRow row, JointBodies& pair, const Softness& soft) {
  const AngleRow angle = angle_row(joint);
  const Vec2 rate = row.velocity(pair) + soft.bias_rate * row.error;
  const Real spin = angle.speed(pair) + soft.bias_rate * relative_angle(joint, pair);
  const Vec2 coupling = angle_coupling(joint, row);
  const Real inv = 1 / angle.mobility;
  const Real inv_mass = joint.inv_mass_a + joint.inv_mass_b;
  const Real reduced_inv_inertia = inv * joint.inv_inertia_a * joint.inv_inertia_b;
  const Vec2 arm_difference = row.arm_a - row.arm_b;
  row.k11 = inv_mass + reduced_inv_inertia * arm_difference.y * arm_difference.y;
  row.k12 = -(reduced_inv_inertia * arm_difference.x * arm_difference.y);
  row.k22 = inv_mass + reduced_inv_inertia * arm_difference.x * arm_difference.x;
  row.determinant = inv_mass * (inv_mass + reduced_inv_inertia * length_squared(arm_difference));
  const Vec2 p = row.solved(rate - inv * spin * coupling);
  const Real t = inv * (spin - dot(coupling, p));
  const Vec2 linear = -(soft.mass_scale * p) - soft.impulse_scale * joint.impulses.linear;
  const Real angular = -(soft.mass_scale * t) - soft.impulse_scale * joint.impulses.angular;
  joint.impulses.linear = joint.impulses.linear + linear;
  joint.impulses.angular += angular;
  angle.apply(joint, pair, angular);
  row.apply(joint, pair, linear);
}

void solve_weld(JointWork& joint, JointBodies& pair, Real, Bias bias) {
  if (!moves_something(joint)) return;
  const JointModel& model = *joint.model;
  const AngleRow angle = angle_row(joint);
  const PointRow point = point_row(joint, pair, ActsAt::middle);
  const Softness soft = softness(joint, bias);
  if (model.rigid && model.rigid_angle && angle.mobility > 0) {
    solve_rigid_weld(joint, point, pair, soft);
    return;
  }
  if (model.rigid)
    solve_rigid_point(joint, point, pair, soft, {0, 0},
                      joint.impulses.angular * constrained_angle_row(joint, point).reaction);
  if (!model.rigid_angle && bias == Bias::on) {
    const Real error = relative_angle(joint, pair);
    if (model.rigid)
      solve_spring(joint, constrained_angle_row(joint, point), pair, joint.spring, error, joint.start_speed,
                   no_impulse_limit, joint.impulses.angular);
    else
      solve_spring(joint, angle, pair, joint.spring, error, joint.start_speed, no_impulse_limit,
                   joint.impulses.angular);
  }
  if (!model.rigid && bias == Bias::on) solve_point_spring(joint, point, pair, no_impulse_limit);
  if (model.rigid_angle && angle.mobility > 0)
    solve_rigid(joint, angle, pair, relative_angle(joint, pair), soft, joint.impulses.angular);
}

}  // namespace

constexpr JointFunctions revolute_joint{describe_revolute, prepare_revolute, save_each<save_revolute>,
                                        warm_start_each<warm_start_revolute>, solve_each<solve_revolute>};
constexpr JointFunctions weld_joint{describe_weld, prepare_weld, save_each<save_weld>, warm_start_each<warm_start_weld>,
                                    solve_each<solve_weld>};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
