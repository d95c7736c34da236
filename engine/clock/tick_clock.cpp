// How frames of a host become ticks.
// SPDX-License-Identifier: MIT
#include "engine/clock/tick_clock.h"

#include "base/limits.h"

namespace ticktrue::engine {
namespace {

double smaller(double a, double b) {
  return a < b ? a : b;
}

}  // namespace

void TickClock::add_frame(double seconds) {
  ++report.frame_count;
  report.frame_time_s += seconds;
  ticks_in_frame_ = 0;
  const bool cuts = settings_.kind == ClockKind::variable || settings_.kind == ClockKind::adaptive;
  if (cuts && seconds > settings_.dt_max) {
    report.cut_s += seconds - settings_.dt_max;
    seconds = settings_.dt_max;
  }
  due_s_ += seconds;
}

std::optional<double> TickClock::next_tick(double wanted_s) {
  double dt = dt_;
  switch (settings_.kind) {
    case ClockKind::fixed:
      if (due_s_ < dt_) return std::nullopt;
      due_s_ -= dt_;
      break;
    case ClockKind::semi_fixed:
      if (due_s_ < dt_) return std::nullopt;
      if (ticks_in_frame_ >= settings_.ticks_per_frame_max) {
        // Whole ticks are subtracted and the remainder stays, so that the phase of the host's time is kept.
        while (due_s_ >= dt_) {
          due_s_ -= dt_;
          report.dropped_s += dt_;
        }
        return std::nullopt;
      }
      due_s_ -= dt_;
      break;
    case ClockKind::variable:
      if (due_s_ < limits::dt_min_s) return std::nullopt;
      dt = smaller(due_s_, limits::dt_max_s);
      due_s_ = 0;
      break;
    case ClockKind::adaptive: {
      if (due_s_ < limits::dt_min_s) return std::nullopt;
      // 1 + 1e-9: rounding must not leave a remainder after n equal parts, which would give one more tick.
      double parts = 1;
      while (parts * wanted_s * (1 + 1e-9) < due_s_ && parts < 3) ++parts;
      dt = parts < 3 ? due_s_ / parts : wanted_s;
      due_s_ = parts == 1 ? 0 : due_s_ - dt;
      break;
    }
  }
  ++ticks_in_frame_;
  ++report.tick_count;
  report.tick_time_s += dt;
  return dt;
}

}  // namespace ticktrue::engine
