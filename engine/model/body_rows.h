// Bodies in the layout of solvers.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine/math/vec2.h"
#include "engine/simd/lanes.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The hot record of a body: one cache line holds two in f32. Kernels gather eight at a time.
struct alignas(8 * sizeof(Real)) MovingBody {
  Vec2 velocity;                                  // m/s
  Real angular_velocity;                          // rad/s
  alignas(4 * sizeof(Real)) Vec2 delta_position;  // since the tick began, m
  Rotation delta_rotation;                        // since the tick began
};
static_assert(sizeof(MovingBody) == body_record_length * sizeof(Real));

/// The mass of a body in constraints, and its records.
struct alignas(4 * sizeof(Real)) BodyMass {
  Real inv_mass;        // 1/kg
  Real inv_inertia;     // 1/(kg m^2)
  std::uint32_t read;   // in SolverBodies::records; the dummy body for static bodies
  std::uint32_t write;  // a sink for non-dynamic bodies
};

/// A linear and an angular part: of an acceleration, or of a change of velocity.
struct Twist {
  Vec2 linear;       // m/s^2 or m/s
  Real angular = 0;  // rad/s^2 or rad/s
};

/// Whether a pass corrects positions by velocities. of_drift: it does, but springs, motors and friction have no part in
/// it, since velocities are those that move the bodies (solve_drift_velocities).
enum class Bias : std::uint8_t { off, on, of_drift };
constexpr bool corrects(Bias bias) {
  return bias != Bias::off;
}

/// Whether poses have changed since the last pass over the same joints.
enum class Poses : std::uint8_t { moved, unmoved };

/// A bit that a test flips in a hot record after a substep.
enum class BodyField : std::uint8_t { position, rotation, velocity, angular_velocity };
struct InjectedFault {
  std::size_t row = 0;
  BodyField field = BodyField::velocity;
  std::size_t lane = 0;
  std::uint32_t bit = 0;
  int substep = 0;
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
