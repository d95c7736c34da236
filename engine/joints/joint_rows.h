// The rows of joints: along a line, about the angle, at a point; rigid, limited, driven and sprung.
// SPDX-License-Identifier: MIT
// Source: Catto, "Iterative Dynamics with Temporal Coherence", GDC 2005 (accumulated impulses, clamping); Catto,
// "Soft Constraints", GDC 2011; Catto, "Solver2D", 2024 (relax).
//
// A row has a relative velocity u = J v, a mobility K = J M^-1 J^T (the inverse of its effective mass) and an error C.
// Rigid: impulse = -mass_scale K^-1 (u + bias_rate C) - impulse_scale old; relax: impulse = -K^-1 u.
#pragma once

#include "engine/joints/batched/revolute_point.h"
#include "engine/joints/joint.h"
#include "engine/math/trig.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Stiffness of rigid rows.
inline constexpr Real joint_hertz_times_h = Real(0.25);
inline constexpr Real joint_damping_ratio = 5;

/// The two bodies of a joint while it is solved.
struct JointBodies {
  MovingBody a;
  MovingBody b;
};

inline JointBodies load(const JointWork& joint, const MovingBody* bodies) {
  return {bodies[joint.read_a], bodies[joint.read_b]};
}
inline void store(const JointWork& joint, const JointBodies& pair, MovingBody* bodies) {
  bodies[joint.write_a].velocity = pair.a.velocity;
  bodies[joint.write_a].angular_velocity = pair.a.angular_velocity;
  bodies[joint.write_b].velocity = pair.b.velocity;
  bodies[joint.write_b].angular_velocity = pair.b.angular_velocity;
}

inline Real clamped(Real value, Real limit) {
  return larger(smaller(value, limit), -limit);
}
inline Vec2 clamped(Vec2 value, Real limit) {
  const Real size = length(value);
  return size > limit ? (limit / size) * value : value;
}

/// Softness of a rigid row in this pass.
inline Softness softness(const JointWork& joint, Bias bias) {
  return corrects(bias) ? joint.soft : Softness{};
}

// ---- About the angle ----

/// Of B relative to A and the reference, rad, -pi..pi.
inline double wide_relative_angle(const JointWork& joint, const JointBodies& pair) {
  const Rotation q = between(pair.a.delta_rotation, pair.b.delta_rotation) * joint.relative_rotation;
  return arc_tangent(static_cast<double>(q.s), static_cast<double>(q.c));
}
inline Real relative_angle(const JointWork& joint, const JointBodies& pair) {
  return static_cast<Real>(wide_relative_angle(joint, pair));
}

struct AngleRow {
  Real mobility;  // 1/(kg m^2)

  Real speed(const JointBodies& pair) const { return pair.b.angular_velocity - pair.a.angular_velocity; }
  void apply(const JointWork& joint, JointBodies& pair, Real impulse) const {
    pair.a.angular_velocity -= joint.inv_inertia_a * impulse;
    pair.b.angular_velocity += joint.inv_inertia_b * impulse;
  }
};
inline AngleRow angle_row(const JointWork& joint) {
  return {joint.inv_inertia_a + joint.inv_inertia_b};
}

// ---- Along a line ----

/// Impulses along `axis`, with levers about the two centres of mass.
struct LineRow {
  Vec2 axis;     // unit, from A towards B
  Real lever_a;  // m
  Real lever_b;
  Real mobility;  // 1/kg

  Real speed(const JointBodies& pair) const {
    return dot(axis, pair.b.velocity - pair.a.velocity) +
           (lever_b * pair.b.angular_velocity - lever_a * pair.a.angular_velocity);
  }
  void apply(const JointWork& joint, JointBodies& pair, Real impulse) const {
    const Vec2 p = impulse * axis;
    pair.a.velocity = pair.a.velocity - joint.inv_mass_a * p;
    pair.a.angular_velocity -= joint.inv_inertia_a * lever_a * impulse;
    pair.b.velocity = pair.b.velocity + joint.inv_mass_b * p;
    pair.b.angular_velocity += joint.inv_inertia_b * lever_b * impulse;
  }
};
inline LineRow line_row(const JointWork& joint, Vec2 axis, Vec2 arm_a, Vec2 arm_b) {
  const Real lever_a = cross(arm_a, axis);
  const Real lever_b = cross(arm_b, axis);
  return {axis, lever_a, lever_b,
          (joint.inv_mass_a + joint.inv_mass_b) +
              (joint.inv_inertia_a * lever_a * lever_a + joint.inv_inertia_b * lever_b * lever_b)};
}

