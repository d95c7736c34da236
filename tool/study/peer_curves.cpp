// Error against run time beside Box2D, on four scenes whose ideal geometry is known.
// SPDX-License-Identifier: MIT
#include "tool/study/peer_curves.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <optional>

#include "tool/box2d/box2d_peer.h"
#include "tool/box2d3/box2d3_peer.h"
#include "tool/study/worlds.h"

namespace ticktrue::verifier {
namespace {

using engine::Precision;
using engine::Scene;

constexpr int tick_count = 600;
constexpr int sample_interval = 6;  // ticks

struct PeerScene {
  std::string name;
  std::string measure;
  bool is_chain = false;
  int first_tick = 450;  // samples count from this tick on
  Scene scene;
};

std::vector<PeerScene> peer_scenes() {
  Scene ratio = worlds::stack(Precision::f32, 10);
  ratio.bodies.back().mass = engine::ExplicitMass{100, {}, {}};
  return {
      {"stack_40", "40 boxes of 1 m: distance from their places, last quarter of 10 s", false, 450,
       worlds::stack(Precision::f32, 40)},
      {"stack_ratio_100", "10 boxes of 1 m, the top one of 100 kg: distance from their places, last quarter of 10 s",
       false, 450, ratio},
      {"hanging_chain", "20 links of 1 m and 1 kg, 100 kg at the end, hanging: gaps of joints, last quarter of 10 s",
       true, 450, worlds::chain(Precision::f32, 20, {0, -1}, 100)},
      {"swinging_chain", "10 links of 1 m and 1 kg let go level: gaps of joints, all of 10 s", true, 0,
       worlds::chain(Precision::f32, 10, {1, 0}, 1)}};
}

// The error of each box of a stack against the ideal stack, in which boxes touch. Upwards: the sum of the gaps below
// the box; the part of a gap within 0..skin does not count. Across: the distance from x = 0.
std::vector<double> stack_errors(const Bodies& bodies, double skin) {
  std::vector<double> errors;
  double up = 0, below = -0.5;
  for (const engine::BodyReport& body : bodies) {
    if (body.type != engine::BodyType::dynamic_body) continue;
    const double gap = body.center.y - below - 1;
    up += gap - std::clamp(gap, 0.0, skin);
    below = body.center.y;
    errors.push_back(std::hypot(body.center.x, up));
  }
  return errors;
}

struct PeerErrors {
  double squares = 0;
  std::size_t count = 0;
  double max = 0;
  void add(const std::vector<double>& errors) {
    for (const double error : errors) {
      const double e = std::isfinite(error) ? error : 1e9;
      squares += e * e;
      ++count;
      max = std::max(max, e);
    }
  }
};

// Returns the error of one run, and the time of its ticks in `time_ms`. `step` advances one tick and returns a Status.
// Errors: those of `step`.
template <typename Step, typename Report>
Result<PeerErrors> run_once(const PeerScene& scene, double skin, double& time_ms, Step step, Report report) {
  PeerErrors errors;
  double sum_s = 0;
  for (int tick = sample_interval; tick <= tick_count; tick += sample_interval) {
    const double start = computed_s();
    for (int i = 0; i < sample_interval; ++i)
      if (const Status did = step(); !did) return did.error();
    sum_s += computed_s() - start;
    if (tick <= scene.first_tick) continue;
    const Bodies bodies = report();
    errors.add(scene.is_chain ? joint_gaps(scene.scene, bodies) : stack_errors(bodies, skin));
  }
  time_ms = sum_s * 1e3 / tick_count;
  return errors;
}

struct PeerSetting {
  std::optional<PeerKind> peer;  // nothing: this engine
  int substeps = 0;              // of this engine and of Box2D 3
  int velocity_iterations = 0;
  int position_iterations = 0;
};

Result<PeerErrors> run_setting(const PeerScene& scene, const PeerSetting& setting, double& time_ms) {
  if (setting.peer == PeerKind::box2d3) {
    Box2d3Plan plan;
    plan.tick_count = tick_count;
    plan.body_interval = sample_interval;
    plan.warm_up = true;
    Box2d3Options options;
    options.substeps = setting.substeps;
    auto peer = make_box2d3_peer(scene.scene, options, plan);
    if (!peer) return peer.error();
    const auto step = [&] {
      (*peer)->step();
      return Status();
    };
    Result<PeerErrors> errors = run_once(scene, (*peer)->skin(), time_ms, step, [&] { return (*peer)->bodies(); });
    time_ms = (*peer)->ms_per_tick();  // the run itself: above it was only played back
    return errors;
  }
  if (setting.peer == PeerKind::box2d2) {
    Box2dOptions options;
    options.velocity_iterations = setting.velocity_iterations;
    options.position_iterations = setting.position_iterations;
    auto peer = make_box2d_peer(scene.scene, options);
    if (!peer) return peer.error();
    const auto step = [&] {
      (*peer)->step();
      return Status();
    };
    return run_once(scene, (*peer)->skin(), time_ms, step, [&] { return (*peer)->bodies(); });
  }
  Scene ours = scene.scene;
  ours.settings.substeps = setting.substeps;
  auto engine = engine::make_engine(ours);
  if (!engine) return engine.error();
  const TickInput input{ours.settings.dt, {}};
  return run_once(
      scene, 0, time_ms, [&] { return (*engine)->step(input, nullptr); }, [&] { return (*engine)->bodies(); });
}

std::string setting_name(const PeerSetting& setting) {
  return setting.peer == PeerKind::box2d2
             ? std::to_string(setting.velocity_iterations) + "/" + std::to_string(setting.position_iterations) + " it"
             : std::to_string(setting.substeps) + " sub";
}

std::vector<PeerSetting> peer_settings(const std::vector<PeerKind>& kinds) {
  // All sweeps have the same density of points.
  constexpr int substep_counts[]{1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128};
  std::vector<PeerSetting> all;
  for (const int substeps : substep_counts) all.push_back({{}, substeps, 0, 0});
  for (const PeerKind kind : kinds) {
    if (kind == PeerKind::box2d3) {
      for (const int substeps : substep_counts) all.push_back({kind, substeps, 0, 0});
      continue;
    }
    for (const int velocity : {4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256})
      all.push_back({kind, 0, velocity, (3 * velocity + 4) / 8});  // the ratio that Box2D recommends, 8 to 3
  }
  return all;
}

// Errors at equal substeps. Nothing is judged: the times of WebAssembly are not comparable with native ones.
void conclude_without_time(PeerCurves& curves) {
  curves.is_judged = false;
  const PeerPoint* theirs = best_within(curves.box2d, HUGE_VAL);
  const PeerPoint* ours = theirs ? find_setting(curves.ours, theirs->setting) : nullptr;
  curves.ratio = ours && theirs->error > 0 ? ours->error / theirs->error : HUGE_VAL;
  curves.conclusion = "Box2D 3 runs as WebAssembly: its times are not comparable with native ones. ";
  for (const PeerPoint* point : {theirs, find_setting(curves.box2d, "4 sub"), find_setting(curves.box2d, "8 sub"),
                                 find_setting(curves.box2d, "16 sub")}) {
    const PeerPoint* own = point ? find_setting(curves.ours, point->setting) : nullptr;
    if (!own) continue;
    char text[160];
    std::snprintf(text, sizeof text, "%s%s: Box2D 3 %.4g mm, ours %.4g mm", point == theirs ? "Best, " : "; ",
                  point->setting.c_str(), point->error * 1e3, own->error * 1e3);
    curves.conclusion += text;
  }
}

}  // namespace

const PeerPoint* best_within(const std::vector<PeerPoint>& points, double time_ms) {
  const PeerPoint* best = nullptr;
  for (const PeerPoint& point : points)
    if (point.time_ms.min <= time_ms && (!best || point.error < best->error)) best = &point;
  return best;
}

const PeerPoint* find_setting(const std::vector<PeerPoint>& points, const std::string& setting) {
  for (const PeerPoint& point : points)
    if (point.setting == setting) return &point;
  return nullptr;
}

void conclude(PeerCurves& curves) {
  if (curves.peer == PeerKind::box2d3) return conclude_without_time(curves);
  const PeerPoint* theirs = best_within(curves.box2d, HUGE_VAL);
  const PeerPoint* ours = theirs ? best_within(curves.ours, theirs->time_ms.min) : nullptr;
  curves.ratio = ours && theirs->error > 0 ? ours->error / theirs->error : HUGE_VAL;
  curves.holds = curves.ratio <= 0.5;
  if (!ours) {
    curves.conclusion = "no setting of ours is as quick as Box2D's best";
    return;
  }
  char text[256];
  std::snprintf(text, sizeof text,
                "Box2D's best, %s: %.4g mm at %.4f ms/tick. Ours at no more time, %s: %.4g mm at %.4f ms/tick: %.3g of "
                "its error (%s: at most 0.5)",
                theirs->setting.c_str(), theirs->error * 1e3, theirs->time_ms.min, ours->setting.c_str(),
                ours->error * 1e3, ours->time_ms.min, curves.ratio, curves.holds ? "pass" : "fail");
  curves.conclusion = text;
}

Result<std::vector<PeerCurves>> run_peer_curves(
    const std::vector<std::string>& names, const std::vector<PeerKind>& kinds, int repeat_max,
    const std::function<void(std::uint64_t done, std::uint64_t total)>& progress) {
  std::vector<PeerScene> scenes;
  for (PeerScene& scene : peer_scenes())
    if (names.empty() || std::find(names.begin(), names.end(), scene.name) != names.end())
      scenes.push_back(std::move(scene));
  if (scenes.size() < std::max<std::size_t>(1, names.size()))
    return Error{
        ErrorCode::usage,
        "accuracy --peer: found a scene it does not have, expected stack_40, stack_ratio_100, hanging_chain or "
        "swinging_chain",
        {}};
  for (const PeerKind kind : kinds)
    if (const Result<std::string> version = engine::info_of(peers, kind).version(); !version) return version.error();
  const std::vector<PeerSetting> all = peer_settings(kinds);
  const int repeat_count = std::max(1, repeat_max);
  std::uint64_t done = 0;
  const std::uint64_t total = scenes.size() * all.size() * static_cast<std::uint64_t>(repeat_count);
  std::vector<PeerCurves> out;
  for (const PeerScene& scene : scenes) {
    std::vector<std::vector<double>> times(all.size());
    std::vector<PeerErrors> errors(all.size());
    for (int repeat = 0; repeat < repeat_count; ++repeat)
      for (std::size_t i = 0; i < all.size(); ++i) {
        double time_ms = 0;
        const Result<PeerErrors> run = run_setting(scene, all[i], time_ms);
        if (!run) return run.error();
        errors[i] = *run;
        times[i].push_back(time_ms);
        if (progress) progress(++done, total);
      }
    std::vector<PeerPoint> points;  // by setting
    for (std::size_t i = 0; i < all.size(); ++i) {
      PeerPoint point;
      point.setting = setting_name(all[i]);
      point.error = std::sqrt(errors[i].squares / static_cast<double>(errors[i].count));
      point.error_max = errors[i].max;
      point.stands = errors[i].max < 0.5;
      point.time_ms = spread_of(std::move(times[i]));
      points.push_back(std::move(point));
    }
    for (const PeerKind kind : kinds) {
      PeerCurves curves;
      curves.name = scene.name;
      curves.peer = kind;
      curves.measure = scene.measure;
      for (std::size_t i = 0; i < all.size(); ++i) {
        if (!all[i].peer) curves.ours.push_back(points[i]);
        if (all[i].peer == kind) curves.box2d.push_back(points[i]);
      }
      conclude(curves);
      out.push_back(std::move(curves));
    }
  }
  return out;
}

}  // namespace ticktrue::verifier
