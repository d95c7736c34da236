// Semi-implicit (symplectic) Euler: v' = v + h a(x), x' = x + h v'. Order 1, stable for w h < 2.
// SPDX-License-Identifier: MIT
// Source: Hairer, Lubich, Wanner, "Geometric Numerical Integration", 2006, section I.1. Linear damping is taken
// exactly: v' = e^(-c h) v + a (1 - e^(-c h)) / c.
#include "engine/integrators/integrator.h"
#include "engine/math/exponential.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void begin_semi_implicit_euler(const Model& model, const State& state, Scratch& scratch, Real h) {
  if (scratch.free_motion_step != h) {
    scratch.free_motion.clear();
    for (const BodyModel& body : model.bodies) {
      const Decay linear = decay_over(static_cast<double>(h) * static_cast<double>(body.linear_damping));
      const Decay angular = decay_over(static_cast<double>(h) * static_cast<double>(body.angular_damping));
      scratch.free_motion.push_back(
          {static_cast<Real>(linear.factor), static_cast<Real>(linear.mean * static_cast<double>(h)),
           static_cast<Real>(angular.factor), static_cast<Real>(angular.mean * static_cast<double>(h))});
    }
    scratch.free_motion_step = h;
  }
  scratch.velocity_steps.resize(state.bodies.size());
  for (const std::uint32_t row : scratch.moving_rows) {
    const BodyModel& body = model.bodies[state.bodies[row].source];
    const FreeMotion& motion = scratch.free_motion[state.bodies[row].source];
    if (body.type != BodyType::dynamic_body) {
      scratch.velocity_steps[row] = {{0, 0}, 0, 1, 1};
      continue;
    }
    Vec2 acceleration = body.gravity_scale * state.world.gravity;
    Real angular_acceleration = 0;
    if (!scratch.force.empty()) {
      acceleration = acceleration + body.inv_mass * scratch.force[row];
      angular_acceleration = body.inv_inertia * scratch.torque[row];
    }
    scratch.velocity_steps[row] = {motion.linear_gain * acceleration, motion.angular_gain * angular_acceleration,
                                   motion.linear_decay, motion.angular_decay};
  }
}

void predict_semi_implicit_euler(const Model&, const State&, Scratch& scratch, Real) {
  for (const std::uint32_t row : scratch.moving_rows) {
    MovingBody& body = scratch.bodies[row];
    const VelocityStep& step = scratch.velocity_steps[row];
    body.velocity = step.linear_decay * body.velocity + step.velocity;
    body.angular_velocity = step.angular_decay * body.angular_velocity + step.angular_velocity;
  }
}

void drift_semi_implicit_euler(const Model&, const State&, Scratch& scratch, Real h) {
  for (const std::uint32_t row : scratch.moving_rows) {
    MovingBody& body = scratch.bodies[row];
    body.moved = body.moved + h * body.velocity;
    body.turned = rotation_by(h * body.angular_velocity) * body.turned;
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