/// The rows of a joint with an axis that rotates with A.
struct Slide {
  LineRow along;
  LineRow across;
  Real translation;  // of B's anchor along the axis, from A's, m
  Real deviation;    // across the axis, m
};

inline Slide slide_of(const JointWork& joint, const JointBodies& pair) {
  const Vec2 axis = rotate(pair.a.delta_rotation, joint.axis);
  const Vec2 normal = cross(Real(1), axis);
  const Vec2 arm_b = rotate(pair.b.delta_rotation, joint.anchor_b);
  const Vec2 arm_a = (joint.center_offset + (pair.b.delta_position - pair.a.delta_position)) + arm_b;  // d + r_a
  const Vec2 d = arm_a - rotate(pair.a.delta_rotation, joint.anchor_a);
  return {line_row(joint, axis, arm_a, arm_b), line_row(joint, normal, arm_a, arm_b), dot(axis, d), dot(normal, d)};
}

// ---- One row of either sort ----

template <typename Row>
void solve_rigid(JointWork& joint, const Row& row, JointBodies& pair, Real error, const Softness& soft, Real& impulse,
                 Real drift_rate = 0) {
  if (row.mobility <= 0) return;
  const Real wanted = soft.mass_scale * ((row.speed(pair) + drift_rate) + soft.bias_rate * error) / row.mobility;
  const Real change = -wanted - soft.impulse_scale * impulse;
  impulse += change;
  row.apply(joint, pair, change);
}

/// The lead of a row is the change of its error in a substep besides the velocity along it: what turns leaves its
/// tangent. An impulse that meets a lead may turn a light body about a far anchor faster than before, and so ask for
/// more, without end. A lead that would take more than this share of the energy of the motion across the row is weaker
/// by the excess.
inline constexpr Real lead_energy_share = Real(0.1);

/// `speed`, `mobility_across`: of the motion that the lead follows from. `mobility`: of the row.
inline Real bounded_lead(Real lead, Real speed, Real mobility_across, Real mobility) {
  const Real asked = mobility_across * (lead * lead);
  const Real allowed = lead_energy_share * (mobility * (speed * speed));
  return asked > allowed ? lead * (allowed / asked) : lead;
}

/// One-sided. `slack` >= 0 may be used up within the substep; `slack` < 0 is corrected. `sign` 1: a lower limit.
template <typename Row>
void solve_limit(JointWork& joint, const Row& row, JointBodies& pair, Real slack, Real sign, Real h, Bias bias,
                 Real& impulse) {
  if (row.mobility <= 0) return;
  Softness soft;
  Real target = slack / h;
  if (slack < 0) {
    soft = softness(joint, bias);
    target = soft.bias_rate * slack;
  }
  const Real wanted = soft.mass_scale * (sign * row.speed(pair) + target) / row.mobility;
  const Real total = larger((impulse - wanted) - soft.impulse_scale * impulse, 0);
  row.apply(joint, pair, sign * (total - impulse));
  impulse = total;
}

template <typename Row>
void solve_limits(JointWork& joint, const Row& row, JointBodies& pair, Real value, Real h, Bias bias) {
  solve_limit(joint, row, pair, value - joint.model->lower, Real(1), h, bias, joint.impulses.lower);
  solve_limit(joint, row, pair, joint.model->upper - value, Real(-1), h, bias, joint.impulses.upper);
}

template <typename Row>
void solve_motor(JointWork& joint, const Row& row, JointBodies& pair, Real speed, Real impulse_max, Real& impulse) {
  if (row.mobility <= 0) return;
  const Real total = clamped(impulse - (row.speed(pair) - speed) / row.mobility, impulse_max);
  row.apply(joint, pair, total - impulse);
  impulse = total;
}

