// Preparation of a joint, and springs.
// SPDX-License-Identifier: MIT
// Source: softness tied to the substep rate: Catto, "Solver2D", 2024. Without its upper limit, the error falls as the
// square of the substep.
#include "engine/joints/joint.h"

#include "engine/joints/joint_rows.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// Prepares the joint's body A, or the dummy body for a joint to the world.
void prepare_body_a(const SolvedSet& solved, JointWork& joint, const BodyRow& body_b) {
  const JointModel& constants = *joint.model;
  if (constants.body_a == no_reference) {
    joint.read_a = dummy_body(solved.bodies);
    joint.write_a = dummy_sink(solved.bodies);
    joint.inv_mass_a = 0;
    joint.inv_inertia_a = 0;
    joint.anchor_a = {0, 0};
    joint.center_offset = body_b.position - constants.anchor_a;
    joint.center_a = {0, 0};
    joint.axis = constants.axis;
    joint.relative_rotation = between(constants.reference, body_b.rotation);
    return;
  }
  const std::uint32_t row = row_of_body(solved.state, constants.body_a);
  const BodyRow& body = solved.state.bodies[row];
  const BodyModel& mass = solved.model.bodies[body.source];
  joint.read_a = mass.type == BodyType::static_body ? dummy_body(solved.bodies) : row;
  joint.write_a = mass.type == BodyType::dynamic_body ? row : dummy_sink(solved.bodies);
  joint.inv_mass_a = solved.bodies.masses[row].inv_mass;
  joint.inv_inertia_a = solved.bodies.masses[row].inv_inertia;
  joint.anchor_a = rotate(body.rotation, constants.anchor_a);
  joint.center_offset = body_b.position - body.position;
  joint.center_a = body.position;
  joint.axis = rotate(body.rotation, constants.axis);
  joint.relative_rotation = between(body.rotation * constants.reference, body_b.rotation);
}

}  // namespace

Real joint_stiffness(Real h) {
  const Real omega = Real(2 * pi) * joint_hertz_times_h / h;
  return omega * omega;
}

JointWork make_joint(const SolvedSet& solved, const JointPlace& place, const Softness& soft) {
  const State& state = solved.state;
  const Real h = solved.set.h;
  const JointRow& row = state.joints[place.row];
  JointWork joint{};
  joint.row = place.row;
  joint.model = &solved.model.joints[row.joint];
  const BodyRow& body = state.bodies[place.body_b];
  const BodyMass& mass = solved.bodies.masses[place.body_b];
  joint.read_b = mass.read;
  joint.write_b = mass.write;
  joint.inv_mass_b = mass.inv_mass;
  joint.inv_inertia_b = mass.inv_inertia;
  joint.anchor_b = rotate(body.rotation, joint.model->anchor_b);
  joint.center_b = body.position;
  prepare_body_a(solved, joint, body);
  joint.soft = soft;
  joint.motor_speed = row.motor_speed;
  joint.motor_impulse_max = h * row.motor_force_max;
  joint.impulse_max = h * joint.model->force_max;
  joint.angular_impulse_max = h * joint.model->torque_max;
  joint.impulses = {h * row.linear_force, h * row.torque,      h * row.spring_force,
                    h * row.lower_force,  h * row.upper_force, h * row.motor_force};
  functions_of(joint.model->kind).prepare(joint, h);
  return joint;
}

// ---- Springs ----

SpringStep spring_step(const SpringModel& spring, Real mobility, Real h) {
  if (!spring.exists || mobility <= 0) return {};
  const double per_mass = spring.absolute ? static_cast<double>(mobility) : 1;
  return make_spring_step(spring.stiffness * per_mass, spring.damping * per_mass, static_cast<double>(h));
}

PrincipalAxes principal_axes(const JointWork& joint, const PointRow& row) {
  const Real mean = Real(0.5) * (row.k11 + row.k22);
  const Real half = Real(0.5) * (row.k11 - row.k22);
  const Real radius = square_root(half * half + row.k12 * row.k12);
  Vec2 first{1, 0};
  if (radius > 0) {
    const Vec2 along = half >= 0 ? Vec2{half + radius, row.k12} : Vec2{row.k12, radius - half};
    first = (1 / length(along)) * along;
  }
  // The smaller mobility is never below that of the masses alone; rounding could make it smaller.
  const Real least = joint.inv_mass_a + joint.inv_mass_b;
  return {{first, cross(Real(1), first)}, {mean + radius, larger(mean - radius, least)}};
}

void prepare_point_spring(JointWork& joint, const SpringModel& spring, ActsAt place, Real h) {
  const MovingBody at_start{{0, 0}, 0, {0, 0}, {1, 0}};
  const PrincipalAxes axes = principal_axes(joint, point_row(joint, {at_start, at_start}, place));
  for (std::size_t i = 0; i < 2; ++i) joint.linear_spring[i] = spring_step(spring, axes.mobility[i], h);
}

void solve_point_spring(JointWork& joint, const PointRow& row, JointBodies& pair, Real impulse_max) {
  if (!moves_something(joint)) return;
  const PrincipalAxes axes = principal_axes(joint, row);
  const Vec2 velocity = row.velocity(pair);
  Vec2 total;
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec2 axis = axes.axis[i];
    const Real impulse =
        spring_impulse(joint.linear_spring[i], axes.mobility[i], dot(axis, row.error), dot(axis, joint.start_velocity),
                       dot(axis, velocity), dot(axis, joint.impulses.linear));
    total = total + impulse * axis;
  }
  total = clamped(total, impulse_max);
  row.apply(joint, pair, total - joint.impulses.linear);
  joint.impulses.linear = total;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
