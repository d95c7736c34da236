// What solvers hand to kernels, whatever instruction set these are compiled for: plain numbers, eight lanes at a time.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/math/scalar.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

inline constexpr int lane_count = 8;

/// One value for each lane of a batch.
template <int count>
struct alignas(lane_count * sizeof(Real)) LanesOf {
  Real at[count];
};
using Lanes = LanesOf<lane_count>;

/// impulse = -effective_mass * mass_scale * (velocity + bias_rate * error) - impulse_scale * accumulated impulse
struct Softness {
  Real bias_rate = 0;  // 1/s
  Real mass_scale = 1;
  Real impulse_scale = 0;
};

/// Kernels see MovingBody as so many numbers: velocity x, y, angular velocity, 0; moved x, y, turned c, s.
inline constexpr int body_record_length = 8;

/// How bodies advance by themselves. `rows`: `count` records of `bodies`, no two alike.
struct MotionKernels {
  /// v' = decay * v + gain; steps[record]: gain x, y, angular, 0; decay x, y, angular, 0.
  void (*step_velocities)(Real* bodies, const Real* steps, const std::uint32_t* rows, std::size_t count);
  /// x' = x + h v. `resting`, `unread`: records for empty lanes.
  void (*move_bodies)(Real* bodies, const std::uint32_t* rows, std::size_t count, std::uint32_t resting,
                      std::uint32_t unread, Real h);
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
