// The steps of the model: think, point, press, hold or drag, release.
// SPDX-License-Identifier: MIT
// Source: Flash and Hogan, "The coordination of arm movements", 1985 (minimum-jerk path of a hand); Fitts, "The
// information capacity of the human motor system", 1954 (longer distances take longer).
#include "tool/import/mouse_model.h"

#include "base/limits.h"
#include "base/random.h"
#include "engine/json/number_text.h"
#include "tool/import/import_mouse.h"

namespace ticktrue::tool {
namespace {

using engine::Bounds;
using engine::Input;
using engine::InputKind;
using engine::Point;

constexpr double seconds_max = 100'000;  // more than a day
constexpr std::uint64_t drag_one_in = 6;
constexpr double think_min_s = 0.25, think_max_s = 1.35;
constexpr double hold_min_s = 0.06, hold_max_s = 0.16;
constexpr double report_interval_s = 0.016;
constexpr double drag_min_s = 0.4, drag_per_window_s = 1.2;  // s; the second is for a distance of the whole window
// Presses fall into this part of the window, away from its edge. Drags begin low in the window, where the bodies are.
constexpr double edge = 0.08, lying_height = 0.3;

/// Progress (0..1) of a hand at the share t of the time: slow, fast, slow.
double minimum_jerk(double t) {
  return t * t * t * (10 + t * (-15 + 6 * t));
}

class Person {
 public:
  Person(const Bounds& window, double dt, std::uint64_t seed) : window_(window), dt_(dt), random_(seed) {}

  std::vector<Input> session(double seconds) {
    const auto last_tick = static_cast<std::uint64_t>(seconds / dt_);
    double time_s = random_.real(think_min_s, think_max_s);
    while (tick_of(time_s) < last_tick) {
      const bool drags = random_.below(drag_one_in) == 0;
      const double x = random_.real(edge, 1 - edge);
      const double y = random_.real(edge, drags ? lying_height : 1 - edge);
      const Point from{x, y};
      add(InputKind::press, time_s, from);
      time_s += random_.real(hold_min_s, hold_max_s);
      if (drags) time_s = drag(from, time_s, last_tick);
      add(InputKind::release, time_s, {});
      time_s += random_.real(think_min_s, think_max_s);
    }
    // Inputs after the end are dropped.
    while (!inputs_.empty() && inputs_.back().tick >= last_tick) inputs_.pop_back();
    Input end;
    end.tick = last_tick;
    end.kind = InputKind::end;
    inputs_.push_back(end);
    return std::move(inputs_);
  }

 private:
  std::uint64_t tick_of(double time_s) const { return static_cast<std::uint64_t>(time_s / dt_); }

  /// Adds drags along the path, at the report rate of a mouse. Returns the time at the end.
  double drag(const Point& from, double start_s, std::uint64_t last_tick) {
    const double x = random_.real(edge, 1 - edge);
    const double y = random_.real(lying_height, 1 - edge);
    const Point way{x - from.x, y - from.y};
    const double duration_s = drag_min_s + drag_per_window_s * __builtin_sqrt(way.x * way.x + way.y * way.y);
    const int report_count = static_cast<int>(duration_s / report_interval_s) + 1;
    for (int i = 1; i <= report_count; ++i) {
      const double part = static_cast<double>(i) / report_count;
      const double time_s = start_s + part * duration_s;
      if (tick_of(time_s) >= last_tick) break;
      const double progress = minimum_jerk(part);
      const Point to{from.x + progress * way.x, from.y + progress * way.y};
      // A tick keeps only its last drag, because later drags override earlier ones.
      if (inputs_.back().kind == InputKind::drag && inputs_.back().tick == tick_of(time_s))
        place(inputs_.back(), to);
      else
        add(InputKind::drag, time_s, to);
    }
    return start_s + duration_s + random_.real(hold_min_s, hold_max_s);
  }

  /// `part`: share of the width and height of the window, from its lower left corner.
  void place(Input& input, const Point& part) const {
    input.values[0] = window_.lower.x + part.x * (window_.upper.x - window_.lower.x);
    input.values[1] = window_.lower.y + part.y * (window_.upper.y - window_.lower.y);
  }

  void add(InputKind kind, double time_s, const Point& part) {
    Input input;
    input.tick = tick_of(time_s);
    input.kind = kind;
    if (!inputs_.empty() && inputs_.back().tick == input.tick) input.sequence = inputs_.back().sequence + 1;
    if (kind != InputKind::release) place(input, part);
    inputs_.push_back(input);
  }

  Bounds window_;
  double dt_;
  Random random_;
  std::vector<Input> inputs_;
};

}  // namespace

Result<std::vector<Input>> model_mouse_session(const engine::Scene& scene, std::uint64_t seed, double seconds) {
  const Result<Bounds> window = pointer_window(scene);
  if (!window) return window.error();
  if (!(seconds >= 0 && seconds <= seconds_max))
    return Error{ErrorCode::usage,
                 "seconds: out of range: found " + engine::number_text(seconds) + ", expected 0.." +
                     engine::number_text(seconds_max),
                 ""};
  if (seconds / scene.settings.dt >= static_cast<double>(limits::tick_count_max))
    return Error{ErrorCode::limit,
                 "seconds: too many ticks of " + engine::number_text(scene.settings.dt) + " s: expected at most " +
                     std::to_string(limits::tick_count_max),
                 ""};
  return Person(*window, scene.settings.dt, seed).session(seconds);
}

}  // namespace ticktrue::tool
