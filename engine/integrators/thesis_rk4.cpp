// Runge-Kutta as the thesis prints it: order 1, oscillations grow at every step.
// SPDX-License-Identifier: MIT
// Source: Claes, graduation work, DAE Howest, 2024, figure 6: k2v = (a + k1v / 2) h and so on. Forces are sampled once.
// Half a change of velocity is added to an acceleration, so gravity is too strong by h / 2 and more (in SI units).
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// Mean velocity of the step and change of velocity, for one coordinate.
struct ThesisStep {
  Real drift;
  Real change;
};

ThesisStep thesis_step(Real velocity, Real acceleration, Real h) {
  const Real k1v = acceleration * h;
  const Real k2v = (acceleration + Real(0.5) * k1v) * h;
  const Real k3v = (acceleration + Real(0.5) * k2v) * h;
  const Real k4v = (acceleration + k3v) * h;
  const Real v2 = velocity + Real(0.5) * k1v;
  const Real v3 = velocity + Real(0.5) * k2v;
  const Real v4 = velocity + k3v;
  return {(velocity + 2 * v2 + 2 * v3 + v4) / 6, (k1v + 2 * k2v + 2 * k3v + k4v) / 6};
}

}  // namespace

void begin_thesis_rk4(const SolvedSet& solved, MotionWorkspace& work, Real) {
  prepare_constant_accelerations(solved, work);
  prepare_forces(solved, work);
}

void predict_thesis_rk4(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  total_accelerations(solved, work, 1 / h);
  work.drift.offsets.resize(solved.state.bodies.size());
  work.drift.predicted.resize(solved.state.bodies.size());
  for (const std::uint32_t row : solved.rows) {
    MovingBody& body = solved.bodies.records[row];
    const Twist& slope = work.accelerations[row];
    const ThesisStep x = thesis_step(body.velocity.x, slope.linear.x, h);
    const ThesisStep y = thesis_step(body.velocity.y, slope.linear.y, h);
    const ThesisStep rotation = thesis_step(body.angular_velocity, slope.angular, h);
    body.velocity = body.velocity + Vec2{x.change, y.change};
    body.angular_velocity += rotation.change;
    drift_with(solved, work, row, {{x.drift, y.drift}, rotation.drift});
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
