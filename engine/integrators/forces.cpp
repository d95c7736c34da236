// Force elements: model, accelerations, exact flows.
// SPDX-License-Identifier: MIT
// Source: Hairer, Lubich, Wanner, "Geometric Numerical Integration", 2006, section II.5 (splitting into exact flows).
//
// Quadratic drag: u' = -k |u| u has the solution u(t) = u / (1 + k |u| t). A damper multiplies the relative velocity
// along its line by exp(-d t / m), with m the effective mass of this velocity.
#include "engine/integrators/forces.h"

#include "engine/math/exponential.h"
#include "engine/model/bodies.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

Vec2 vector_of(Point p) {
  return {static_cast<Real>(p.x), static_cast<Real>(p.y)};
}

void add_to_body(Model& model, std::size_t source, const Force& force, Point wind) {
  BodyModel& body = model.bodies[source];
  if (body.type != BodyType::dynamic_body) return;
  BodyForces& out = model.body_forces[source];
  const Real coefficient = static_cast<Real>(force.coefficient);
  const Real angular_coefficient = static_cast<Real>(force.angular_coefficient);
  switch (force.kind) {
    case ForceKind::constant:
      out.acceleration = out.acceleration + body.inv_mass * vector_of(force.vector);
      out.angular_acceleration += body.inv_inertia * static_cast<Real>(force.torque);
      break;
    case ForceKind::linear_drag:
      body.linear_damping += coefficient * body.inv_mass;
      body.angular_damping += angular_coefficient * body.inv_inertia;
      out.acceleration = out.acceleration + (coefficient * body.inv_mass) * vector_of(wind);
      break;
    case ForceKind::quadratic_drag:
      out.quadratic_drag += coefficient * body.inv_mass;
      out.angular_quadratic_drag += angular_coefficient * body.inv_inertia;
      model.has_velocity_forces = true;
      break;
    case ForceKind::central:
    case ForceKind::spring:
    case ForceKind::wind:
      break;
  }
}

void add_spring(Model& model, const Force& force) {
  SpringForce spring;
  spring.body = *force.body;
  spring.other = force.other.value_or(no_reference);
  spring.anchor = vector_of(force.anchor) - model.bodies[spring.body].center;
  spring.point = vector_of(force.point);
  if (force.other) spring.point = spring.point - model.bodies[spring.other].center;
  spring.stiffness = static_cast<Real>(force.stiffness);
  spring.damping = static_cast<Real>(force.damping);
  spring.rest_length = static_cast<Real>(force.rest_length);
  model.springs.push_back(spring);
  model.has_velocity_forces = model.has_velocity_forces || spring.damping > 0;
}

void add_central(Model& model, const Force& force) {
  CentralForce central;
  central.every = !force.body.has_value();
  central.body = force.body.value_or(0);
  central.center = vector_of(force.point);
  central.strength = static_cast<Real>(force.coefficient);
  central.exponent = static_cast<int>(force.exponent);
  model.centrals.push_back(central);
}

void add_central_accelerations(const SolvedSet& solved, MotionWorkspace& work) {
  for (std::size_t i = 0; i < solved.model.centrals.size(); ++i) {
    const CentralForce& central = solved.model.centrals[i];
    const auto attract = [&](std::size_t row) {
      const Vec2 r = (solved.state.bodies[row].position - central.center) + solved.bodies.records[row].delta_position;
      const Real distance = length(r);
      if (!(distance > 0)) return;
      Vec2& acceleration = work.accelerations[row].linear;
      acceleration = acceleration - (central.strength * power(distance, central.exponent - 1)) * r;
    };
    if (!central.every) {
      if (work.central_rows[i] != no_reference) attract(work.central_rows[i]);
      continue;
    }
    for (std::size_t row = 0; row < solved.state.bodies.size(); ++row)
      if (solved.model.bodies[solved.state.bodies[row].source].type == BodyType::dynamic_body) attract(row);
  }
}

/// Adds the accelerations of `force` on A's anchor and its opposite on B's.
void accelerate(MotionWorkspace& work, const SpringRow& spring, const SpringLine& line, Vec2 force) {
  Twist& a = work.accelerations[spring.body_a];
  a.linear = a.linear + spring.inv_mass_a * force;
  a.angular += spring.inv_inertia_a * cross(line.arm_a, force);
  Twist& b = work.accelerations[spring.write_b];
  b.linear = b.linear - spring.inv_mass_b * force;
  b.angular -= spring.inv_inertia_b * cross(line.arm_b, force);
}

