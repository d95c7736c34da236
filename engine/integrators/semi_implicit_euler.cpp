// Semi-implicit (symplectic) Euler: v' = v + h a(x), x' = x + h v'. Order 1, stable for w h < 2.
// SPDX-License-Identifier: MIT
// Source: Hairer, Lubich, Wanner, "Geometric Numerical Integration", 2006, section I.1. Linear damping is taken
// exactly: v' = e^(-c h) v + a (1 - e^(-c h)) / c; then quadratic drags and dampers, exactly too.
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void begin_semi_implicit_euler(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  prepare_velocity_steps(solved, work, h);
  prepare_forces(solved, work);
}

void predict_semi_implicit_euler(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  step_velocities(solved, work);
  flow_velocity_forces(solved, work, h, FlowOrder::forward);
}

void drift_semi_implicit_euler(const SolvedSet& solved, MotionWorkspace&, Real h) {
  move_bodies(solved, h);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
