// How frames of a host become ticks: fixed, semi-fixed and variable steps.
// SPDX-License-Identifier: MIT
// Source: Fiedler, "Fix Your Timestep!", 2004 (accumulator).
//
// A clock acts where a session is recorded. The trace keeps the bits of each tick's dt, so a replay needs no clock, and
// every kind of it replays bit for bit.
#pragma once

#include <cstdint>
#include <optional>

#include "engine/scene/scene.h"

namespace ticktrue::engine {

/// What became of the host's time.
struct ClockReport {
  std::uint64_t frame_count = 0;
  std::uint64_t tick_count = 0;
  double frame_time_s = 0;             // sum of the frames
  double tick_time_s = 0;              // sum of the ticks' dt
  double dropped_s = 0;                // semi_fixed: beyond the cap of ticks per frame
  double cut_s = 0;                    // variable, adaptive: of frames longer than dt_max
  std::uint64_t inaccurate_count = 0;  // adaptive: ticks of dt_min whose error was above the tolerance all the same
  std::uint64_t trial_count = 0;       // adaptive: ticks tried and measured
};

class TickClock {
 public:
  /// `dt` is the scene's, s. Requires: check_scene.
  TickClock(const ClockSettings& settings, double dt) : settings_(settings), dt_(dt) {}

  /// A frame of the host has passed. Requires: seconds > 0, finite; next_tick gave nothing.
  void add_frame(double seconds);

  /// Time that ticks may still take in this frame, s.
  double due_s() const { return due_s_; }

  /// Length of the next tick of this frame; nothing when the frame is done. For adaptive, `wanted_s` is the length that
  /// keeps the error; the last ticks of a frame are made equal so that none is a sliver.
  std::optional<double> next_tick(double wanted_s = 0);

  ClockReport report;

 private:
  ClockSettings settings_;
  double dt_;
  double due_s_ = 0;
  int ticks_in_frame_ = 0;
};

}  // namespace ticktrue::engine
