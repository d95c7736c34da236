// The drive of a degree of freedom of a joint in the direct solver: a spring, a motor of bounded force, two limits.
// SPDX-License-Identifier: MIT
// Source: derived here from the exact spring step (engine/joints/joint_spring.h).
//
// A row of the system is u + c p = w: u its speed, p its impulse. The spring's step is p = -m (loss v + pull x + give
// (o - v)), with o the speed without p and m = 1 / K. This step is a row of the system, since u = o + K p:
//   c = (1 - give) K / give,  w = v - (loss v + pull x) / give
// A motor is the row u = speed while its impulse is within its bounds, and a constant impulse beyond. A limit that
// would be exceeded is a row that meets the limit, while its impulse pushes.
#pragma once

#include <cstdint>

namespace ticktrue::engine {

enum class DriveState : std::uint8_t { free, motor, motor_at_most, motor_at_least, at_lower, at_upper };

/// The equation of a row in the system. Outside of the system, the impulse of a row is given.
struct RowLaw {
  bool is_in_system = false;
  double compliance = 0;
  double speed = 0;    // w
  double impulse = 0;  // outside
};

struct DirectDrive {
  double mobility = 0;  // K; 0: of the row alone
  bool has_spring = false;
  double loss = 0;  // of SpringStep, for the row's mobility and this substep
  double pull = 0;  // 1/s
  double give = 0;  // > 0, <= 1
  bool has_motor = false;
  double motor_speed = 0;  // m/s or rad/s
  double motor_impulse_max = 0;
  bool has_limits = false;
  double lower = 0;  // m or rad
  double upper = 0;
  DriveState state = DriveState::free;
  double start_speed = 0;  // v
  double start_error = 0;  // x
  RowLaw law;
};

inline bool is_at_limit(const DirectDrive& drive) {
  return drive.state == DriveState::at_lower || drive.state == DriveState::at_upper;
}
/// Rows that hold a speed or a position move the body by their whole impulse, as rigid rows do. Other rows act like
/// forces.
inline bool acts_like_force(const DirectDrive& drive) {
  return drive.state != DriveState::motor && !is_at_limit(drive);
}
inline bool exists(const DirectDrive& drive) {
  return drive.has_spring || drive.has_motor || drive.has_limits;
}

/// `mobility` > 0: K of the row alone. For limits the returned speed is 0: the caller knows the position.
RowLaw law_of(const DirectDrive& drive, double mobility);
/// The law in the pass after the move. Springs and bounded motors are outside of the system, with their present
/// impulse.
RowLaw law_after_move(const DirectDrive& drive, double impulse);

/// The motor's part of a row's impulse.
double motor_impulse(const DirectDrive& drive, double mobility, double impulse);

/// Sets the state for a row with this impulse and speed, over a substep of length h. True: the state has changed.
bool update_state(DirectDrive& drive, double mobility, double impulse, double speed, double h);

}  // namespace ticktrue::engine
