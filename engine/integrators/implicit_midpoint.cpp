// Implicit midpoint: v' = v + h a(m), x' = x + h v_m with m = (x + x', v + v') / 2. Order 2, symplectic, stable for
// every w h.
// SPDX-License-Identifier: MIT
// Source: Hairer, Lubich, Wanner, "Geometric Numerical Integration", 2006, section VIII.6 (Newton iteration); Hestenes
// and Stiefel, "Methods of conjugate gradients for solving linear systems", 1952.
//
// The unknown is v_m: M (v_m - v) = h / 2 F(x + h / 2 v_m, v_m). Newton's matrix is A = M - h / 2 dF/dv - h^2 / 4
// dF/dx. It leaves out terms of falling forces (the sideways force of a compressed spring, an attraction that weakens
// with distance). A then stays positive definite, and the iteration is only slower. Conjugate gradients solve the
// linear equations to 1e-3. The iteration ends when positions change by less than 64 epsilon of their size, at the
// latest after 60 iterations. The substep then counts as unconverged.
#include <limits>

#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"
#include "engine/model/bodies.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr int newton_iteration_max = 60;
constexpr Real newton_tolerance = 64 * epsilon;
constexpr Real gradient_tolerance_squared = Real(1e-6);
constexpr std::size_t gradient_iteration_max = 2000;

enum Rows : std::size_t { diagonal, solution, residual, direction, product };

Real positive(Real value) {
  return larger(value, 0);
}

Twist zero_if_fixed(Twist value, const BodyModel* body) {
  if (body == nullptr || body->type != BodyType::dynamic_body) return {};
  return {value.linear, body->inv_inertia > 0 ? value.angular : Real(0)};
}

/// The model of the record's body; null for dummy records and for bodies outside of the set. This set does not solve
/// their equations, and their rows of `stages` and `accelerations` are not of this tick.
const BodyModel* body_of(const SolvedSet& solved, std::size_t record) {
  const bool is_in = record < solved.state.bodies.size() && solved.has_body(record);
  return is_in ? &solved.model.bodies[solved.state.bodies[record].source] : nullptr;
}

/// Stiffness of central forces on a body, times h^2 / 4, in kg: the same in every direction, an upper bound.
Real central_stiffness(const SolvedSet& solved, const MotionWorkspace& work, std::size_t row, Real h) {
  Real sum = 0;
  for (std::size_t i = 0; i < solved.model.centrals.size(); ++i) {
    const CentralForce& central = solved.model.centrals[i];
    if (!central.every && work.central_rows[i] != row) continue;
    const Vec2 r = (solved.state.bodies[row].position - central.center) + solved.bodies.records[row].delta_position;
    const Real distance = length(r);
    if (!(distance > 0)) continue;
    const Real across = central.strength * power(distance, central.exponent - 1);
    sum += positive(larger(across, across * static_cast<Real>(central.exponent)));
  }
  return Real(0.25) * h * h * sum * solved.model.bodies[solved.state.bodies[row].source].mass;
}

/// Fills the matrix A at the present poses: its part for single bodies and a block for each spring.
void linearise(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  std::vector<Twist>& diagonals = work.newton[diagonal];
  const Real half = Real(0.5) * h;
  for (std::size_t row = 0; row < solved.state.bodies.size(); ++row) {
    const BodyModel& body = solved.model.bodies[solved.state.bodies[row].source];
    Real linear = body.linear_damping;
    Real angular = body.angular_damping;
    if (!solved.model.body_forces.empty()) {
      const BodyForces& forces = solved.model.body_forces[solved.state.bodies[row].source];
      linear += 2 * forces.quadratic_drag * length(solved.bodies.records[row].velocity - solved.model.wind);
      angular += 2 * forces.angular_quadratic_drag * absolute(solved.bodies.records[row].angular_velocity);
    }
    const Real mass = body.mass * (1 + half * linear) + central_stiffness(solved, work, row, h);
    diagonals[row] = {{mass, mass}, body.inertia * (1 + half * angular)};
  }
  work.spring_blocks.clear();
  for (const SpringRow& spring : work.springs) {
    const SpringLine line = line_of(spring, solved.bodies);
    if (!line.exists) continue;
    SpringBlock block;
    block.body_a = spring.body_a;
    block.body_b = spring.body_b;
    block.along = line.along;
    block.arm_a = line.arm_a;
    block.arm_b = line.arm_b;
    const Real quarter = half * half;
    block.stiff_along = half * spring.damping + quarter * spring.stiffness;
    block.stiff_across = quarter * positive(line.tension) / line.length;
    block.stiff_angular_a = quarter * positive(line.tension * dot(line.along, line.arm_a));
    block.stiff_angular_b = quarter * positive(-(line.tension * dot(line.along, line.arm_b)));
    work.spring_blocks.push_back(block);
  }
}

