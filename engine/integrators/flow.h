// The parts of integration schemes: each advances velocities or positions of all bodies with the other held fixed.
// SPDX-License-Identifier: MIT
// Source: Hairer, Lubich, Wanner, "Geometric Numerical Integration", 2006, section II.5 (splitting).
#pragma once

#include "engine/integrators/forces.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Loads the state columns of integrators, and stores them.
void begin_motion(const State& state, MotionWorkspace& work);
void store_motion(const MotionWorkspace& work, State& state);

/// Fills work.velocity_steps for steps of length h: exact for constant acceleration and linear damping.
void prepare_velocity_steps(const SolvedSet& solved, MotionWorkspace& work, Real h);

/// v' = e^(-c h) v + a (1 - e^(-c h)) / c with a at the present poses, h as prepared.
void step_velocities(const SolvedSet& solved, MotionWorkspace& work);

/// x' = x + h v.
void move_bodies(const SolvedSet& solved, Real h);

/// Whether a substep consists of step_velocities and move_bodies, independently for each body.
bool bodies_step_alone(const Model& model);
/// All substeps of the set's bodies without constraints, a few bodies at a time, so that they stay in the nearest
/// cache. Requires: bodies_step_alone, prepare_velocity_steps.
void integrate_freely(const SolvedSet& solved, const MotionWorkspace& work);

/// Fills work.constant_accelerations, for total_accelerations.
void prepare_constant_accelerations(const SolvedSet& solved, MotionWorkspace& work);

/// All accelerations of dynamic bodies, damping included, at the present poses and velocities: work.accelerations.
/// drag_rate_max: as in add_velocity_forces.
void total_accelerations(const SolvedSet& solved, MotionWorkspace& work, Real drag_rate_max);

/// Saves the present records in work.stages, as the start of the substep.
void save_start(const SolvedSet& solved, MotionWorkspace& work);

/// Saves two velocities for move_bodies_by_drift: the present one, which is the end velocity of the substep without
/// constraints, and the drift velocity.
inline void drift_with(const SolvedSet& solved, MotionWorkspace& work, std::size_t row, Twist drift) {
  const MovingBody& body = solved.bodies.records[row];
  work.drift.predicted[row] = {body.velocity, body.angular_velocity};
  work.drift.offsets[row] = {body.velocity - drift.linear, body.angular_velocity - drift.angular};
}

/// The difference between the effect of a force on the end velocity and on the drift velocity, as a share: of
/// drift_on_mean and drift_on_start.
inline constexpr Real share_of_mean = Real(0.5);
inline constexpr Real share_of_start = 1;

/// The drift velocity plus the changes by constraints since predict. An impulse that acts like a force (a resting
/// contact) changes the drift velocity as a force would: by `share` less than the end velocity. A much larger impulse
/// (an impact) changes both velocities alike. So do joints that are solved directly.
Twist drift_velocity(const MotionWorkspace& work, std::size_t row, const MovingBody& body, Real share);
/// x' = x + h d, with d from drift_velocity.
void move_bodies_by_drift(const SolvedSet& solved, MotionWorkspace& work, Real h, Real share);

/// The drift of schemes whose drift velocity takes half of a constant acceleration, and of schemes whose drift velocity
/// takes none.
void drift_on_mean(const SolvedSet& solved, MotionWorkspace& work, Real h);
void drift_on_start(const SolvedSet& solved, MotionWorkspace& work, Real h);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