void add_element_accelerations(const SolvedSet& solved, MotionWorkspace& work) {
  add_central_accelerations(solved, work);
  for (const SpringRow& spring : work.springs) {
    const SpringLine line = line_of(spring, solved.bodies);
    if (line.exists) accelerate(work, spring, line, line.tension * line.along);
  }
}

/// exp(-x) and its mean over 0..1, also for x < 0.
Decay signed_decay(double x) {
  if (x >= 0) return decay_over(x);
  const Decay forward = decay_over(-x);
  return {1 / forward.factor, forward.mean / forward.factor};
}

void flow_drags(const SolvedSet& solved, Real h) {
  for (const std::uint32_t row : solved.rows) {
    const BodyForces& forces = solved.model.body_forces[solved.state.bodies[row].source];
    MovingBody& body = solved.bodies.records[row];
    const Vec2 through_air = body.velocity - solved.model.wind;
    const Real linear_loss = forces.quadratic_drag * length(through_air) * h;
    const Real angular_loss = forces.angular_quadratic_drag * absolute(body.angular_velocity) * h;
    if (linear_loss != 0) body.velocity = solved.model.wind + (1 / (1 + linear_loss)) * through_air;
    if (angular_loss != 0) body.angular_velocity = body.angular_velocity / (1 + angular_loss);
  }
}

void flow_damper(const SpringRow& spring, const SolvedSet& solved, Real h) {
  if (!(spring.damping > 0)) return;
  const SpringLine line = line_of(spring, solved.bodies);
  if (!line.exists || !(line.inv_mass > 0)) return;
  const double strength = static_cast<double>(spring.damping) * static_cast<double>(h);
  const Decay decay = signed_decay(strength * static_cast<double>(line.inv_mass));
  const Vec2 impulse =
      (static_cast<Real>(strength * decay.mean) * speed_along(spring, line, solved.bodies)) * line.along;  // on A
  MovingBody& a = solved.bodies.records[spring.body_a];
  a.velocity = a.velocity + spring.inv_mass_a * impulse;
  a.angular_velocity += spring.inv_inertia_a * cross(line.arm_a, impulse);
  MovingBody& b = solved.bodies.records[spring.write_b];
  b.velocity = b.velocity - spring.inv_mass_b * impulse;
  b.angular_velocity -= spring.inv_inertia_b * cross(line.arm_b, impulse);
}

}  // namespace

Real power(Real r, int exponent) {
  const int count = exponent < 0 ? -exponent : exponent;
  Real product = 1;
  for (int i = 0; i < count; ++i) product = product * r;
  return exponent < 0 ? 1 / product : product;
}

SpringLine line_of(const SpringRow& spring, const SolverBodies& bodies) {
  const MovingBody& a = bodies.records[spring.body_a];
  const MovingBody& b = bodies.records[spring.body_b];
  SpringLine line;
  line.arm_a = rotate(a.delta_rotation, spring.arm_a);
  line.arm_b = rotate(b.delta_rotation, spring.arm_b);
  const Vec2 offset = (spring.offset + (b.delta_position - a.delta_position)) + (line.arm_b - line.arm_a);
  line.length = length(offset);
  line.exists = line.length > 0;
  if (!line.exists) return line;
  line.along = (1 / line.length) * offset;
  line.tension = spring.stiffness * (line.length - spring.rest_length);
  const Real lever_a = cross(line.arm_a, line.along);
  const Real lever_b = cross(line.arm_b, line.along);
  line.inv_mass = (spring.inv_mass_a + spring.inv_mass_b) +
                  (spring.inv_inertia_a * lever_a * lever_a + spring.inv_inertia_b * lever_b * lever_b);
  return line;
}

Real speed_along(const SpringRow& spring, const SpringLine& line, const SolverBodies& bodies) {
  const MovingBody& a = bodies.records[spring.body_a];
  const MovingBody& b = bodies.records[spring.body_b];
  const Vec2 relative =
      (b.velocity + cross(b.angular_velocity, line.arm_b)) - (a.velocity + cross(a.angular_velocity, line.arm_a));
  return dot(relative, line.along);
}

void add_forces(Model& model) {
  const std::vector<Force>& forces = model.scene.forces;
  if (forces.empty()) return;
  model.body_forces.resize(model.bodies.size());
  Point wind;
  for (const Force& force : forces)
    if (force.kind == ForceKind::wind) wind = {wind.x + force.vector.x, wind.y + force.vector.y};
  model.wind = vector_of(wind);
  for (const Force& force : forces) {
    if (force.kind == ForceKind::spring) {
      add_spring(model, force);
    } else if (force.kind == ForceKind::central) {
      add_central(model, force);
    } else if (force.body) {
      add_to_body(model, *force.body, force, wind);
    } else {
      for (std::size_t source = 0; source < model.bodies.size(); ++source) add_to_body(model, source, force, wind);
    }
  }
  if (!model.centrals.empty() || !model.springs.empty()) model.position_forces = add_element_accelerations;
}

