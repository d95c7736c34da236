// Velocity Verlet: half a kick, a drift, half a kick with the new positions. Order 2, symplectic, stable for w h < 2.
// SPDX-License-Identifier: MIT
// Source: Hairer, Lubich, Wanner, "Geometric numerical integration illustrated by the Stormer-Verlet method", Acta
// Numerica 2003. Kicks treat linear damping exactly. Quadratic drags and dampers flow for h / 2 before the first kick
// and, mirrored, after the second kick. The scheme therefore stays symmetric and of order 2.
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void begin_velocity_verlet(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  prepare_velocity_steps(solved, work, Real(0.5) * h);
  prepare_forces(solved, work);
}

void predict_velocity_verlet(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  flow_velocity_forces(solved, work, Real(0.5) * h, FlowOrder::forward);
  step_velocities(solved, work);
  save_start(solved, work);
  // The second half step of the velocities assumes that forces do not change within the step: constraints act on the
  // end velocity.
  step_velocities(solved, work);
  flow_velocity_forces(solved, work, Real(0.5) * h, FlowOrder::backward);
  for (const std::uint32_t row : solved.rows) {
    const MovingBody& middle = work.stages[row].start;
    drift_with(solved, work, row, {middle.velocity, middle.angular_velocity});
  }
}

void drift_velocity_verlet(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  move_bodies_by_drift(solved, work, h, share_of_mean);
  if (solved.model.position_forces == nullptr && !solved.model.has_velocity_forces) return;
  // The second kick again with the forces at the present poses, plus the changes by constraints.
  for (const std::uint32_t row : solved.rows) {
    MovingBody& body = solved.bodies.records[row];
    const Twist& predicted = work.drift.predicted[row];
    work.drift.offsets[row] = {body.velocity - predicted.linear, body.angular_velocity - predicted.angular};
    body.velocity = work.stages[row].start.velocity;
    body.angular_velocity = work.stages[row].start.angular_velocity;
  }
  step_velocities(solved, work);
  flow_velocity_forces(solved, work, Real(0.5) * h, FlowOrder::backward);
  for (const std::uint32_t row : solved.rows) {
    MovingBody& body = solved.bodies.records[row];
    body.velocity = body.velocity + work.drift.offsets[row].linear;
    body.angular_velocity += work.drift.offsets[row].angular;
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
