// Velocity Verlet: half a kick, a drift, half a kick with the new positions. Order 2, symplectic, stable for w h < 2.
// SPDX-License-Identifier: MIT
// Source: Hairer, Lubich, Wanner, "Geometric numerical integration illustrated by the Stormer-Verlet method", Acta
// Numerica 2003. Kicks take linear damping exactly; quadratic drags and dampers flow for h / 2 before the first kick
// and, mirrored, after the second, so the scheme stays symmetric and of order 2.
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void begin_velocity_verlet(const Model& model, const State& state, Scratch& scratch, Real h) {
  prepare_velocity_steps(model, state, scratch, Real(0.5) * h);
  prepare_forces(model, state, scratch);
}

void predict_velocity_verlet(const Model& model, const State& state, Scratch& scratch, Real h) {
  flow_velocity_forces(model, state, scratch, Real(0.5) * h, FlowOrder::forward);
  step_velocities(model, state, scratch);
  save_start(state, scratch);
  // The second half step of the velocities, as if forces did not change within the step: constraints act on the end
  // velocity.
  step_velocities(model, state, scratch);
  flow_velocity_forces(model, state, scratch, Real(0.5) * h, FlowOrder::backward);
  for (const std::uint32_t row : scratch.moving_rows) {
    const MovingBody& middle = scratch.stages[row].start;
    drift_with(scratch, row, {middle.velocity, middle.angular_velocity});
  }
}

void drift_velocity_verlet(const Model& model, const State& state, Scratch& scratch, Real h) {
  move_bodies_by_drift(scratch, h, Real(0.5));
  if (model.position_forces == nullptr && !model.has_velocity_forces) return;
  // The second kick again with the forces where the bodies are now, and what constraints have changed.
  for (const std::uint32_t row : scratch.moving_rows) {
    MovingBody& body = scratch.bodies[row];
    const Twist& predicted = scratch.predicted[row];
    scratch.velocity_offsets[row] = {body.velocity - predicted.linear, body.angular_velocity - predicted.angular};
    body.velocity = scratch.stages[row].start.velocity;
    body.angular_velocity = scratch.stages[row].start.angular_velocity;
  }
  step_velocities(model, state, scratch);
  flow_velocity_forces(model, state, scratch, Real(0.5) * h, FlowOrder::backward);
  for (const std::uint32_t row : scratch.moving_rows) {
    MovingBody& body = scratch.bodies[row];
    body.velocity = body.velocity + scratch.velocity_offsets[row].linear;
    body.angular_velocity += scratch.velocity_offsets[row].angular;
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
