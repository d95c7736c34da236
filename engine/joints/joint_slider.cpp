// Joints with an axis fixed in body A along which B's anchor slides: prismatic (B keeps its angle), wheel (B rotates
// freely).
// SPDX-License-Identifier: MIT
// Source: Catto, "Modeling and Solving Constraints", GDC 2009 (line and prismatic constraints); rows: joint_rows.h.
//
// linear.x = across the axis; angular = the angle (prismatic). spring, lower and upper act along the axis; the motor
// acts along the axis (prismatic) or about the angle (wheel). d = from A's anchor to B's. Impulses act at B's anchor on
// both bodies, so the lever on A is (d + r_a) x axis.
#include "engine/joints/joint_rows.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

Slide slide_at_start(const JointWork& joint) {
  const MovingBody at_start{{0, 0}, 0, {0, 0}, {1, 0}};
  return slide_of(joint, {at_start, at_start});
}

void save_slide(JointWork& joint, const JointBodies& pair) {
  joint.start_speed = slide_of(joint, pair).along.speed(pair);
}

template <typename Row>
void solve_spring_along(JointWork& joint, const Row& along, JointBodies& pair, Real translation, Bias bias) {
  if (!joint.model->spring.exists || bias != Bias::on) return;
  solve_spring(joint, along, pair, joint.spring, translation, joint.start_speed, no_impulse_limit,
               joint.impulses.spring);
}

/// The change of the deviation in a substep besides the velocity across the axis, per h. It comes from rotating arms,
/// as in a rod (joint_distance.cpp), and from what slides along an axis that rotates. The arm of a wheel's B is left
/// out: a light rod on two axes would gain energy. Bodies that keep their angle meet a lead as one.
Real deviation_rate(const JointWork& joint, const Slide& slide, const JointBodies& pair, Real h) {
  const LineRow& row = slide.across;
  const bool as_one = joint.model->holds_angle && joint.inv_inertia_a + joint.inv_inertia_b > 0;
  Real mobility = row.mobility;
  if (as_one) {
    const Real levers = row.lever_a - row.lever_b;
    const Real share = joint.inv_inertia_b / (joint.inv_inertia_a + joint.inv_inertia_b);
    mobility = (joint.inv_mass_a + joint.inv_mass_b) + joint.inv_inertia_a * share * levers * levers;
  }
  const Real spin = pair.a.angular_velocity;
  const Real turn = h * spin;
  const Real sine = turn / (1 + Real(0.25) * turn * turn);  // with versine(turn): of a unit vector
  const Real slid = slide.along.speed(pair);
  const auto bounded = [&](Real lead) { return bounded_lead(lead, spin, joint.inv_inertia_a, mobility); };
  const Real turned = bounded(bounded_lead(sine * slid, slid, slide.along.mobility, mobility));
  // cross(axis, arm) = dot(normal, arm) = -lever of the row along the axis
  const Real arm = as_one ? slide.along.lever_b - slide.along.lever_a : -slide.along.lever_a;
  return bounded(arm * versine(turn) / h) - turned;
}

// ---- Prismatic ----

void describe_prismatic(JointModel& model, const Joint& joint, const JointCenters& centers) {
  describe_axis(model, joint, centers);
  model.holds_angle = true;
}

/// Impulses act at B's anchor.
Real turning_at_anchor_b(const JointWork& joint, Real h) {
  return turning_of(joint.inv_inertia_a, joint.inv_inertia_b, joint.center_offset + joint.anchor_b, joint.anchor_b, h);
}

/// The motor of a wheel turns.
Real wheel_impulse_along(const JointImpulses& impulses) {
  return impulses.spring + (impulses.lower - impulses.upper);
}

void prepare_prismatic(JointWork& joint, Real h) {
  if (!moves_something(joint)) return;
  joint.turning = turning_at_anchor_b(joint, h);
  const Slide slide = slide_at_start(joint);
  joint.spring = spring_step(joint.model->spring, constrained_line_row(joint, slide).mobility, h);
}

void warm_start_prismatic(JointWork& joint, JointBodies& pair) {
  bound_impulses(joint, impulse_along(joint.impulses));
  const Slide slide = slide_of(joint, pair);
  warm_start_row(joint, slide.along, pair);
  slide.across.apply(joint, pair, joint.impulses.linear.x);
  angle_row(joint).apply(joint, pair, joint.impulses.angular);
}