template <typename Row>
void solve_spring(JointWork& joint, const Row& row, JointBodies& pair, const SpringStep& spring, Real error,
                  Real start_speed, Real impulse_max, Real& impulse) {
  if (row.mobility <= 0) return;
  const Real total =
      clamped(spring_impulse(spring, row.mobility, error, start_speed, row.speed(pair), impulse), impulse_max);
  row.apply(joint, pair, total - impulse);
  impulse = total;
}

/// The impulses p of a joint are bounded to h p r / I = 1 before they act again at an arm r, I the inertia. The arm may
/// have turned by x since, so they act with an error of p r x, which turns the body by up to x. Forces that last hardly
/// get there, since raise_inertias raises I; this bounds what arises within a tick, as the impulse of a limit. Not
/// bounded: points and rods without limits, motor or spring, welds. Hanging chains would give way more. Returns the
/// inverse of the greatest impulse, 1/(N s).
inline Real turning_of(Real inv_inertia_a, Real inv_inertia_b, Vec2 arm_a, Vec2 arm_b, Real h) {
  return h * larger(inv_inertia_a * length(arm_a), inv_inertia_b * length(arm_b));
}

/// The share of impulses that is left. `p2`: square of their sum, (N s)^2.
inline Real share_within(Real turning, Real p2) {
  return turning * turning * p2 > 1 ? 1 / (turning * square_root(p2)) : Real(1);
}

/// Sum of the impulses along the axis of a prismatic or distance joint, N s.
inline Real impulse_along(const JointImpulses& impulses) {
  return (impulses.spring + impulses.motor) + (impulses.lower - impulses.upper);
}

/// Bounds the impulses before they act again. `along`: sum of the impulses along an axis, N s.
inline void bound_impulses(JointWork& joint, Real along) {
  JointImpulses& impulses = joint.impulses;
  const Real share = share_within(joint.turning, length_squared(impulses.linear) + along * along);
  if (share == 1) return;
  impulses = {share * impulses.linear, share * impulses.angular, share * impulses.spring,
              share * impulses.lower,  share * impulses.upper,   share * impulses.motor};
}

/// Applies the accumulated impulses of one row.
template <typename Row>
void warm_start_row(const JointWork& joint, const Row& row, JointBodies& pair) {
  row.apply(joint, pair,
            (joint.impulses.spring + joint.impulses.motor) + (joint.impulses.lower - joint.impulses.upper));
}

/// Coefficients of a spring on a row of this mobility; none if there is no spring or the row cannot move.
SpringStep spring_step(const SpringModel& spring, Real mobility, Real h);

inline constexpr Real no_impulse_limit = sizeof(Real) == 4 ? Real(0x1p127) : Real(0x1p1023);

// ---- At a point ----

/// Two rows, x and y. The impulses on both bodies act at the same point. This conserves angular momentum even while the
/// anchors are apart by up to twice the longer arm (middle_share).
struct PointRow {
  Vec2 arm_a;  // from A's centre of mass, m
  Vec2 arm_b;
  Vec2 error;  // from A's anchor to B's, m
  Real k11, k12, k22;
  Real determinant;  // of k

  Vec2 velocity(const JointBodies& pair) const {
    return (pair.b.velocity + cross(pair.b.angular_velocity, arm_b)) -
           (pair.a.velocity + cross(pair.a.angular_velocity, arm_a));
  }
  void apply(const JointWork& joint, JointBodies& pair, Vec2 impulse) const {
    pair.a.velocity = pair.a.velocity - joint.inv_mass_a * impulse;
    pair.a.angular_velocity -= joint.inv_inertia_a * cross(arm_a, impulse);
    pair.b.velocity = pair.b.velocity + joint.inv_mass_b * impulse;
    pair.b.angular_velocity += joint.inv_inertia_b * cross(arm_b, impulse);
  }
  /// K^-1 v by Cramer's rule.
  Vec2 solved(Vec2 v) const {
    const Real inv_determinant = 1 / determinant;
    return {inv_determinant * (k22 * v.x - k12 * v.y), inv_determinant * (k11 * v.y - k12 * v.x)};
  }
};

