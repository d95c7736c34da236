// Joints with an axis fixed in body A along which B's anchor slides: prismatic (B does not turn), wheel (B turns).
// SPDX-License-Identifier: MIT
// Source: Catto, "Modeling and Solving Constraints", GDC 2009 (line and prismatic constraints); rows: joint_rows.h.
//
// linear.x = across the axis; angular = the angle (prismatic). spring, lower, upper act along the axis, the motor along
// it (prismatic) or about the angle (wheel). d = from A's anchor to B's; impulses act at B's anchor on both bodies, so
// the lever on A is (d + r_a) x axis.
#include "engine/constraints/joint_rows.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

struct Slide {
  LineRow along;
  LineRow across;
  Real translation;  // of B's anchor along the axis, from A's, m
  Real deviation;    // across, m
};

Slide slide_of(const JointWork& joint, const JointBodies& pair) {
  const Vec2 axis = rotate(pair.a.turned, joint.axis);
  const Vec2 normal = cross(Real(1), axis);
  const Vec2 arm_b = rotate(pair.b.turned, joint.anchor_b);
  const Vec2 arm_a = (joint.apart + (pair.b.moved - pair.a.moved)) + arm_b;  // d + r_a
  const Vec2 d = arm_a - rotate(pair.a.turned, joint.anchor_a);
  return {line_row(joint, axis, arm_a, arm_b), line_row(joint, normal, arm_a, arm_b), dot(axis, d), dot(normal, d)};
}

void prepare_slide(JointWork& joint, Real h) {
  const MovingBody at_start{{0, 0}, 0, {0, 0}, {1, 0}};
  const Slide slide = slide_of(joint, {at_start, at_start});
  joint.spring = spring_step(joint.model->spring, slide.along.mobility, h);
}

void note_slide(JointWork& joint, const JointBodies& pair) {
  joint.start_speed = slide_of(joint, pair).along.speed(pair);
}

void solve_spring_along(JointWork& joint, const Slide& slide, JointBodies& pair, Bias bias) {
  if (!joint.model->spring.exists || bias == Bias::off) return;
  solve_spring(joint, slide.along, pair, joint.spring, slide.translation, joint.start_speed, no_impulse_limit,
               joint.impulses.spring);
}

// ---- Prismatic ----

void warm_start_prismatic(const JointWork& joint, JointBodies& pair) {
  const Slide slide = slide_of(joint, pair);
  warm_start_row(joint, slide.along, pair);
  slide.across.apply(joint, pair, joint.impulses.linear.x);
  angle_row(joint).apply(joint, pair, joint.impulses.angular);
}

void solve_prismatic(JointWork& joint, JointBodies& pair, Real h, Bias bias) {
  if (!moves_something(joint)) return;
  const JointModel& model = *joint.model;
  const Slide slide = slide_of(joint, pair);
  solve_spring_along(joint, slide, pair, bias);
  if (model.has_motor)
    solve_motor(joint, slide.along, pair, joint.motor_speed, joint.motor_impulse_max, joint.impulses.motor);
  if (model.has_limits) solve_limits(joint, slide.along, pair, slide.translation, h, bias);

  const Softness soft = softness(joint, bias);
  const AngleRow angle = angle_row(joint);
  if (angle.mobility <= 0) {
    solve_rigid(joint, slide.across, pair, slide.deviation, soft, joint.impulses.linear.x);
    return;
  }
  // 2 x 2: across the axis and about the angle, by Cramer's rule.
  const Real k12 = joint.inv_inertia_a * slide.across.lever_a + joint.inv_inertia_b * slide.across.lever_b;
  const Real rate = slide.across.speed(pair) + soft.bias_rate * slide.deviation;
  const Real spin = angle.speed(pair) + soft.bias_rate * relative_angle(joint, pair);
  const Real inv_determinant = 1 / (slide.across.mobility * angle.mobility - k12 * k12);
  const Real p = inv_determinant * (angle.mobility * rate - k12 * spin);
  const Real t = inv_determinant * (slide.across.mobility * spin - k12 * rate);
  const Real across = -(soft.mass_scale * p) - soft.impulse_scale * joint.impulses.linear.x;
  const Real turning = -(soft.mass_scale * t) - soft.impulse_scale * joint.impulses.angular;
  joint.impulses.linear.x += across;
  joint.impulses.angular += turning;
  slide.across.apply(joint, pair, across);
  angle.apply(joint, pair, turning);
}

// ---- Wheel ----

void warm_start_wheel(const JointWork& joint, JointBodies& pair) {
  const Slide slide = slide_of(joint, pair);
  slide.along.apply(joint, pair, joint.impulses.spring + (joint.impulses.lower - joint.impulses.upper));
  slide.across.apply(joint, pair, joint.impulses.linear.x);
  angle_row(joint).apply(joint, pair, joint.impulses.motor);
}

void solve_wheel(JointWork& joint, JointBodies& pair, Real h, Bias bias) {
  if (!moves_something(joint)) return;
  const JointModel& model = *joint.model;
  const Slide slide = slide_of(joint, pair);
  solve_spring_along(joint, slide, pair, bias);
  if (model.has_motor)
    solve_motor(joint, angle_row(joint), pair, joint.motor_speed, joint.motor_impulse_max, joint.impulses.motor);
  if (model.has_limits) solve_limits(joint, slide.along, pair, slide.translation, h, bias);
  solve_rigid(joint, slide.across, pair, slide.deviation, softness(joint, bias), joint.impulses.linear.x);
}

}  // namespace

constexpr JointFunctions prismatic_joint{JointKind::prismatic, prepare_slide, note_each<note_slide>,
                                         warm_start_each<warm_start_prismatic>, solve_each<solve_prismatic>};
constexpr JointFunctions wheel_joint{JointKind::wheel, prepare_slide, note_each<note_slide>,
                                     warm_start_each<warm_start_wheel>, solve_each<solve_wheel>};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