/// The rows across the axis and about the angle.
void solve_line(JointWork& joint, const ConstrainedLineRow& along, JointBodies& pair, Real h, Bias bias) {
  const Slide& slide = along.slide;
  const Softness soft = softness(joint, bias);
  const Real lead = corrects(bias) ? deviation_rate(joint, slide, pair, h) : Real(0);
  const AngleRow angle = angle_row(joint);
  if (angle.mobility <= 0) {
    solve_rigid(joint, slide.across, pair, slide.deviation, soft, joint.impulses.linear.x, lead);
    return;
  }
  // 2 x 2, by Cramer's rule.
  const Real k12 = slide_coupling(joint, slide.across);
  const Real rate = (slide.across.speed(pair) + lead) + soft.bias_rate * slide.deviation;
  const Real spin = angle.speed(pair) + soft.bias_rate * relative_angle(joint, pair);
  const Real inv_determinant = 1 / slide_determinant(joint, slide.across);
  const Real p = inv_determinant * (angle.mobility * rate - k12 * spin);
  const Real t = inv_determinant * (slide.across.mobility * spin - k12 * rate);
  const Real driven = impulse_along(joint.impulses);
  const Real across_reaction = driven * along.across, about_reaction = driven * along.about_angle;
  const Real moved = slide.across.mobility * across_reaction + k12 * about_reaction;
  const Real turned = k12 * across_reaction + angle.mobility * about_reaction;
  const Real share = stiff_share(joint.impulses.linear.x * moved + joint.impulses.angular * turned,
                                 across_reaction * moved + about_reaction * turned);
  const Real across = -(soft.mass_scale * p) - soft.impulse_scale * (joint.impulses.linear.x - share * across_reaction);
  const Real about_angle =
      -(soft.mass_scale * t) - soft.impulse_scale * (joint.impulses.angular - share * about_reaction);
  joint.impulses.linear.x += across;
  joint.impulses.angular += about_angle;
  slide.across.apply(joint, pair, across);
  angle.apply(joint, pair, about_angle);
}

/// The rows along the axis come last: their impulses leave the other two rows as they are, and not the other way round.
/// After a warm start with long arms, the other two rows may be far off.
void solve_prismatic(JointWork& joint, JointBodies& pair, Real h, Bias bias) {
  if (!moves_something(joint)) return;
  const JointModel& model = *joint.model;
  const Slide slide = slide_of(joint, pair);
  const ConstrainedLineRow along = constrained_line_row(joint, slide);
  solve_line(joint, along, pair, h, bias);
  solve_spring_along(joint, along, pair, slide.translation, bias);
  if (model.has_motor && bias != Bias::of_drift)
    solve_motor(joint, along, pair, joint.motor_speed, joint.motor_impulse_max, joint.impulses.motor);
  if (model.has_limits) solve_limits(joint, along, pair, slide.translation, h, bias);
}

// ---- Wheel ----

void prepare_wheel(JointWork& joint, Real h) {
  joint.turning = turning_at_anchor_b(joint, h);
  joint.spring = spring_step(joint.model->spring, slide_at_start(joint).along.mobility, h);
}

void warm_start_wheel(JointWork& joint, JointBodies& pair) {
  bound_impulses(joint, wheel_impulse_along(joint.impulses));
  const Slide slide = slide_of(joint, pair);
  slide.along.apply(joint, pair, wheel_impulse_along(joint.impulses));
  slide.across.apply(joint, pair, joint.impulses.linear.x);
  angle_row(joint).apply(joint, pair, joint.impulses.motor);
}

void solve_wheel(JointWork& joint, JointBodies& pair, Real h, Bias bias) {
  if (!moves_something(joint)) return;
  const JointModel& model = *joint.model;
  const Slide slide = slide_of(joint, pair);
  solve_spring_along(joint, slide.along, pair, slide.translation, bias);
  if (model.has_motor && bias != Bias::of_drift)
    solve_motor(joint, angle_row(joint), pair, joint.motor_speed, joint.motor_impulse_max, joint.impulses.motor);
  if (model.has_limits) solve_limits(joint, slide.along, pair, slide.translation, h, bias);
  const Real lead = corrects(bias) ? deviation_rate(joint, slide, pair, h) : Real(0);
  solve_rigid(joint, slide.across, pair, slide.deviation, softness(joint, bias), joint.impulses.linear.x, lead);
}

}  // namespace

constexpr JointFunctions prismatic_joint{describe_prismatic, prepare_prismatic, save_each<save_slide>,
                                         warm_start_each<warm_start_prismatic>, solve_each<solve_prismatic>};
constexpr JointFunctions wheel_joint{describe_axis, prepare_wheel, save_each<save_slide>,
                                     warm_start_each<warm_start_wheel>, solve_each<solve_wheel>};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
