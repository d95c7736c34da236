// The passes over all joints.
// SPDX-License-Identifier: MIT
// Source: softness tied to the substep rate: Catto, "Solver2D", 2024; without its upper limit the error falls as the
// square of the substep.
#include "engine/joints/joint.h"

#include "engine/joints/batched/wavefront.h"
#include "engine/joints/joint_inertia.h"
#include "engine/joints/joint_rows.h"
#include "engine/model/bodies.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// Prepares the joint's body A, or the dummy body for a joint to the world.
void prepare_body_a(const Model& model, const State& state, const Scratch& scratch, JointWork& joint,
                    const BodyRow& body_b) {
  const JointModel& constants = *joint.model;
  if (constants.body_a == no_reference) {
    joint.read_a = dummy_body(scratch);
    joint.write_a = dummy_sink(scratch);
    joint.inv_mass_a = 0;
    joint.inv_inertia_a = 0;
    joint.anchor_a = {0, 0};
    joint.center_offset = body_b.position - constants.anchor_a;
    joint.center_a = {0, 0};
    joint.axis = constants.axis;
    joint.relative_rotation = between(constants.reference, body_b.rotation);
    return;
  }
  const std::uint32_t row = row_of_body(state, constants.body_a);
  const BodyRow& body = state.bodies[row];
  const BodyModel& mass = model.bodies[body.source];
  joint.read_a = mass.type == BodyType::static_body ? dummy_body(scratch) : row;
  joint.write_a = mass.type == BodyType::dynamic_body ? row : dummy_sink(scratch);
  joint.inv_mass_a = scratch.masses[row].inv_mass;
  joint.inv_inertia_a = scratch.masses[row].inv_inertia;
  joint.anchor_a = rotate(body.rotation, constants.anchor_a);
  joint.center_offset = body_b.position - body.position;
  joint.center_a = body.position;
  joint.axis = rotate(body.rotation, constants.axis);
  joint.relative_rotation = between(body.rotation * constants.reference, body_b.rotation);
}

JointRun run_of(Scratch& scratch, const JointRange& range) {
  JointWork* joints = scratch.joints.data();
  return {joints + range.first, joints + range.last, scratch.bodies.data()};
}

}  // namespace

Real joint_stiffness(Real h) {
  const Real omega = Real(2 * pi) * joint_hertz_times_h / h;
  return omega * omega;
}

