// The bricks that schemes are made of: each advances velocities or positions of all bodies, the other held fixed.
// SPDX-License-Identifier: MIT
// Source: Hairer, Lubich, Wanner, "Geometric Numerical Integration", 2006, section II.5 (splitting).
#pragma once

#include "engine/integrators/forces.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Fills scratch.caches.velocity_steps for steps of length h: exact for constant acceleration and linear damping.
void prepare_velocity_steps(const Model& model, const State& state, Scratch& scratch, Real h);

/// v' = e^(-c h) v + a (1 - e^(-c h)) / c with a at the present poses, h as prepared.
void step_velocities(const Model& model, const State& state, Scratch& scratch);

/// x' = x + h v.
void move_bodies(Scratch& scratch, Real h);

/// Whether a substep is step_velocities and move_bodies, each body by itself.
bool bodies_step_alone(const Model& model);
/// All substeps of bodies on which nothing acts between them: the same steps, so many bodies at a time that they stay
/// in the nearest cache. Requires: bodies_step_alone, prepare_velocity_steps.
void integrate_freely(Scratch& scratch, Real h, int substeps);

/// Fills scratch.constant_accelerations, for total_accelerations.
void prepare_constant_accelerations(const Model& model, const State& state, Scratch& scratch);

/// All accelerations of dynamic bodies, damping included, at the present poses and velocities: scratch.accelerations.
void total_accelerations(const Model& model, const State& state, Scratch& scratch);

/// Keeps the present records in scratch.stages, where the substep begins.
void save_start(const State& state, Scratch& scratch);

/// The present velocity is that of the end of the substep without constraints, and bodies drift with `drift`. Keeps
/// both, for move_bodies_by_drift.
inline void drift_with(Scratch& scratch, std::size_t row, Twist drift) {
  const MovingBody& body = scratch.bodies[row];
  scratch.predicted[row] = {body.velocity, body.angular_velocity};
  scratch.velocity_offsets[row] = {body.velocity - drift.linear, body.angular_velocity - drift.angular};
}

/// x' = x + h d, where d is the drift velocity with what constraints have changed since predict. An impulse that acts
/// like a force (a contact at rest) goes to the drift velocity as a force would: `share` of it less than to the end
/// velocity. Where it is much larger than the forces (an impact), it goes there whole.
void move_bodies_by_drift(Scratch& scratch, Real h, Real share);

/// The drift of schemes whose drift velocity takes half of a constant acceleration, and of those where it takes none.
void drift_on_mean(const Model& model, const State& state, Scratch& scratch, Real h);
void drift_on_start(const Model& model, const State& state, Scratch& scratch, Real h);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
