// Bodies and springs as integrators see them.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "engine/model/body_rows.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The change of velocities over one step of a given length, without constraints: v' = decay * v + gain * acceleration.
/// Exact for constant acceleration and linear damping.
struct FreeMotion {
  Real linear_decay;
  Real linear_gain;  // s
  Real angular_decay;
  Real angular_gain;  // s
};

/// A linear and an angular part: of an acceleration, or of a change of velocity.
struct Twist {
  Vec2 linear;       // m/s^2 or m/s
  Real angular = 0;  // rad/s^2 or rad/s
};

/// The sums of a scheme with several stages during a substep.
struct StageRow {
  MovingBody start;
  Twist velocities;     // sum over the stages so far, with their weights
  Twist accelerations;  // likewise
};

/// A spring of this tick, with the rows of its bodies. The dummy body stands for the world.
struct SpringRow {
  std::uint32_t body_a;   // record of scratch.bodies
  std::uint32_t body_b;   // record, read
  std::uint32_t write_b;  // record, written
  Vec2 offset;            // from A's centre of mass to B's (or the point of the world) when the tick began, m
  Vec2 arm_a;             // from A's centre of mass when the tick began, world axes, m
  Vec2 arm_b;
  Real inv_mass_a, inv_mass_b;        // 1/kg
  Real inv_inertia_a, inv_inertia_b;  // 1/(kg m^2)
  Real stiffness, damping, rest_length;
};

/// One spring in the linearised equations of implicit_midpoint.
struct SpringBlock {
  std::uint32_t body_a;
  std::uint32_t body_b;
  Vec2 along;
  Vec2 arm_a, arm_b;                      // m
  Real stiff_along;                       // kg
  Real stiff_across;                      // kg
  Real stiff_angular_a, stiff_angular_b;  // kg m^2
};

/// FreeMotion with the accelerations of one body, for one substep: v' = decay * v + gain.
struct alignas(8 * sizeof(Real)) VelocityStep {
  Real gain[4];   // x, y in m/s, angular in rad/s, 0
  Real decay[4];  // x, y, angular, 0
};
static_assert(sizeof(VelocityStep) == body_record_length * sizeof(Real));

/// A cache of the steps of all bodies. It is valid for the same bodies, without forces of their own, gravity and step
/// length.
struct VelocitySteps {
  bool is_valid = false;
  std::uint32_t body_set = 0;      // PairCache::body_set
  Vec2 gravity{0, 0};              // m/s^2
  Real h = 0;                      // s
  std::vector<VelocityStep> rows;  // [body]
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