/// out = A in, on free coordinates.
void multiply(const SolvedSet& solved, MotionWorkspace& work, const std::vector<Twist>& in, std::vector<Twist>& out) {
  const std::vector<Twist>& diagonals = work.newton[diagonal];
  for (std::size_t row = 0; row < solved.state.bodies.size(); ++row)
    out[row] = {diagonals[row].linear.x * in[row].linear, diagonals[row].angular * in[row].angular};
  for (const SpringBlock& block : work.spring_blocks) {
    const Twist& a = in[block.body_a];
    const Twist& b = in[block.body_b];
    const Vec2 relative = (b.linear + cross(b.angular, block.arm_b)) - (a.linear + cross(a.angular, block.arm_a));
    const Real along = dot(relative, block.along);
    const Vec2 force =
        (block.stiff_along * along) * block.along + block.stiff_across * (relative - along * block.along);
    Twist& to_a = out[block.body_a];
    to_a = {to_a.linear - force, to_a.angular - cross(block.arm_a, force) + block.stiff_angular_a * a.angular};
    Twist& to_b = out[block.body_b];
    to_b = {to_b.linear + force, to_b.angular + cross(block.arm_b, force) + block.stiff_angular_b * b.angular};
  }
  for (std::size_t record = 0; record < out.size(); ++record)
    out[record] = zero_if_fixed(out[record], body_of(solved, record));
}

Real product_of(const std::vector<Twist>& a, const std::vector<Twist>& b, std::size_t count) {
  Real sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += dot(a[i].linear, b[i].linear) + a[i].angular * b[i].angular;
  return sum;
}

/// Solves A solution = residual by conjugate gradients. The preconditioner is the part of the single bodies.
void solve_linear(const SolvedSet& solved, MotionWorkspace& work) {
  auto& scale = work.newton[0];
  auto& x = work.newton[1];
  auto& r = work.newton[2];
  auto& p = work.newton[3];
  auto& q = work.newton[4];
  const std::size_t count = solved.state.bodies.size();
  const auto precondition = [&](std::size_t i) {
    return Twist{{r[i].linear.x == 0 ? Real(0) : r[i].linear.x / scale[i].linear.x,
                  r[i].linear.y == 0 ? Real(0) : r[i].linear.y / scale[i].linear.y},
                 r[i].angular == 0 ? Real(0) : r[i].angular / scale[i].angular};
  };
  const auto weighted = [&] {
    Real sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const Twist z = precondition(i);
      sum += dot(z.linear, r[i].linear) + z.angular * r[i].angular;
    }
    return sum;
  };
  for (std::size_t i = 0; i < x.size(); ++i) {
    x[i] = {};
    p[i] = i < count ? precondition(i) : Twist{};
  }
  Real error = weighted();
  const Real wanted = gradient_tolerance_squared * error;
  const std::size_t iteration_max = 3 * count + 50 < gradient_iteration_max ? 3 * count + 50 : gradient_iteration_max;
  for (std::size_t iteration = 0; iteration < iteration_max && error > wanted; ++iteration) {
    multiply(solved, work, p, q);
    const Real curvature = product_of(p, q, count);
    if (!(curvature > 0)) return;
    const Real step = error / curvature;
    for (std::size_t i = 0; i < count; ++i) {
      x[i] = {x[i].linear + step * p[i].linear, x[i].angular + step * p[i].angular};
      r[i] = {r[i].linear - step * q[i].linear, r[i].angular - step * q[i].angular};
    }
    const Real next = weighted();
    const Real beta = next / error;
    for (std::size_t i = 0; i < count; ++i) {
      const Twist z = precondition(i);
      p[i] = {z.linear + beta * p[i].linear, z.angular + beta * p[i].angular};
    }
    error = next;
  }
}

