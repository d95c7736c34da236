// The pulley joint: a rope from body A over two fixed pulleys to body B, with a ratio, as of a block and tackle.
// SPDX-License-Identifier: MIT
// Source: Catto, Box2D 2.4.1, b2_pulley_joint.cpp (constraint, effective mass, sides without a direction); rows:
// joint_rows.h.
//
// l_a, l_b = distances from the ground anchors to the bodies' anchors, u_a, u_b = their directions, r = ratio.
// C = l_a + r l_b - length, u = u_a v_a + r u_b v_b, K = K_a + r^2 K_b. linear.x = the impulse on A along u_a; linear.y
// = r linear.x, the impulse on B along u_b. |linear| therefore bounds both (joint_inertia.h). axis.x, axis.y = 1 if the
// side of A, of B has a direction in this tick, otherwise 0.
#include "engine/joints/joint_rows.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// A side that is shorter than this share of the rope at the start of a tick has no direction in the tick, and gets no
/// impulse. The share is ten times a slop of a 2000th; for a rope of 10 m this is the 5 cm of Box2D. The choice is made
/// once per tick, so that the relax pass removes what the bias added.
constexpr Real shortest_share = Real(10.0 / 2000);

/// From a ground anchor to a body's anchor.
struct RopeSide {
  Vec2 axis;    // unit, or zero
  Vec2 arm;     // from the centre of mass to the anchor, m
  Real length;  // m
  Real lever;   // m
  Real mobility;

  Real speed(const MovingBody& body) const { return dot(axis, body.velocity) + lever * body.angular_velocity; }
};

/// `from_ground`: from the ground anchor to the centre of mass at the start of the tick.
RopeSide side_of(const MovingBody& body, Vec2 from_ground, Vec2 anchor, Real inv_mass, Real inv_inertia,
                 Real has_direction) {
  RopeSide side{};
  side.arm = rotate(body.delta_rotation, anchor);
  const Vec2 d = (from_ground + body.delta_position) + side.arm;
  side.length = length(d);
  if (!(has_direction * side.length > 0)) return side;
  side.axis = {d.x / side.length, d.y / side.length};
  side.lever = cross(side.arm, side.axis);
  side.mobility = inv_mass + inv_inertia * side.lever * side.lever;
  return side;
}

/// The lengthening of a side in a substep besides the velocity along it, per h, as for a rod (joint_distance.cpp).
/// `mobility`: of the row, over the square of the side's ratio.
Real lengthening_rate(const RopeSide& side, const MovingBody& body, Real inv_mass, Real inv_inertia, Real mobility,
                      Real h) {
  const Real across = cross(side.axis, body.velocity + cross(body.angular_velocity, side.arm));
  const Real sideways = h * across;
  const Real whole = side.length + square_root(side.length * side.length + sideways * sideways);
  const Real longer = whole > 0 ? sideways * sideways / (h * whole) : Real(0);
  const Real along = dot(side.axis, side.arm);
  const Real of_arm = -(along * versine(h * body.angular_velocity) / h);
  return bounded_lead(longer, across, inv_mass + inv_inertia * along * along, mobility) +
         bounded_lead(of_arm, body.angular_velocity, inv_inertia, mobility);
}

struct PulleyRow {
  RopeSide a;
  RopeSide b;
  Real ratio;
  Real mobility;  // 1/kg

  Real speed(const JointBodies& pair) const { return a.speed(pair.a) + ratio * b.speed(pair.b); }
  void apply(const JointWork& joint, JointBodies& pair, Real impulse) const {
    const Real impulse_b = ratio * impulse;
    pair.a.velocity = pair.a.velocity + (joint.inv_mass_a * impulse) * a.axis;
    pair.a.angular_velocity += joint.inv_inertia_a * a.lever * impulse;
    pair.b.velocity = pair.b.velocity + (joint.inv_mass_b * impulse_b) * b.axis;
    pair.b.angular_velocity += joint.inv_inertia_b * b.lever * impulse_b;
  }
};

PulleyRow pulley_row(const JointWork& joint, const JointBodies& pair) {
  const JointModel& model = *joint.model;
  PulleyRow row;
  row.a = side_of(pair.a, joint.center_a - model.ground_a, joint.anchor_a, joint.inv_mass_a, joint.inv_inertia_a,
                  joint.axis.x);
  row.b = side_of(pair.b, joint.center_b - model.ground_b, joint.anchor_b, joint.inv_mass_b, joint.inv_inertia_b,
                  joint.axis.y);
  row.ratio = model.ratio;
  row.mobility = row.a.mobility + row.ratio * row.ratio * row.b.mobility;
  return row;
}