/// The point at which the impulses of a point row act.
enum class ActsAt : std::uint8_t { middle, anchor_b };

inline PointRow point_row(const JointWork& joint, const JointBodies& pair, ActsAt place) {
  const auto change_of = [](const MovingBody& body) -> PoseChange<Real> {
    return {body.delta_position.x, body.delta_position.y, body.delta_rotation.c, body.delta_rotation.s};
  };
  PointArms<Real> arms =
      anchor_arms<Real>(change_of(pair.a), change_of(pair.b), {joint.anchor_a.x, joint.anchor_a.y},
                        {joint.anchor_b.x, joint.anchor_b.y}, {joint.center_offset.x, joint.center_offset.y});
  if (place == ActsAt::middle) {
    meet_in_the_middle(arms, middle_share(arms, joint.inv_inertia_a, joint.inv_inertia_b));
  } else {
    arms.ax = arms.ax + arms.ex;
    arms.ay = arms.ay + arms.ey;
  }
  const PointMobility<Real> k =
      point_mobility(arms, joint.inv_mass_a + joint.inv_mass_b, joint.inv_inertia_a, joint.inv_inertia_b);
  return {{arms.ax, arms.ay}, {arms.bx, arms.by}, {arms.ex, arms.ey}, k.k11, k.k12, k.k22, k.determinant};
}

/// Whether the joint can move anything at all.
inline bool moves_something(const JointWork& joint) {
  return joint.inv_mass_a + joint.inv_mass_b > 0;
}

/// The contribution of rotating arms to d = error in a substep, per h. An arm r that rotates by x = w h ends r (1 - cos
/// x) short of its tangent.
inline Vec2 arm_rotation_rate(Vec2 arm_a, Vec2 arm_b, const JointBodies& pair, Real h) {
  return (1 / h) * (versine(h * pair.a.angular_velocity) * arm_a - versine(h * pair.b.angular_velocity) * arm_b);
}

/// Two rigid rows take a share of their impulse back in each substep, since they are soft. A reaction to driven rows is
/// in that impulse, but is as stiff as those. It is left out as far as that makes the load on the rows smaller, in the
/// metric of their mobility. `part`: the reaction's product with the impulse; `whole`: with itself.
inline Real stiff_share(Real part, Real whole) {
  const Real share = whole > 0 ? part / whole : Real(0);
  return larger(smaller(share, Real(1)), Real(0));
}

/// `drift_rate`: change of the error in this substep besides the velocity, m/s. `reaction`: to rows of the angle, N s.
inline void solve_rigid_point(JointWork& joint, const PointRow& row, JointBodies& pair, const Softness& soft,
                              Vec2 drift_rate = {0, 0}, Vec2 reaction = {0, 0}) {
  if (!moves_something(joint)) return;
  const Vec2 wanted = row.solved((row.velocity(pair) + drift_rate) + soft.bias_rate * row.error);
  const Vec2 moved{row.k11 * reaction.x + row.k12 * reaction.y, row.k12 * reaction.x + row.k22 * reaction.y};
  const Real share = stiff_share(dot(joint.impulses.linear, moved), dot(reaction, moved));
  const Vec2 load = joint.impulses.linear - share * reaction;
  const Vec2 change = -(soft.mass_scale * wanted) - soft.impulse_scale * load;
  joint.impulses.linear = joint.impulses.linear + change;
  row.apply(joint, pair, change);
}

/// The angle of two bodies that a point constraint joins. An angular impulse includes the reaction of the point
/// constraint, so that the point stays at rest. The row of the angle is then solved as if alone.
struct ConstrainedAngleRow {
  Real mobility;
  Vec2 reaction;  // of the point constraint, per angular impulse, 1/m
  Real torque_a;  // of the impulse and its reaction about A's centre of mass, per angular impulse
  Real torque_b;

