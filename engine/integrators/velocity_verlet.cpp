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
}

void drift_velocity_verlet(const Model& model, const State& state, Scratch& scratch, Real h) {
  move_bodies(scratch, h);
  step_velocities(model, state, scratch);
  flow_velocity_forces(model, state, scratch, Real(0.5) * h, FlowOrder::backward);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
