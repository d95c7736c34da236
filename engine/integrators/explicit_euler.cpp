// Explicit Euler: x' = x + h v, v' = v + h a(x). Order 1, stable for no w h: amplitudes grow by sqrt(1 + w^2 h^2).
// SPDX-License-Identifier: MIT
// Source: Hairer, Lubich, Wanner, "Geometric Numerical Integration", 2006, section I.1. Damping as in
// semi_implicit_euler.
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void begin_explicit_euler(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  prepare_velocity_steps(solved, work, h);
  prepare_forces(solved, work);
}

void predict_explicit_euler(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  save_start(solved, work);
  step_velocities(solved, work);
  flow_velocity_forces(solved, work, h, FlowOrder::forward);
  for (const std::uint32_t row : solved.rows) {
    const MovingBody& start = work.stages[row].start;
    drift_with(solved, work, row, {start.velocity, start.angular_velocity});
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
