// How frames of a host become ticks: fixed, semi-fixed and variable steps.
// SPDX-License-Identifier: MIT
// Source: Fiedler, "Fix Your Timestep!", 2004 (accumulator).
//
// A clock acts only while a session is recorded. The trace keeps the bits of each tick's dt. A replay therefore needs
// no clock, and it reproduces every bit for each kind of clock.
#pragma once

#include <cstdint>
#include <optional>

#include "engine/scene/scene.h"

namespace ticktrue::engine {

/// The use of the host's time.
struct ClockReport {
  std::uint64_t frame_count = 0;
  std::uint64_t tick_count = 0;
  double frame_time_s = 0;             // sum of the frames
  double tick_time_s = 0;              // sum of the ticks' dt
  double dropped_s = 0;                // semi_fixed: time beyond the largest number of ticks per frame
  double cut_s = 0;                    // variable, adaptive: time of frames beyond dt_max
  std::uint64_t inaccurate_count = 0;  // adaptive: ticks of dt_min whose error was still above the tolerance
  std::uint64_t trial_count = 0;       // adaptive: ticks that were tried
};

class TickClock {
 public:
  /// `dt` is the scene's, s. Requires: check_scene.
  TickClock(const ClockSettings& settings, double dt) : settings_(settings), dt_(dt) {}

  /// A frame of the host has passed. Requires: seconds > 0, finite; next_tick returned nothing.
  void add_frame(double seconds);

  /// The time of this frame that ticks have not used yet, s.
  double due_s() const { return due_s_; }

  /// Length of the next tick of this frame; nothing when the frame is done. For adaptive, `wanted_s` is the length that
  /// keeps the error at the tolerance. The last ticks of a frame have equal lengths, so that no tick is very short.
  std::optional<double> next_tick(double wanted_s = 0);

  ClockReport report;

 private:
  ClockSettings settings_;
  double dt_;
  double due_s_ = 0;
  int ticks_in_frame_ = 0;
};

}  // namespace ticktrue::engine
