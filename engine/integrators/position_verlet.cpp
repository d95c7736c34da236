// Position Verlet: half a drift, a kick, half a drift. Order 2, symplectic, stable for w h < 2.
// SPDX-License-Identifier: MIT
// Source: Hairer, Lubich, Wanner, "Geometric numerical integration illustrated by the Stormer-Verlet method", Acta
// Numerica 2003. The kick takes linear damping exactly; quadratic drags and dampers flow for h / 2 before and,
// mirrored, after it. The two half drifts are one with the mean velocity: x' = x + h (v + v') / 2.
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void begin_position_verlet(const Model& model, const State& state, Scratch& scratch, Real h) {
  prepare_velocity_steps(model, state, scratch, h);
  prepare_forces(model, state, scratch);
}

void predict_position_verlet(const Model& model, const State& state, Scratch& scratch, Real h) {
  save_start(state, scratch);
  move_bodies(scratch, Real(0.5) * h);
  flow_velocity_forces(model, state, scratch, Real(0.5) * h, FlowOrder::forward);
  step_velocities(model, state, scratch);
  flow_velocity_forces(model, state, scratch, Real(0.5) * h, FlowOrder::backward);
  for (const std::uint32_t row : scratch.moving_rows) {
    MovingBody& body = scratch.bodies[row];
    const MovingBody& start = scratch.stages[row].start;
    body.delta_position = start.delta_position;
    body.delta_rotation = start.delta_rotation;
    drift_with(
        scratch, row,
        {Real(0.5) * (start.velocity + body.velocity), Real(0.5) * (start.angular_velocity + body.angular_velocity)});
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
