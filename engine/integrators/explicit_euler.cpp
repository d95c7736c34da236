// Explicit Euler: x' = x + h v, v' = v + h a(x). Order 1, stable for no w h: amplitudes grow by sqrt(1 + w^2 h^2).
// SPDX-License-Identifier: MIT
// Source: Hairer, Lubich, Wanner, "Geometric Numerical Integration", 2006, section I.1. Damping as in
// semi_implicit_euler.
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void begin_explicit_euler(const Model& model, const State& state, Scratch& scratch, Real h) {
  prepare_velocity_steps(model, state, scratch, h);
  prepare_forces(model, state, scratch);
}

void predict_explicit_euler(const Model& model, const State& state, Scratch& scratch, Real h) {
  save_start(state, scratch);
  step_velocities(model, state, scratch);
  flow_velocity_forces(model, state, scratch, h, FlowOrder::forward);
  for (const std::uint32_t row : scratch.moving_rows) {
    const MovingBody& start = scratch.stages[row].start;
    drift_with(scratch, row, {start.velocity, start.angular_velocity});
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