  Real speed(const JointBodies& pair) const { return pair.b.angular_velocity - pair.a.angular_velocity; }
  void apply(JointWork& joint, JointBodies& pair, Real impulse) const {
    const Vec2 p = impulse * reaction;
    pair.a.velocity = pair.a.velocity - joint.inv_mass_a * p;
    pair.a.angular_velocity -= joint.inv_inertia_a * torque_a * impulse;
    pair.b.velocity = pair.b.velocity + joint.inv_mass_b * p;
    pair.b.angular_velocity += joint.inv_inertia_b * torque_b * impulse;
    joint.impulses.linear = joint.impulses.linear + p;
  }
};

/// The velocity of the point per unit of angular impulse.
inline Vec2 angle_coupling(const JointWork& joint, const PointRow& row) {
  return {-(joint.inv_inertia_a * row.arm_a.y + joint.inv_inertia_b * row.arm_b.y),
          joint.inv_inertia_a * row.arm_a.x + joint.inv_inertia_b * row.arm_b.x};
}

/// With m, a, b the inverse masses (summed) and inertias: the 3 x 3 determinant of point and angle over the 2 x 2 one
/// of the point, both as sums of positive terms (Cauchy-Binet), divided by m: (m (a + b) + a b |r_a - r_b|^2) / (m + a
/// |r_a|^2 + b |r_b|^2 + a b (r_a x r_b)^2 / m). The reaction and the torques are Cramer's rule in the same form: with
/// a far anchor the torque of the reaction cancels that of the impulse almost whole, and each alone rounds by more than
/// what is left.
inline ConstrainedAngleRow constrained_angle_row(const JointWork& joint, const PointRow& point) {
  const Real m = joint.inv_mass_a + joint.inv_mass_b;
  const Real a = joint.inv_inertia_a;
  const Real b = joint.inv_inertia_b;
  if (m <= 0 || a + b <= 0) return {0, {0, 0}, 0, 0};
  const Vec2 difference = point.arm_a - point.arm_b;
  const Real area = cross(point.arm_a, point.arm_b);
  const Real above = m * (a + b) + a * b * length_squared(difference);
  const Real below =
      m + (a * length_squared(point.arm_a) + b * length_squared(point.arm_b)) + a * area * (b * area / m);
  const Vec2 reaction = (a * area * (b / m)) * difference - angle_coupling(joint, point);
  return {above / below, (1 / below) * reaction, (m - b * dot(point.arm_b, difference)) / below,
          (m + a * dot(point.arm_a, difference)) / below};
}

/// The principal axes of a point's mobility: an impulse along an axis moves the point along this axis alone.
struct PrincipalAxes {
  Vec2 axis[2];  // unit, at right angles; the more mobile one first
  Real mobility[2];
};
PrincipalAxes principal_axes(const JointWork& joint, const PointRow& row);
void prepare_point_spring(JointWork& joint, const SpringModel& spring, ActsAt place, Real h);
void solve_point_spring(JointWork& joint, const PointRow& row, JointBodies& pair, Real impulse_max);

// ---- Along the axis of a slider ----

/// The axis of bodies that do not rotate against each other. An impulse along the axis includes the reactions of the
/// two rigid rows, so that these rows stay at rest. The axis is then solved as if alone.
struct ConstrainedLineRow {
  Real mobility;
  Real across;  // reactions per impulse
  Real about_angle;
  Real turn;  // of both bodies, per impulse
  const Slide& slide;

  Real speed(const JointBodies& pair) const { return slide.along.speed(pair); }
  void apply(JointWork& joint, JointBodies& pair, Real impulse) const {
    const Vec2 p = impulse * slide.along.axis + (across * impulse) * slide.across.axis;
    pair.a.velocity = pair.a.velocity - joint.inv_mass_a * p;
    pair.a.angular_velocity += turn * impulse;
    pair.b.velocity = pair.b.velocity + joint.inv_mass_b * p;
    pair.b.angular_velocity += turn * impulse;
    joint.impulses.linear.x += across * impulse;
    joint.impulses.angular += about_angle * impulse;
  }
};

/// Coupling of the row across the axis with the row of the angle.
inline Real slide_coupling(const JointWork& joint, const LineRow& row) {
  return joint.inv_inertia_a * row.lever_a + joint.inv_inertia_b * row.lever_b;
}

