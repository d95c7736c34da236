// Verlet as the thesis has it: order 1, oscillations grow at every step.
// SPDX-License-Identifier: MIT
// Source: Claes, graduation work, DAE Howest, 2024, figure 5: x' = x + h v + h^2 a_n / 2, v' = v + h (a_n + a_n-1) / 2.
// Forces are sampled once, at the start; the velocity takes the acceleration of the step before where velocity Verlet
// takes that of the new positions, and the first step has none: half a step of gravity is missing for good.
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void begin_thesis_verlet(const Model& model, const State& state, Scratch& scratch, Real) {
  prepare_constant_accelerations(model, state, scratch);
  prepare_forces(model, state, scratch);
}

void predict_thesis_verlet(const Model& model, const State& state, Scratch& scratch, Real h) {
  total_accelerations(model, state, scratch, 1 / h);
  scratch.velocity_offsets.resize(state.bodies.size());
  scratch.predicted.resize(state.bodies.size());
  for (const std::uint32_t row : scratch.moving_rows) {
    MovingBody& body = scratch.bodies[row];
    const Twist& now = scratch.accelerations[row];
    Twist& before = scratch.previous_accelerations[row];
    const Real half = Real(0.5) * h;
    const Twist drift{body.velocity + half * now.linear, body.angular_velocity + half * now.angular};
    body.velocity = body.velocity + half * (now.linear + before.linear);
    body.angular_velocity += half * (now.angular + before.angular);
    drift_with(scratch, row, drift);
    before = now;
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
