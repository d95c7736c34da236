// The classical Runge-Kutta scheme. Order 4, stable for w h < 2 sqrt(2) and for dampers with c h < 2.785.
// SPDX-License-Identifier: MIT
// Source: Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I", 1993, section II.1. Every force,
// damping included, is evaluated at each of the four stages.
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

struct RungeKuttaStage {
  Real fraction;  // of the stage after this one, in steps
  Real weight;    // of this stage
};
constexpr RungeKuttaStage rk4_stages[4] = {
    {Real(1.0 / 2), Real(1.0 / 6)}, {Real(1.0 / 2), Real(1.0 / 3)}, {Real(1), Real(1.0 / 3)}, {Real(0), Real(1.0 / 6)}};

}  // namespace

void begin_rk4(const SolvedSet& solved, MotionWorkspace& work, Real) {
  prepare_constant_accelerations(solved, work);
  prepare_forces(solved, work);
}

void predict_rk4(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  save_start(solved, work);
  for (const RungeKuttaStage& stage : rk4_stages) {
    total_accelerations(solved, work, 1 / h);
    for (const std::uint32_t row : solved.rows) {
      MovingBody& body = solved.bodies.records[row];
      StageRow& sums = work.stages[row];
      const MovingBody& start = sums.start;
      const Twist& slope = work.accelerations[row];
      sums.velocities.linear = sums.velocities.linear + stage.weight * body.velocity;
      sums.velocities.angular += stage.weight * body.angular_velocity;
      sums.accelerations.linear = sums.accelerations.linear + stage.weight * slope.linear;
      sums.accelerations.angular += stage.weight * slope.angular;
      const Real step = stage.fraction * h;
      body.delta_position = start.delta_position + step * body.velocity;
      body.delta_rotation = rotation_by(step * body.angular_velocity) * start.delta_rotation;
      body.velocity = start.velocity + step * slope.linear;
      body.angular_velocity = start.angular_velocity + step * slope.angular;
    }
  }
  for (const std::uint32_t row : solved.rows) {
    const StageRow& sums = work.stages[row];
    MovingBody& body = solved.bodies.records[row];
    body = sums.start;
    body.velocity = body.velocity + h * sums.accelerations.linear;
    body.angular_velocity += h * sums.accelerations.angular;
    drift_with(solved, work, row, sums.velocities);
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
