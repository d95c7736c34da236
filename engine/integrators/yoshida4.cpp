// Yoshida's composition of three velocity Verlet steps. Order 4, symplectic, stable for w h < 1.5734.
// SPDX-License-Identifier: MIT
// Source: Yoshida, "Construction of higher order symplectic integrators", Physics Letters A 150, 1990, eq. 4.4. The
// middle step goes backwards in time, where damping is growth. Strong damping (c h of some tens) therefore overflows.
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr double cube_root_of_2 = 1.2599210498948731648;
constexpr double outer = 1 / (2 - cube_root_of_2);
constexpr Real lengths[3] = {static_cast<Real>(outer), static_cast<Real>(-cube_root_of_2* outer),
                             static_cast<Real>(outer)};  // in steps

}  // namespace

void begin_yoshida4(const SolvedSet& solved, MotionWorkspace& work, Real) {
  prepare_forces(solved, work);
}

void predict_yoshida4(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  for (const Real length : lengths) {
    const Real step = length * h;
    const Real half = Real(0.5) * step;
    prepare_velocity_steps(solved, work, half);
    flow_velocity_forces(solved, work, half, FlowOrder::forward);
    step_velocities(solved, work);
    move_bodies(solved, step);
    step_velocities(solved, work);
    flow_velocity_forces(solved, work, half, FlowOrder::backward);
  }
}

void drift_yoshida4(const SolvedSet&, MotionWorkspace&, Real) {}  // predict has moved the bodies

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
