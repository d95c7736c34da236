// The arguments of kernels, the same for every instruction set: plain numbers in batches of eight lanes.
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

/// Kernels read a MovingBody as this many numbers: velocity x, y, angular velocity, 0; delta position x, y; delta
/// rotation c, s.
inline constexpr int body_record_length = 8;

/// Integration of velocities and positions. `rows`: `count` different records of `bodies`.
struct MotionKernels {
  /// v' = decay * v + gain; steps[record]: gain x, y, angular, 0; decay x, y, angular, 0.
  void (*step_velocities)(Real* bodies, const Real* steps, const std::uint32_t* rows, std::size_t count);
  /// x' = x + h v. Empty lanes read record `dummy` and write record `sink`.
  void (*move_bodies)(Real* bodies, const std::uint32_t* rows, std::size_t count, std::uint32_t dummy,
                      std::uint32_t sink, Real h);
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
