// The bricks that schemes are made of: each advances velocities or positions of all bodies, the other held fixed.
// SPDX-License-Identifier: MIT
// Source: Hairer, Lubich, Wanner, "Geometric Numerical Integration", 2006, section II.5 (splitting).
#pragma once

#include "engine/forces/forces.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Fills scratch.velocity_steps for steps of length h: exact for constant acceleration and linear damping.
void prepare_velocity_steps(const Model& model, const State& state, Scratch& scratch, Real h);

/// v' = e^(-c h) v + a (1 - e^(-c h)) / c with a at the present poses, h as prepared.
void step_velocities(const Model& model, const State& state, Scratch& scratch);

/// x' = x + h v.
void move_bodies(Scratch& scratch, Real h);

/// Fills scratch.constant_accelerations, for total_accelerations.
void prepare_constant_accelerations(const Model& model, const State& state, Scratch& scratch);

/// All accelerations of dynamic bodies, damping included, at the present poses and velocities: scratch.accelerations.
void total_accelerations(const Model& model, const State& state, Scratch& scratch);

/// Keeps the present records in scratch.stages, where the substep begins.
void keep_start(const State& state, Scratch& scratch);

/// Keeps what the present velocities exceed `drift` by, and makes `drift` the present velocity.
inline void drift_with(Scratch& scratch, std::size_t row, Twist drift) {
  MovingBody& body = scratch.bodies[row];
  scratch.velocity_offsets[row] = {body.velocity - drift.linear, body.angular_velocity - drift.angular};
  body.velocity = drift.linear;
  body.angular_velocity = drift.angular;
}

/// x' = x + h v with the drift velocity; then the velocity of the end of the substep.
void move_and_end(const Model& model, const State& state, Scratch& scratch, Real h);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
