// Error against run time beside Box2D, on scenes whose ideal geometry is known.
// SPDX-License-Identifier: MIT
#include "tool/study/peer_curves.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>

#include "engine/json/json_tree.h"
#include "tool/box2d/box2d_peer.h"
#include "tool/box2d3/box2d3_peer.h"
#include "tool/box2d3/engine_program.h"
#include "tool/study/worlds.h"

namespace ticktrue::tool {
namespace {

using engine::Point;
using engine::Precision;
using engine::Scene;

constexpr int sample_interval = 6;  // ticks

struct PeerScene {
  std::string name;
  std::string measure;
  bool is_chain = false;
  int first_tick = 0;  // samples count from this tick on
  int tick_count = 0;
  Scene scene;
};

std::vector<PeerScene> peer_scenes() {
  Scene ratio = worlds::stack(Precision::f32, 10);
  ratio.bodies.back().mass = engine::ExplicitMass{100, {}, {}};
  const Point down{0, -1}, across{1, 0};
  return {
      {"stack_40", "40 boxes of 1 m: distance from their places, last quarter of 10 s", false, 450, 600,
       worlds::stack(Precision::f32, 40)},
      {"stack_ratio_100", "10 boxes of 1 m, the top one of 100 kg: distance from their places, last quarter of 10 s",
       false, 450, 600, ratio},
      {"hanging_chain", "20 links of 1 m and 1 kg, 100 kg at the end, hanging: gaps of joints, last quarter of 10 s",
       true, 450, 600, worlds::chain(Precision::f32, 20, down, 100)},
      {"heavy_chain", "100 links of 1 m and 1 kg, 100 kg at the end, hanging: gaps of joints, last quarter of 10 s",
       true, 450, 600, worlds::chain(Precision::f32, 100, down, 100)},
      {"swinging_chain", "10 links of 1 m and 1 kg let go level: gaps of joints, all of 10 s", true, 0, 600,
       worlds::chain(Precision::f32, 10, across, 1)},
      {"swinging_chain_50", "50 links of 1 m and 1 kg let go level: gaps of joints, all of 2 s", true, 0, 120,
       worlds::chain(Precision::f32, 50, across, 1)}};
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
  for (int tick = sample_interval; tick <= scene.tick_count; tick += sample_interval) {
    const double start = computed_s();
    for (int i = 0; i < sample_interval; ++i)
      if (const Status did = step(); !did) return did.error();
    sum_s += computed_s() - start;
    if (tick <= scene.first_tick) continue;
    const Bodies bodies = report();
    errors.add(scene.is_chain ? joint_gaps(scene.scene, bodies) : stack_errors(bodies, skin));
  }
  time_ms = sum_s * 1e3 / scene.tick_count;
  return errors;
}

struct PeerSetting {
  std::optional<PeerKind> peer;  // nothing: this engine
  int substeps = 0;              // of this engine and of Box2D 3
  int velocity_iterations = 0;
  int position_iterations = 0;
  bool joins_direct = false;  // of this engine
};

// The error of a run that is finished and played back.
Result<PeerErrors> play_run(const PeerScene& scene, Result<std::unique_ptr<Box2d3Peer>> run, double& time_ms) {
  if (!run) return run.error();
  const auto step = [&] {
    (*run)->step();
    return Status();
  };
  Result<PeerErrors> errors = run_once(scene, (*run)->skin(), time_ms, step, [&] { return (*run)->bodies(); });
  time_ms = (*run)->ms_per_tick();  // of the run itself: above it was only played back
  return errors;
}

Result<PeerErrors> run_setting(const PeerScene& scene, const PeerSetting& setting, const std::string& engine_program,
                               double& time_ms) {
  Box2d3Plan plan;
  plan.tick_count = static_cast<std::uint64_t>(scene.tick_count);
  plan.body_interval = sample_interval;
  plan.warm_up = true;
  if (setting.peer == PeerKind::box2d3) {
    Box2d3Options options;
    options.substeps = setting.substeps;
    return play_run(scene, make_box2d3_peer(scene.scene, options, plan), time_ms);
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
  if (setting.joins_direct) ours.settings.joints = engine::JointSolverKind::direct;
  if (!engine_program.empty())
    return play_run(scene, make_engine_program_peer(engine_program, ours, {}, plan), time_ms);
  auto engine = engine::make_engine(ours);
  if (!engine) return engine.error();
  const TickInput input{ours.settings.dt, {}};
  return run_once(
      scene, 0, time_ms, [&] { return (*engine)->step(input, nullptr); }, [&] { return (*engine)->bodies(); });
}

std::string setting_name(const PeerSetting& setting) {
  return setting.peer == PeerKind::box2d2
             ? std::to_string(setting.velocity_iterations) + "/" + std::to_string(setting.position_iterations) + " it"
             : std::to_string(setting.substeps) + (setting.joins_direct ? " sub direct" : " sub");
}

std::vector<PeerSetting> peer_settings(const std::vector<PeerKind>& kinds, bool has_joints) {
  // All sweeps have the same density of points.
  constexpr int substep_counts[]{1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128};
  std::vector<PeerSetting> all;
  for (const int substeps : substep_counts) all.push_back({{}, substeps, 0, 0});
  if (has_joints)
    for (const int substeps : {1, 2, 3, 4, 6, 8, 12, 16}) all.push_back({{}, substeps, 0, 0, true});
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

// Errors: usage.
Status check_engine_program(const PeerCurvesOptions& options) {
  const std::string& program = options.engine_program;
  if (program.empty()) return {};
  std::error_code failed;
  if (!std::filesystem::exists(program, failed))
    return Error{ErrorCode::usage, "--engine: found no file " + engine::in_quotes(program) + ", expected an engine_run",
                 "./dev setup wasm && ./dev build wasm engine_run makes build/wasm/engine_run.js"};
  if (runs_in_node(program))
    for (const PeerKind kind : options.kinds)
      if (kind != PeerKind::box2d3)
        return Error{ErrorCode::usage, "--engine: WebAssembly is compared with box2d3 alone: found --peer box2d2",
                     "leave out --engine, or give --peer box2d3"};
  return {};
}

/// The least error of ours in no more time than a point of Box2D took, over its error.
double ratio_of(const PeerCurves& curves, const PeerPoint* theirs) {
  const PeerPoint* ours = theirs ? best_within(curves.ours, theirs->time_ms.min) : nullptr;
  return ours && theirs->error > 0 ? ours->error / theirs->error : HUGE_VAL;
}

constexpr double best_ratio_max = 0.5;

// Bars at common settings.
struct SettingBar {
  PeerKind peer;
  const char* setting;
  double ratio_max;
};
constexpr SettingBar setting_bars[]{
    {PeerKind::box2d2, "8/3 it", 0.1}, {PeerKind::box2d2, "16/6 it", 0.1}, {PeerKind::box2d2, "32/12 it", 0.1},
    {PeerKind::box2d3, "4 sub", 0.5},  {PeerKind::box2d3, "8 sub", 0.5},   {PeerKind::box2d3, "16 sub", 0.5},
};

std::string bar_text(const PeerBar& bar) {
  const char* verdict = bar.ratio <= bar.ratio_max ? "pass" : "fail";
  const std::string found =
      std::isfinite(bar.ratio) ? fmt::format("{:.3g} of its error", bar.ratio) : "none of ours is as quick";
  return fmt::format(". At {} {} ({}: at most {})", bar.setting, found, verdict, bar.ratio_max);
}

// Errors at equal substeps. Nothing is judged: times of WebAssembly are not comparable with native ones.
void conclude_without_time(PeerCurves& curves) {
  const PeerPoint* theirs = best_within(curves.box2d, HUGE_VAL);
  const PeerPoint* ours = theirs ? find_setting(curves.ours, theirs->setting) : nullptr;
  curves.ratio = ours && theirs->error > 0 ? ours->error / theirs->error : HUGE_VAL;
  curves.conclusion = "One of the two runs as WebAssembly: their times are not comparable. ";
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
  if (!curves.is_judged) return conclude_without_time(curves);
  const PeerPoint* theirs = best_within(curves.box2d, HUGE_VAL);
  const PeerPoint* ours = theirs ? best_within(curves.ours, theirs->time_ms.min) : nullptr;
  curves.ratio = ratio_of(curves, theirs);
  curves.holds = curves.ratio <= best_ratio_max;
  curves.conclusion = "no setting of ours is as quick as Box2D's best";
  if (ours)
    curves.conclusion =
        fmt::format(
            "Box2D's best, {}: {:.4g} mm at {:.4f} ms/tick. Ours at no more time, {}: {:.4g} mm at {:.4f} ms/tick",
            theirs->setting, theirs->error * 1e3, theirs->time_ms.min, ours->setting, ours->error * 1e3,
            ours->time_ms.min) +
        fmt::format(": {:.3g} of its error ({}: at most {})", curves.ratio, curves.holds ? "pass" : "fail",
                    best_ratio_max);
  curves.bars.clear();
  for (const SettingBar& bar : setting_bars) {
    const PeerPoint* point = bar.peer == curves.peer ? find_setting(curves.box2d, bar.setting) : nullptr;
    if (!point) continue;
    curves.bars.push_back({bar.setting, ratio_of(curves, point), bar.ratio_max});
    curves.holds = curves.holds && curves.bars.back().ratio <= bar.ratio_max;
    curves.conclusion += bar_text(curves.bars.back());
  }
}

Result<std::vector<PeerCurves>> run_peer_curves(const PeerCurvesOptions& options) {
  const std::vector<std::string>& names = options.names;
  const std::vector<PeerKind>& kinds = options.kinds;
  std::vector<PeerScene> scenes;
  for (PeerScene& scene : peer_scenes())
    if (names.empty() || std::find(names.begin(), names.end(), scene.name) != names.end())
      scenes.push_back(std::move(scene));
  if (scenes.size() < std::max<std::size_t>(1, names.size())) {
    std::string known;
    for (const std::string_view name : peer_scene_names) known += (known.empty() ? "" : ", ") + std::string(name);
    return Error{ErrorCode::usage, "accuracy --peer: found a scene it does not have, expected some of " + known, {}};
  }
  if (const Status usable = check_engine_program(options); !usable) return usable.error();
  for (const PeerKind kind : kinds)
    if (const Result<std::string> version = engine::info_of(peers, kind).version(); !version) return version.error();
  const int repeat_count = std::max(1, options.repeat_max);
  std::uint64_t done = 0;
  std::uint64_t total = 0;
  for (const PeerScene& scene : scenes)
    total += peer_settings(kinds, scene.is_chain).size() * static_cast<std::uint64_t>(repeat_count);
  std::vector<PeerCurves> out;
  for (const PeerScene& scene : scenes) {
    const std::vector<PeerSetting> all = peer_settings(kinds, scene.is_chain);
    std::vector<std::vector<double>> times(all.size());
    std::vector<PeerErrors> errors(all.size());
    for (int repeat = 0; repeat < repeat_count; ++repeat)
      for (std::size_t i = 0; i < all.size(); ++i) {
        double time_ms = 0;
        const Result<PeerErrors> run = run_setting(scene, all[i], options.engine_program, time_ms);
        if (!run) return run.error();
        errors[i] = *run;
        times[i].push_back(time_ms);
        if (options.progress) options.progress(++done, total);
      }
    std::vector<PeerPoint> points;  // by setting
    for (std::size_t i = 0; i < all.size(); ++i) {
      PeerPoint point;
      point.setting = setting_name(all[i]);
      point.joins_direct = all[i].joins_direct;
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
      curves.own_label = runs_in_node(options.engine_program) ? "tgs_soft, wasm" : "tgs_soft";
      const bool is_wasm = kind == PeerKind::box2d3 && box2d3_runs_in_node();
      curves.peer_label = is_wasm ? "Box2D 3, wasm" : kind == PeerKind::box2d3 ? "Box2D 3" : "Box2D";
      curves.is_judged = is_wasm == runs_in_node(options.engine_program);
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

}  // namespace ticktrue::tool