/// The determinant of the rows across the axis and about the angle. In this form no digits cancel with long arms.
inline Real slide_determinant(const JointWork& joint, const LineRow& across) {
  const Real lever = across.lever_a - across.lever_b;
  return (joint.inv_mass_a + joint.inv_mass_b) * (joint.inv_inertia_a + joint.inv_inertia_b) +
         joint.inv_inertia_a * lever * (joint.inv_inertia_b * lever);
}

/// With m the summed inverse mass, a, b the inverse inertias, r from A's to B's centre of mass, s its part along the
/// axis: the energy of a translation along the axis and a common rotation gives m (a b r^2 + m (a + b)) / (a b s^2 + m
/// (a + b)), all terms positive. The common rotation is found as a whole, as the torques of ConstrainedAngleRow are.
/// Requires: m > 0.
inline ConstrainedLineRow constrained_line_row(const JointWork& joint, const Slide& slide) {
  const Real m = joint.inv_mass_a + joint.inv_mass_b;
  const Real a = joint.inv_inertia_a;
  const Real b = joint.inv_inertia_b;
  if (a + b <= 0) return {m, 0, 0, 0, slide};
  const Real r_along = slide.across.lever_a - slide.across.lever_b;  // cross(r, normal) = dot(r, axis)
  const Real r_across = slide.along.lever_b - slide.along.lever_a;
  const Real determinant = slide_determinant(joint, slide.across);
  const Real across = a * r_along * (b * r_across) / determinant;
  const Real of_a = a * (slide.along.lever_a + across * slide.across.lever_a);
  const Real of_b = b * (slide.along.lever_b + across * slide.across.lever_b);
  return {m * ((determinant + a * b * r_across * r_across) / determinant), across, -(of_a + of_b) / (a + b),
          a * b * m * r_across / determinant, slide};
}

// ---- Runs of joints ----

template <auto one>
void save_each(JointRun run) {
  for (JointWork* joint = run.first; joint != run.last; ++joint) one(*joint, load(*joint, run.bodies));
}
template <auto one>
void warm_start_each(JointRun run) {
  for (JointWork* joint = run.first; joint != run.last; ++joint) {
    JointBodies pair = load(*joint, run.bodies);
    one(*joint, pair);
    store(*joint, pair, run.bodies);
  }
}
template <auto one>
void solve_each(JointRun run, Real h, Bias bias) {
  for (JointWork* joint = run.first; joint != run.last; ++joint) {
    JointBodies pair = load(*joint, run.bodies);
    one(*joint, pair, h, bias);
    store(*joint, pair, run.bodies);
  }
}

// ---- The kinds ----

extern const JointFunctions revolute_joint;   // joint_point.cpp
extern const JointFunctions prismatic_joint;  // joint_slider.cpp
extern const JointFunctions distance_joint;   // joint_distance.cpp
extern const JointFunctions weld_joint;       // joint_point.cpp
extern const JointFunctions wheel_joint;      // joint_slider.cpp
extern const JointFunctions motor_joint;      // joint_drive.cpp
extern const JointFunctions friction_joint;   // joint_drive.cpp
extern const JointFunctions target_joint;     // joint_drive.cpp
extern const JointFunctions pulley_joint;     // joint_pulley.cpp

struct JointTableRow {
  JointKind kind;
  const JointFunctions* functions;  // null: not solved as one of these joints
};
inline constexpr std::array<JointTableRow, joint_kinds.size()> joint_functions{{
    {JointKind::revolute, &revolute_joint},
    {JointKind::prismatic, &prismatic_joint},
    {JointKind::distance, &distance_joint},
    {JointKind::weld, &weld_joint},
    {JointKind::wheel, &wheel_joint},
    {JointKind::motor, &motor_joint},
    {JointKind::friction, &friction_joint},
    {JointKind::target, &target_joint},
    {JointKind::pulley, &pulley_joint},
    {JointKind::gear, nullptr},  // gears/gear_joints.h
}};
static_assert(rows_are_in_order(joint_functions));

/// Requires: no gear.
inline const JointFunctions& functions_of(JointKind kind) {
  return *info_of(joint_functions, kind).functions;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
