// The laws and states of driven rows.
// SPDX-License-Identifier: MIT
// Source: as direct_drive.h.
#include "engine/joints/direct/direct_drive.h"

namespace ticktrue::engine {
namespace {

/// Smaller differences of speeds and positions count as none: rounding would make states change back and forth.
constexpr double tolerance = 1e-9;

RowLaw spring_law(const DirectDrive& drive, double mobility) {
  if (!drive.has_spring) return {};
  return {true, (1 - drive.give) * mobility / drive.give,
          drive.start_speed - (drive.loss * drive.start_speed + drive.pull * drive.start_error) / drive.give, 0};
}

/// The law of a spring with a constant additional impulse.
RowLaw pushed_law(const DirectDrive& drive, double mobility, double impulse) {
  RowLaw law = spring_law(drive, mobility);
  law.speed += law.compliance * impulse;
  if (!law.is_in_system) law.impulse = impulse;
  return law;
}

DriveState unlimited_state(const DirectDrive& drive) {
  return drive.has_motor ? DriveState::motor : DriveState::free;
}

/// The motor's share of a row's impulse at the motor's speed.
double motor_share(const DirectDrive& drive, double mobility, double impulse) {
  const RowLaw spring = spring_law(drive, mobility);
  if (!spring.is_in_system || spring.compliance <= 0) return impulse;
  return impulse - (spring.speed - drive.motor_speed) / spring.compliance;
}

DriveState next_state(const DirectDrive& drive, double mobility, double impulse, double speed) {
  switch (drive.state) {
    case DriveState::free:
      return unlimited_state(drive);
    case DriveState::motor: {
      const double motor = motor_share(drive, mobility, impulse);
      if (motor > drive.motor_impulse_max) return DriveState::motor_at_most;
      return motor < -drive.motor_impulse_max ? DriveState::motor_at_least : DriveState::motor;
    }
    case DriveState::motor_at_most:
      return speed > drive.motor_speed + tolerance ? DriveState::motor : DriveState::motor_at_most;
    case DriveState::motor_at_least:
      return speed < drive.motor_speed - tolerance ? DriveState::motor : DriveState::motor_at_least;
    case DriveState::at_lower:
      return impulse < 0 ? unlimited_state(drive) : DriveState::at_lower;
    case DriveState::at_upper:
      return impulse > 0 ? unlimited_state(drive) : DriveState::at_upper;
  }
  return drive.state;
}

}  // namespace

RowLaw law_of(const DirectDrive& drive, double mobility) {
  switch (drive.state) {
    case DriveState::free:
      return spring_law(drive, mobility);
    case DriveState::motor:
      return {true, 0, drive.motor_speed, 0};
    case DriveState::motor_at_most:
      return pushed_law(drive, mobility, drive.motor_impulse_max);
    case DriveState::motor_at_least:
      return pushed_law(drive, mobility, -drive.motor_impulse_max);
    case DriveState::at_lower:
    case DriveState::at_upper:
      return {true, 0, 0, 0};
  }
  return {};
}

RowLaw law_after_move(const DirectDrive& drive, double impulse) {
  if (drive.state == DriveState::motor) return {true, 0, drive.motor_speed, 0};
  if (is_at_limit(drive)) return {true, 0, 0, 0};
  return {false, 0, 0, impulse};
}

double motor_impulse(const DirectDrive& drive, double mobility, double impulse) {
  if (drive.state == DriveState::motor) return motor_share(drive, mobility, impulse);
  if (drive.state == DriveState::motor_at_most) return drive.motor_impulse_max;
  return drive.state == DriveState::motor_at_least ? -drive.motor_impulse_max : 0;
}

bool update_state(DirectDrive& drive, double mobility, double impulse, double speed, double h) {
  const DriveState before = drive.state;
  drive.state = next_state(drive, mobility, impulse, speed);
  if (drive.has_limits && !is_at_limit(drive)) {
    const double then = drive.start_error + h * speed;
    if (then < drive.lower - tolerance) drive.state = DriveState::at_lower;
    if (then > drive.upper + tolerance) drive.state = DriveState::at_upper;
  }
  return drive.state != before;
}

}  // namespace ticktrue::engine