namespace {

/// Whether a spring acts on bodies of the present set. Both bodies of a spring are in one island.
bool is_in_set(const SolvedSet& solved, const SpringForce& spring, std::size_t row_a) {
  if (solved.has_body(row_a)) return true;
  if (spring.other == no_reference) return false;
  const std::size_t row_b = solved.state.find_body(spring.other);
  return row_b < solved.state.bodies.size() && solved.has_body(row_b);
}

}  // namespace

void prepare_forces(const SolvedSet& solved, MotionWorkspace& work) {
  work.accelerations.resize(solved.bodies.records.size());
  work.central_rows.clear();
  for (const CentralForce& central : solved.model.centrals) {
    const std::size_t row = central.every ? solved.state.bodies.size() : solved.state.find_body(central.body);
    work.central_rows.push_back(row < solved.state.bodies.size() ? static_cast<std::uint32_t>(row) : no_reference);
  }
  work.springs.clear();
  for (const SpringForce& spring : solved.model.springs) {
    const std::size_t row_a = solved.state.find_body(spring.body);
    if (row_a == solved.state.bodies.size()) continue;
    if (!is_in_set(solved, spring, row_a)) continue;
    const BodyRow& a = solved.state.bodies[row_a];
    const BodyModel& constants_a = solved.model.bodies[a.source];
    SpringRow out{};
    out.body_a = static_cast<std::uint32_t>(row_a);
    out.arm_a = rotate(a.rotation, spring.anchor);
    out.inv_mass_a = constants_a.inv_mass;
    out.inv_inertia_a = constants_a.inv_inertia;
    if (spring.other == no_reference) {
      out.body_b = dummy_body(solved.bodies);
      out.write_b = dummy_sink(solved.bodies);
      out.offset = spring.point - a.position;
    } else {
      const std::size_t row_b = solved.state.find_body(spring.other);
      if (row_b == solved.state.bodies.size()) continue;
      const BodyRow& b = solved.state.bodies[row_b];
      const BodyModel& constants_b = solved.model.bodies[b.source];
      out.body_b = static_cast<std::uint32_t>(row_b);
      out.write_b = out.body_b;
      out.offset = b.position - a.position;
      out.arm_b = rotate(b.rotation, spring.point);
      out.inv_mass_b = constants_b.inv_mass;
      out.inv_inertia_b = constants_b.inv_inertia;
    }
    out.stiffness = spring.stiffness;
    out.damping = spring.damping;
    out.rest_length = spring.rest_length;
    work.springs.push_back(out);
  }
}

void add_velocity_forces(const SolvedSet& solved, MotionWorkspace& work, Real drag_rate_max) {
  if (!solved.model.has_velocity_forces) return;
  for (const std::uint32_t row : solved.rows) {
    const BodyForces& forces = solved.model.body_forces[solved.state.bodies[row].source];
    const MovingBody& body = solved.bodies.records[row];
    const Vec2 through_air = body.velocity - solved.model.wind;
    Twist& acceleration = work.accelerations[row];
    const Real rate = smaller(forces.quadratic_drag * length(through_air), drag_rate_max);
    const Real angular_rate = smaller(forces.angular_quadratic_drag * absolute(body.angular_velocity), drag_rate_max);
    acceleration.linear = acceleration.linear - rate * through_air;
    acceleration.angular -= angular_rate * body.angular_velocity;
  }
  for (const SpringRow& spring : work.springs) {
    if (!(spring.damping > 0)) continue;
    const SpringLine line = line_of(spring, solved.bodies);
    if (line.exists)
      accelerate(work, spring, line, (spring.damping * speed_along(spring, line, solved.bodies)) * line.along);
  }
}

void flow_velocity_forces(const SolvedSet& solved, MotionWorkspace& work, Real h, FlowOrder order) {
  if (!solved.model.has_velocity_forces) return;
  if (order == FlowOrder::forward) {
    flow_drags(solved, h);
    for (const SpringRow& spring : work.springs) flow_damper(spring, solved, h);
  } else {
    for (std::size_t i = work.springs.size(); i-- > 0;) flow_damper(work.springs[i], solved, h);
    flow_drags(solved, h);
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
