// Position Verlet: half a drift, a kick, half a drift. Order 2, symplectic, stable for w h < 2.
// SPDX-License-Identifier: MIT
// Source: Hairer, Lubich, Wanner, "Geometric numerical integration illustrated by the Stormer-Verlet method", Acta
// Numerica 2003. The kick treats linear damping exactly. Quadratic drags and dampers flow for h / 2 before the kick
// and, mirrored, after it. The two half drifts are one drift with the mean velocity: x' = x + h (v + v') / 2.
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void begin_position_verlet(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  prepare_velocity_steps(solved, work, h);
  prepare_forces(solved, work);
}

void predict_position_verlet(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  save_start(solved, work);
  move_bodies(solved, Real(0.5) * h);
  flow_velocity_forces(solved, work, Real(0.5) * h, FlowOrder::forward);
  step_velocities(solved, work);
  flow_velocity_forces(solved, work, Real(0.5) * h, FlowOrder::backward);
  for (const std::uint32_t row : solved.rows) {
    MovingBody& body = solved.bodies.records[row];
    const MovingBody& start = work.stages[row].start;
    body.delta_position = start.delta_position;
    body.delta_rotation = start.delta_rotation;
    drift_with(
        solved, work, row,
        {Real(0.5) * (start.velocity + body.velocity), Real(0.5) * (start.angular_velocity + body.angular_velocity)});
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
