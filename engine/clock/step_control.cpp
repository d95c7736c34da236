// Step doubling.
// SPDX-License-Identifier: MIT
#include "engine/clock/step_control.h"

#include <vector>

#include "base/limits.h"
#include "engine/math/trig.h"

namespace ticktrue::engine {
namespace {

constexpr double safety = 0.85;       // the target, as a share of the tolerance
constexpr double growth_max = 4;      // from one tick to the next
constexpr double shrink_max = 0.1;    // from one trial to the next
constexpr double steady_share = 0.7;  // an accepted tick with at least this share of the tolerance keeps its length
constexpr int trial_count_max = 40;   // 0.85^40 is far below dt_min / dt_max of every scene

double larger(double a, double b) {
  return a > b ? a : b;
}
double shorter(double a, double b) {
  return a < b ? a : b;
}

/// x^(1/n) for x > 0 by Newton's iteration in a form that falls towards the root from above.
double root(double x, int n) {
  double y = x > 1 ? x : 1;
  for (int i = 0; i < 200; ++i) {
    double power = 1;
    for (int k = 1; k < n; ++k) power *= y;
    const double next = ((n - 1) * y + x / power) / n;
    if (!(next < y)) break;
    y = next;
  }
  return y;
}

/// Largest difference of a position, m, or an angle, rad; not finite if a pose is not finite. A body that only one list
/// has counts as no difference.
double distance(const std::vector<BodyReport>& a, const std::vector<BodyReport>& b) {
  double worst = 0;
  std::size_t j = 0;
  for (const BodyReport& body : a) {
    while (j < b.size() && b[j].id < body.id) ++j;
    if (j == b.size() || b[j].id != body.id) continue;
    const double dx = body.center.x - b[j].center.x;
    const double dy = body.center.y - b[j].center.y;
    double turn = body.angle - b[j].angle;
    if (turn > pi) turn -= 2 * pi;
    if (turn < -pi) turn += 2 * pi;
    const double apart = __builtin_sqrt(dx * dx + dy * dy);
    const double turned = turn < 0 ? -turn : turn;
    if (!(apart - apart == 0) || !(turned - turned == 0)) return apart - apart + (turned - turned);  // a NaN
    worst = larger(worst, larger(apart, turned));
  }
  return worst;
}

/// Order of the error of a tick with respect to its length. With contacts every scheme has order 1.
int order_of(const Engine& engine) {
  const Scene& scene = engine.scene();
  return can_collide(scene) || scene.pointer ? 1 : info_of(integrators, scene.settings.integrator).order;
}

}  // namespace

StepControl::StepControl(const Engine& engine)
    : settings_(engine.scene().settings.clock), order_(order_of(engine)), next_s_(engine.scene().settings.dt) {}

/// The bodies after these ticks. The engine is then in the state of the image again, even if a tick failed.
Result<std::vector<BodyReport>> StepControl::try_ticks(Engine& engine, double dt, int tick_count) {
  Status did;
  for (int tick = 0; tick < tick_count && did; ++tick) did = engine.step({dt, {}}, nullptr);
  std::vector<BodyReport> bodies;
  if (did) bodies = engine.bodies();
  if (const Status loaded = engine.load(image_); !loaded) return loaded.error();
  if (!did) return did.error();
  return bodies;
}

Result<double> StepControl::error_of(Engine& engine, double dt) {
  const Result<std::vector<BodyReport>> whole = try_ticks(engine, dt, 1);
  if (!whole) return whole.error();
  const Result<std::vector<BodyReport>> halves = try_ticks(engine, 0.5 * dt, 2);
  if (!halves) return halves.error();
  return distance(*whole, *halves) / (1 - 1 / static_cast<double>(1 << order_));
}

Result<double> StepControl::choose(Engine& engine, double due_s, ClockReport& report) {
  // A state that is not finite has no error, and its image could not be loaded. The next tick reports the state.
  if (find_non_finite(engine.state())) return shorter(next_s_, due_s);
  image_.clear();
  encode_image(engine.state(), image_);
  const double floor_s = larger(settings_.dt_min, 2 * limits::dt_min_s);
  double dt = larger(floor_s, shorter(next_s_, settings_.dt_max));
  // A wanted length beyond the frame is kept for the next frame. A trial takes at most the time due.
  for (int trial = 0; trial < trial_count_max; ++trial) {
    const double tried = shorter(dt, due_s);
    const Result<double> error = error_of(engine, tried);
    if (!error) return error.error();
    ++report.trial_count;
    const bool accepted = *error <= settings_.tolerance;
    const double aim = safety * settings_.tolerance;
    // No error: the longest allowed length. Not finite: a much shorter length.
    double factor = *error > 0 ? root(aim / *error, order_ + 1) : growth_max;
    if (!(*error - *error == 0)) factor = shrink_max;
    if (accepted) {
      const bool steady = *error >= steady_share * settings_.tolerance;
      next_s_ = steady ? dt : shorter(tried * shorter(factor, growth_max), settings_.dt_max);
      // A first guess far too short would waste a tick of little error. Try a longer length once the error is known.
      if (!steady && trial == 0 && tried < due_s && next_s_ > 1.2 * tried) {
        dt = next_s_;
        continue;
      }
      return tried;
    }
    if (tried <= floor_s) {
      ++report.inaccurate_count;
      next_s_ = floor_s;
      return tried;
    }
    dt = larger(floor_s, tried * larger(shrink_max, shorter(factor, 0.95)));
  }
  ++report.inaccurate_count;
  return shorter(floor_s, due_s);
}

}  // namespace ticktrue::engine
