// Revolute joints with a spring, limits or a motor, in the layout of the kernels: eight that share no dynamic body.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/joints/batched/revolute_lanes.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct DrivenRevoluteBatch {
  RevoluteBatch point;                              // the point constraint
  std::uint32_t needs_angle;                        // 1: some lane has a spring or limits
  Lanes rotation_c, rotation_s;                     // of B relative to A and the reference, at the start of the tick
  Lanes has_spring, has_motor, has_limits;          // 1 or 0
  Lanes velocity_gain, position_gain, change_gain;  // joint_spring.h
  Lanes motor_speed;                                // rad/s
  Lanes motor_impulse_max;                          // N m s
  Lanes lower, upper;                               // rad
  // N m s, accumulated in this substep.
  Lanes spring_impulse, motor_impulse, lower_impulse, upper_impulse;
  Lanes start_speed;  // of the angle before the substep, rad/s
  Lanes turning;      // JointWork::turning
};

/// Consecutive batches, for one call of a kernel.
struct DrivenRevoluteWork {
  DrivenRevoluteBatch* batches;
  std::size_t batch_count;
  Real* bodies;
  Real h;  // s, of a substep
  Softness soft;
};

struct DrivenRevoluteKernels {
  void (*save_velocities)(const DrivenRevoluteWork& work);
  void (*warm_start)(const DrivenRevoluteWork& work);
  void (*solve)(const DrivenRevoluteWork& work);
  void (*relax)(const DrivenRevoluteWork& work);
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
