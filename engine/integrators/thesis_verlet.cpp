// Verlet as the thesis prints it: order 1, oscillations grow at every step.
// SPDX-License-Identifier: MIT
// Source: Claes, graduation work, DAE Howest, 2024, figure 5: x' = x + h v + h^2 a_n / 2, v' = v + h (a_n + a_n-1) / 2.
// Forces are sampled once, at the start. The velocity takes the acceleration of the step before, where velocity Verlet
// takes the acceleration at the new positions. The first step has no step before: half a step of gravity is missing for
// good.
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void begin_thesis_verlet(const SolvedSet& solved, MotionWorkspace& work, Real) {
  prepare_constant_accelerations(solved, work);
  prepare_forces(solved, work);
}

void predict_thesis_verlet(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  total_accelerations(solved, work, 1 / h);
  work.drift.offsets.resize(solved.state.bodies.size());
  work.drift.predicted.resize(solved.state.bodies.size());
  for (const std::uint32_t row : solved.rows) {
    MovingBody& body = solved.bodies.records[row];
    const Twist& now = work.accelerations[row];
    Twist& before = work.previous_accelerations[row];
    const Real half = Real(0.5) * h;
    const Twist drift{body.velocity + half * now.linear, body.angular_velocity + half * now.angular};
    body.velocity = body.velocity + half * (now.linear + before.linear);
    body.angular_velocity += half * (now.angular + before.angular);
    drift_with(solved, work, row, drift);
    before = now;
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
