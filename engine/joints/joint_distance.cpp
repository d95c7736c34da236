// The distance joint: a rod, a spring, or a rope between two anchors.
// SPDX-License-Identifier: MIT
// Source: Catto, "Modeling and Solving Constraints", GDC 2009 (distance constraint); rows: joint_rows.h.
//
// d = from A's anchor to B's, C = |d| - length, row along d / |d|. linear.x is the impulse of the rod. spring, motor,
// lower and upper also act along d. Without spring, limits and motor the joint is a rod.
#include "engine/joints/joint_rows.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

struct Span {
  LineRow row;
  Vec2 arm_a, arm_b;  // m
  Real distance;      // m
};

Span span_of(const JointWork& joint, const JointBodies& pair) {
  const Vec2 arm_a = rotate(pair.a.delta_rotation, joint.anchor_a);
  const Vec2 arm_b = rotate(pair.b.delta_rotation, joint.anchor_b);
  const Vec2 d = (joint.center_offset + (pair.b.delta_position - pair.a.delta_position)) + (arm_b - arm_a);
  const Real distance = length(d);
  // Coincident anchors have no direction; a fixed direction avoids a NaN.
  const Vec2 axis = distance > 0 ? Vec2{d.x / distance, d.y / distance} : Vec2{1, 0};
  return {line_row(joint, axis, arm_a, arm_b), arm_a, arm_b, distance};
}

/// The lengthening of the span in a substep besides the velocity along it, per h. It comes from a sideways step u, as
/// sqrt(d^2 + u^2) - d, and from rotating arms.
Real lengthening_rate(const JointWork& joint, const Span& span, const JointBodies& pair, Real h) {
  const LineRow& row = span.row;
  const Vec2 velocity = (pair.b.velocity + cross(pair.b.angular_velocity, span.arm_b)) -
                        (pair.a.velocity + cross(pair.a.angular_velocity, span.arm_a));
  const Real across = cross(row.axis, velocity);
  const Real sideways = h * across;
  const Real whole = span.distance + square_root(span.distance * span.distance + sideways * sideways);
  const Real longer = whole > 0 ? sideways * sideways / (h * whole) : Real(0);
  const Real along_a = dot(row.axis, span.arm_a);
  const Real along_b = dot(row.axis, span.arm_b);
  const Real mobility_across = (joint.inv_mass_a + joint.inv_mass_b) +
                               (joint.inv_inertia_a * along_a * along_a + joint.inv_inertia_b * along_b * along_b);
  const auto of_arm = [&](Real along, Real spin, Real inv_inertia) {
    return bounded_lead(along * versine(h * spin) / h, spin, inv_inertia, row.mobility);
  };
  return bounded_lead(longer, across, mobility_across, row.mobility) +
         (of_arm(along_a, pair.a.angular_velocity, joint.inv_inertia_a) -
          of_arm(along_b, pair.b.angular_velocity, joint.inv_inertia_b));
}

void describe_distance(JointModel& model, const Joint& joint, const JointCenters&) {
  model.rigid = !joint.spring && !joint.limits && !joint.motor;
}

void prepare_distance(JointWork& joint, Real h) {
  if (!joint.model->rigid)
    joint.turning = turning_of(joint.inv_inertia_a, joint.inv_inertia_b, joint.anchor_a, joint.anchor_b, h);
  const MovingBody at_start{{0, 0}, 0, {0, 0}, {1, 0}};
  joint.spring = spring_step(joint.model->spring, span_of(joint, {at_start, at_start}).row.mobility, h);
}

void save_distance(JointWork& joint, const JointBodies& pair) {
  joint.start_speed = span_of(joint, pair).row.speed(pair);
}

void warm_start_distance(JointWork& joint, JointBodies& pair) {
  bound_impulses(joint, impulse_along(joint.impulses));
  const Span span = span_of(joint, pair);
  warm_start_row(joint, span.row, pair);
  span.row.apply(joint, pair, joint.impulses.linear.x);
}

void solve_distance(JointWork& joint, JointBodies& pair, Real h, Bias bias) {
  const JointModel& model = *joint.model;
  const Span span = span_of(joint, pair);
  if (model.rigid) {
    const Real lengthening = corrects(bias) ? lengthening_rate(joint, span, pair, h) : Real(0);
    solve_rigid(joint, span.row, pair, span.distance - model.length, softness(joint, bias), joint.impulses.linear.x,
                lengthening);
    return;
  }
  if (model.spring.exists && bias == Bias::on)
    solve_spring(joint, span.row, pair, joint.spring, span.distance - model.length, joint.start_speed, no_impulse_limit,
                 joint.impulses.spring);
  if (model.has_motor && bias != Bias::of_drift)
    solve_motor(joint, span.row, pair, joint.motor_speed, joint.motor_impulse_max, joint.impulses.motor);
  if (model.has_limits) solve_limits(joint, span.row, pair, span.distance, h, bias);
}

}  // namespace

constexpr JointFunctions distance_joint{describe_distance, prepare_distance, save_each<save_distance>,
                                        warm_start_each<warm_start_distance>, solve_each<solve_distance>};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