JointWork make_joint(const Model& model, const State& state, const Scratch& scratch, const JointPlace& place,
                     const Softness& soft, Real h) {
  const JointRow& row = state.joints[place.row];
  JointWork joint{};
  joint.row = place.row;
  joint.model = &model.joints[row.joint];
  const BodyRow& body = state.bodies[place.body_b];
  const BodyMass& mass = scratch.masses[place.body_b];
  joint.read_b = mass.read;
  joint.write_b = mass.write;
  joint.inv_mass_b = mass.inv_mass;
  joint.inv_inertia_b = mass.inv_inertia;
  joint.anchor_b = rotate(body.rotation, joint.model->anchor_b);
  joint.center_b = body.position;
  prepare_body_a(model, state, scratch, joint, body);
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

/// Calls body(first, last) for all batches of plain revolute joints, in chunks.
template <typename Body>
static void for_revolutes(const Scratch& scratch, const Body& body) {
  const std::size_t count = scratch.caches.joints.revolutes().size();
  scratch.parallel.for_chunks(count, scratch.parallel.chunk_size(count, joint_batches_per_chunk_least, 1),
                              [&](const Chunk& chunk) { body(chunk.begin, chunk.end); });
}

void prepare_joints(const Model& model, const State& state, Scratch& scratch, const SolverSet& set) {
  const Real h = set.h;
  const Softness soft = make_soft(joint_hertz_times_h / h, joint_damping_ratio, h);
  scratch.joints.clear();
  scratch.revolutes.soft = soft;
  scratch.driven_revolutes.soft = soft;
  scratch.uses_wavefront = false;
  if (state.joints.empty()) {
    scratch.caches.joints.clear();
    return;
  }
  scratch.caches.joints.follow(model, state, scratch);
  const JointPlan& plan = scratch.caches.joints;
  scratch.revolutes.order = plan.in_levels() ? RevoluteOrder::levels : RevoluteOrder::serial;
  scratch.uses_wavefront = plan.schedule().exists && is_left_to_joints(scratch, set) &&
                           plan.schedule().body_rows.size() == scratch.moving_rows.size();  // each is moved by joints
  raise_inertias(state, scratch, h);
  for (const std::uint32_t place : plan.scalar())
    scratch.joints.push_back(make_joint(model, state, scratch, plan.places()[place], soft, h));
  if (scratch.uses_wavefront) separate_level_sinks(scratch);
  reserve_revolutes(scratch);
  if (!scratch.uses_wavefront)
    for_revolutes(scratch,
                  [&](std::size_t first, std::size_t last) { fill_revolutes(state, scratch, first, last, h); });
  fill_driven_revolutes(model, state, scratch, soft, h);
  if (scratch.uses_wavefront) return;
  for (const JointRange& range : plan.ranges()) {
    if (range.path == JointPath::revolute) separate_revolute_sinks(scratch, range);
    if (range.path == JointPath::driven_revolute) separate_driven_revolute_sinks(scratch, range);
  }
}

void save_velocities_of(Scratch& scratch, const JointRange& range) {
  if (!range.springs) return;
  if (range.path == JointPath::driven_revolute)
    save_driven_revolutes(scratch, range);
  else
    functions_of(range.kind).save_velocities(run_of(scratch, range));
}

void warm_start_range(Scratch& scratch, const JointRange& range, Poses poses, std::size_t front) {
  if (range.path == JointPath::revolute)
    warm_start_revolutes(scratch, range, poses, front);
  else if (range.path == JointPath::driven_revolute)
    warm_start_driven_revolutes(scratch, range);
  else
    functions_of(range.kind).warm_start(run_of(scratch, range));
}

void solve_range(Scratch& scratch, const JointRange& range, Real h, Bias bias, std::size_t front) {
  if (range.path == JointPath::revolute)
    solve_revolutes(scratch, range, h, bias, front);
  else if (range.path == JointPath::driven_revolute)
    solve_driven_revolutes(scratch, range, h, bias);
  else
    functions_of(range.kind).solve(run_of(scratch, range), h, bias);
}

void save_joint_velocities(Scratch& scratch) {
  for (const JointRange& range : scratch.caches.joints.ranges()) save_velocities_of(scratch, range);
}

void warm_start_joints(Scratch& scratch) {
  for (const JointRange& range : scratch.caches.joints.ranges()) warm_start_range(scratch, range, Poses::moved, 0);
}

void solve_joints(Scratch& scratch, Real h, Bias bias) {
  for (const JointRange& range : scratch.caches.joints.ranges()) solve_range(scratch, range, h, bias, 0);
}

void store_joints(const Scratch& scratch, State& state, Real h) {
  const Real inv_h = 1 / h;
  for (const JointWork& joint : scratch.joints) {
    const JointImpulses& impulses = joint.impulses;
    JointRow& row = state.joints[joint.row];
    row.linear_force = stored(inv_h * impulses.linear);
    row.torque = stored(inv_h * impulses.angular);
    row.spring_force = stored(inv_h * impulses.spring);
    row.lower_force = stored(inv_h * impulses.lower);
    row.upper_force = stored(inv_h * impulses.upper);
    row.motor_force = stored(inv_h * impulses.motor);
  }
  if (!scratch.uses_wavefront)
    for_revolutes(scratch,
                  [&](std::size_t first, std::size_t last) { store_revolutes(scratch, state, first, last, h); });
  store_driven_revolutes(scratch, state, h);
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
  // The smaller mobility is never below that of the masses alone; rounding could make the difference so.
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