/// Moves bodies to the middle of the substep. Requires: the present velocities are the velocities of the middle.
void move_to_middle(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  for (const std::uint32_t row : solved.rows) {
    MovingBody& body = solved.bodies.records[row];
    const MovingBody& start = work.stages[row].start;
    body.delta_position = start.delta_position + (Real(0.5) * h) * body.velocity;
    body.delta_rotation = rotation_by(Real(0.5) * h * body.angular_velocity) * start.delta_rotation;
  }
}

/// The reference length for the rounding of positions, m: lengths of springs, distances to centres, at least 1.
Real size_of_system(const SolvedSet& solved, const MotionWorkspace& work) {
  Real size = 1;
  for (const SpringRow& spring : work.springs) {
    const Vec2 offset = spring.offset + (spring.arm_b - spring.arm_a);
    size = larger(size, absolute(offset.x) + absolute(offset.y));
  }
  for (const CentralForce& central : solved.model.centrals)
    for (const BodyRow& body : solved.state.bodies)
      size = larger(size, absolute(body.position.x - central.center.x) + absolute(body.position.y - central.center.y));
  return size;
}

/// One Newton iteration. Returns the largest change of a position relative to the tolerance.
Real newton_iteration(const SolvedSet& solved, MotionWorkspace& work, Real h, Real size) {
  move_to_middle(solved, work, h);
  total_accelerations(solved, work, std::numeric_limits<Real>::max());
  work.newton[residual].assign(work.newton[residual].size(), Twist{});
  for (const std::uint32_t row : solved.rows) {
    const MovingBody& body = solved.bodies.records[row];
    const MovingBody& start = work.stages[row].start;
    const BodyModel& constants = solved.model.bodies[solved.state.bodies[row].source];
    const Twist& slope = work.accelerations[row];
    const Real half = Real(0.5) * h;
    work.newton[residual][row] =
        zero_if_fixed({constants.mass * ((start.velocity - body.velocity) + half * slope.linear),
                       constants.inertia * ((start.angular_velocity - body.angular_velocity) + half * slope.angular)},
                      &constants);
  }
  linearise(solved, work, h);
  solve_linear(solved, work);
  Real worst = 0;
  for (const std::uint32_t row : solved.rows) {
    MovingBody& body = solved.bodies.records[row];
    const Twist& change = work.newton[solution][row];
    body.velocity = body.velocity + change.linear;
    body.angular_velocity += change.angular;
    const Real allowed = newton_tolerance * (size + h * (absolute(body.velocity.x) + absolute(body.velocity.y)));
    const Real allowed_angle = newton_tolerance * (1 + h * absolute(body.angular_velocity));
    const Real ratio = h * (absolute(change.linear.x) + absolute(change.linear.y)) / allowed;
    const Real angle_ratio = h * absolute(change.angular) / allowed_angle;
    worst = ratio <= worst ? worst : ratio;  // a NaN stays
    worst = angle_ratio <= worst ? worst : angle_ratio;
  }
  return worst;
}

}  // namespace

void begin_implicit_midpoint(const SolvedSet& solved, MotionWorkspace& work, Real) {
  prepare_constant_accelerations(solved, work);
  prepare_forces(solved, work);
  for (std::vector<Twist>& rows : work.newton) rows.assign(solved.bodies.records.size(), Twist{});
}

void predict_implicit_midpoint(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  save_start(solved, work);
  const Real size = size_of_system(solved, work);
  bool converged = false;
  for (int iteration = 0; iteration < newton_iteration_max && !converged; ++iteration)
    converged = newton_iteration(solved, work, h, size) <= 1;
  if (!converged) ++work.unconverged;
  for (const std::uint32_t row : solved.rows) {
    MovingBody& body = solved.bodies.records[row];
    const MovingBody& start = work.stages[row].start;
    const Twist middle{body.velocity, body.angular_velocity};
    body.delta_position = start.delta_position;
    body.delta_rotation = start.delta_rotation;
    body.velocity = (middle.linear - start.velocity) + middle.linear;
    body.angular_velocity = (middle.angular - start.angular_velocity) + middle.angular;
    drift_with(solved, work, row, middle);
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
