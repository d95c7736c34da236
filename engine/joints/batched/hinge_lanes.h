// Revolute joints with spring, limits or motor as kernels see them: eight that share no moving body.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/joints/batched/pin_lanes.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct HingeBatch {
  PinBatch pin;                            // what holds the anchors together
  std::uint32_t needs_angle;               // 1: some lane has a spring or limits
  Lanes turn_c, turn_s;                    // of B relative to A and the reference, at the start of the tick
  Lanes is_sprung, is_driven, is_limited;  // 1 or 0
  Lanes loss, pull, give;                  // joint_spring.h
  Lanes motor_speed;                       // rad/s
  Lanes motor_impulse_max;                 // N m s
  Lanes lower, upper;                      // rad
  // N m s, accumulated in this substep.
  Lanes spring_impulse, motor_impulse, lower_impulse, upper_impulse;
  Lanes start_speed;  // of the angle before the substep, rad/s
};

/// Batches that follow each other, for one call of a kernel.
struct HingeWork {
  HingeBatch* batches;
  std::size_t batch_count;
  Real* bodies;
  Real h;  // s, of a substep
  Softness soft;
};

struct HingeKernels {
  void (*note)(const HingeWork& work);
  void (*warm_start)(const HingeWork& work);
  void (*solve)(const HingeWork& work);
  void (*relax)(const HingeWork& work);
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