void describe_pulley(JointModel& model, const Joint& joint, const JointCenters&) {
  model.ground_a = from_center(joint.ground_anchor_a, {0, 0});
  model.ground_b = from_center(joint.ground_anchor_b, {0, 0});
  model.ratio = static_cast<Real>(joint.ratio);
}

void prepare_pulley(JointWork& joint, Real) {
  const JointModel& model = *joint.model;
  const Real shortest = shortest_share * model.length;
  const Real length_a = length((joint.center_a - model.ground_a) + joint.anchor_a);
  const Real length_b = length((joint.center_b - model.ground_b) + joint.anchor_b);
  joint.axis = {Real(length_a > shortest ? 1 : 0), Real(length_b > shortest ? 1 : 0)};
}

void save_pulley(JointWork&, const JointBodies&) {}

void warm_start_pulley(const JointWork& joint, JointBodies& pair) {
  pulley_row(joint, pair).apply(joint, pair, joint.impulses.linear.x);
}

/// Whether a side with a direction reaches its ground anchor within the substep, and the other side leaves no more of
/// the rope than a side without a direction. `moved`: the body with the velocity that the row gives it.
bool is_at_anchor(const RopeSide& side, const MovingBody& moved, Real has_direction, Real left, Real shortest, Real h) {
  if (left > shortest || !(has_direction > 0)) return false;
  return h * length(moved.velocity + cross(moved.angular_velocity, side.arm)) > side.length;
}

/// Stops a side at its ground anchor: a heavy body would throw a light one past it in every substep, and the rope would
/// be as soft as the light one. The row then moves the other body alone. Returns the speed of the side.
Real stop_at_anchor(RopeSide& side, MovingBody& body, Real inv_mass, Real inv_inertia, Real h) {
  const Real speed = -(side.length / h);
  const Vec2 missing = speed * side.axis - (body.velocity + cross(body.angular_velocity, side.arm));
  const Real turned = inv_inertia * dot(side.arm, side.arm);
  const Real held = inv_inertia * dot(missing, side.arm) / inv_mass;
  const Vec2 impulse = (1 / (inv_mass + turned)) * (missing + held * side.arm);
  body.velocity = body.velocity + inv_mass * impulse;
  body.angular_velocity += inv_inertia * cross(side.arm, impulse);
  side.axis = {0, 0};
  side.lever = side.mobility = 0;
  return speed;
}

void solve_pulley(JointWork& joint, JointBodies& pair, Real h, Bias bias) {
  PulleyRow row = pulley_row(joint, pair);
  const Real error = (row.a.length + row.ratio * row.b.length) - joint.model->length;
  Real lengthening = 0;
  if (corrects(bias)) {
    const Real ratio2 = row.ratio * row.ratio;
    lengthening =
        lengthening_rate(row.a, pair.a, joint.inv_mass_a, joint.inv_inertia_a, row.mobility, h) +
        row.ratio * lengthening_rate(row.b, pair.b, joint.inv_mass_b, joint.inv_inertia_b, row.mobility / ratio2, h);
  }
  const Softness soft = softness(joint, bias);
  const Real before = joint.impulses.linear.x;
  JointBodies moved = pair;
  solve_rigid(joint, row, moved, error, soft, joint.impulses.linear.x, lengthening);
  const Real whole = joint.model->length;
  const Real shortest = shortest_share * whole;
  const bool a_stops =
      joint.inv_mass_a > 0 && is_at_anchor(row.a, moved.a, joint.axis.x, whole - row.ratio * row.b.length, shortest, h);
  const bool b_stops =
      joint.inv_mass_b > 0 && !a_stops && is_at_anchor(row.b, moved.b, joint.axis.y, whole - row.a.length, shortest, h);
  if (a_stops || b_stops) {
    const Real speed = a_stops ? stop_at_anchor(row.a, pair.a, joint.inv_mass_a, joint.inv_inertia_a, h)
                               : row.ratio * stop_at_anchor(row.b, pair.b, joint.inv_mass_b, joint.inv_inertia_b, h);
    row.mobility = row.a.mobility + row.ratio * row.ratio * row.b.mobility;
    joint.impulses.linear.x = row.mobility > 0 ? before : Real(0);  // an immovable other end has no mobility
    solve_rigid(joint, row, pair, error, soft, joint.impulses.linear.x, speed);
  } else {
    pair = moved;
  }
  joint.impulses.linear.y = row.ratio * joint.impulses.linear.x;
}

}  // namespace

constexpr JointFunctions pulley_joint{describe_pulley, prepare_pulley, save_each<save_pulley>,
                                      warm_start_each<warm_start_pulley>, solve_each<solve_pulley>};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
