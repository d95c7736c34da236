// The experiments of the thesis, repeated: time by shapes and integrators, broad phase on and off, clocks.
// SPDX-License-Identifier: MIT
// Source: Claes, "Building a custom 2D physics engine in C++", 2024, sections 3.1 and 3.2 (scene, mixes, its numbers).
//
// A time is the processor time of the thread in step() alone: the mean over the ticks of a run, the least of three
// runs. Hashes are of the last state and equal on every machine.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/hash.h"
#include "base/state/state_view.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/engine.h"
#include "tool/session/clocked_inputs.h"
#include "tool/study/measures.h"
#include "tool/study/table.h"

namespace ticktrue {
namespace {

using engine::IntegratorKind;
using engine::SolverKind;
using tool::TextTable;

constexpr int repeat_count = 3;
constexpr int fixed_count = 5;  // disc, block, floor and two walls come first
constexpr double px_per_m = 25;

// ---- Results of the thesis ----

enum class Mix : std::uint8_t { circles, circles_and_polygons, polygons, all };
constexpr std::array<std::string_view, 4> mix_names{"circles", "circles, polygons", "polygons", "all shapes"};

struct ThesisScheme {
  std::string_view name;  // in the thesis
  IntegratorKind kind;    // the scheme that it is
  double ms[3];           // of an update with 150 bodies: circles, circles and polygons, polygons
};
constexpr std::array<ThesisScheme, 3> schemes{{{"Euler", IntegratorKind::semi_implicit_euler, {0.1747, 0.3891, 0.5640}},
                                               {"Verlet", IntegratorKind::thesis_verlet, {0.1823, 0.3757, 0.5944}},
                                               {"RK4", IntegratorKind::thesis_rk4, {0.1861, 0.3925, 0.5914}}}};

struct ThesisPhase {
  int count;
  double on_ms, off_ms;
};
constexpr std::array<ThesisPhase, 4> phases{
    {{60, 0.1508, 0.5689}, {80, 0.2067, 0.9755}, {100, 0.2811, 1.5037}, {200, 0.6266, 5.5908}}};

struct ThesisClock {
  double seconds;
  double fixed_px, variable_px;  // largest distance of a body between two runs
};
constexpr std::array<ThesisClock, 3> clocks{{{5, 0, 143.2}, {10, 0, 108.9}, {15, 0, 246.0}}};

// ---- Scenes ----

Result<engine::Scene> mixed(int count, Mix mix) {
  auto scene = engine::make_builtin_scene("thesis_mix?bodies=" + std::to_string(std::max(count, 3)));
  if (!scene || mix == Mix::all) return scene;
  // A circle, a box and a polygon, in turn.
  const engine::Body circle = scene->bodies[fixed_count], polygon = scene->bodies[fixed_count + 2];
  for (std::size_t i = fixed_count; i < scene->bodies.size(); ++i) {
    engine::Body& body = scene->bodies[i];
    const bool is_circle = mix == Mix::circles || (mix == Mix::circles_and_polygons && i % 2 == 0);
    body.shapes = (is_circle ? circle : polygon).shapes;
  }
  return scene;
}

void use_thesis_solver(engine::Scene& scene) {
  scene.settings.solver = SolverKind::impulse;
  scene.settings.substeps = 1;
  scene.settings.restitution_threshold = 0;
}

struct Timing {
  double ms = 0;  // a tick
  std::size_t contact_count = 0;
  std::uint64_t hash = 0;
};

Result<Timing> time_of(const engine::Scene& scene, int warm_up, int tick_count) {
  Timing timing;
  for (int repeat = 0; repeat < repeat_count; ++repeat) {
    auto made = engine::make_engine(scene);
    if (!made) return made.error();
    engine::Engine& engine = **made;
    const TickInput input{scene.settings.dt, {}};
    for (int i = 0; i < warm_up; ++i)
      if (const Status did = engine.step(input, nullptr); !did) return did.error();
    const double start = tool::computed_s();
    for (int i = 0; i < tick_count; ++i)
      if (const Status did = engine.step(input, nullptr); !did) return did.error();
    const double ms = (tool::computed_s() - start) * 1e3 / tick_count;
    timing.ms = repeat == 0 ? ms : std::min(timing.ms, ms);
    if (repeat + 1 == repeat_count) timing.contact_count = engine.contacts().size();
    timing.hash = root_hash(engine.state());
    if (ms * (warm_up + tick_count) > 1000) break;  // long enough
  }
  return timing;
}

std::string ms_text(double ms) {
  return fmt::format("{:.4g}", ms);
}
std::string hash_text(const Result<Timing>& timing) {
  return timing ? hex64(timing->hash).substr(0, 8) : "-";
}

// ---- 3.1: shapes and integrators ----

Status performance() {
  TextTable table(
      {"bodies", "shapes", "integrator", "thesis ms", "impulse ms", "tgs_soft ms", "touching", "impulse", "tgs_soft"},
      3);
  for (const int count : {150, 1000, 10000}) {
    const int warm_up = count < 10000 ? 180 : 60;
    const int tick_count = count < 10000 ? 120 : 10;
    for (std::size_t mix = 0; mix < mix_names.size(); ++mix)
      for (const ThesisScheme& scheme : schemes) {
        auto scene = mixed(count, static_cast<Mix>(mix));
        if (!scene) return scene.error();
        scene->settings.integrator = scheme.kind;
        const auto ours = time_of(*scene, warm_up, tick_count);
        if (!ours) return ours.error();
        use_thesis_solver(*scene);
        // The thesis' loop over all pairs takes as long in the air as in a heap. With 10,000 bodies it takes very long.
        const auto theirs = count < 10000 ? time_of(*scene, warm_up, tick_count) : time_of(*scene, 2, 3);
        if (!theirs) return theirs.error();
        table.add({std::to_string(count), std::string(mix_names[mix]), std::string(scheme.name),
                   count == 150 && mix < 3 ? ms_text(scheme.ms[mix]) : "no data", ms_text(theirs->ms),
                   ms_text(ours->ms), std::to_string(ours->contact_count), hash_text(theirs), hash_text(ours)});
        std::fprintf(stderr, "%d %s %s\n", count, std::string(mix_names[mix]).c_str(),
                     std::string(scheme.name).c_str());
      }
  }
  std::fputs(table.text().c_str(), stdout);
  return {};
}

// ---- 3.1: broad phase on and off ----

Status broad_phase() {
  std::vector<std::string> head{"polygons", "thesis off", "thesis on"};
  for (const auto& info : engine::broad_phases) head.emplace_back(info.name);
  head.emplace_back("impulse");
  TextTable table(std::move(head), 0);
  bool all_same = true;
  for (const int count : {60, 80, 100, 200, 1000, 10000}) {
    const auto known =
        std::find_if(phases.begin(), phases.end(), [&](const auto& phase) { return phase.count == count; });
    std::vector<std::string> row{std::to_string(count), known != phases.end() ? ms_text(known->off_ms) : "no data",
                                 known != phases.end() ? ms_text(known->on_ms) : "no data"};
    auto scene = mixed(count, Mix::polygons);
    if (!scene) return scene.error();
    const int warm_up = count < 10000 ? 180 : 2;
    const int tick_count = count < 10000 ? 120 : 5;
    std::optional<std::uint64_t> hash;
    for (const auto& info : engine::broad_phases) {
      scene->settings.broad_phase = info.kind;
      const auto timing = time_of(*scene, warm_up, tick_count);
      if (!timing) return timing.error();
      all_same = all_same && (!hash || *hash == timing->hash);
      hash = timing->hash;
      row.push_back(ms_text(timing->ms));
    }
    use_thesis_solver(*scene);
    const auto theirs = time_of(*scene, warm_up, tick_count);
    if (!theirs) return theirs.error();
    row.push_back(ms_text(theirs->ms));
    table.add(std::move(row));
    std::fprintf(stderr, "%d\n", count);
  }
  std::fputs(table.text().c_str(), stdout);
  std::fputs(all_same ? "  the five broad phases gave the same bits in every row\n" : "  broad phases differ in bits\n",
             stdout);
  return {};
}

// ---- 3.2: clocks ----

struct Run {
  std::vector<engine::BodyReport> bodies;
  std::uint64_t hash = 0;
  std::vector<double> dts;  // s, of the ticks
};

// `dts`: the dts of an earlier run, in place of a clock.
Result<Run> run_for(const engine::Scene& scene, double seconds, std::uint64_t seed, const std::vector<double>* dts) {
  auto made = engine::make_engine(scene);
  if (!made) return made.error();
  engine::Engine& engine = **made;
  Run run;
  if (dts != nullptr) {
    for (const double dt : *dts)
      if (const Status did = engine.step(TickInput{dt, {}}, nullptr); !did) return did.error();
  } else {
    auto frames = tool::open_host("jitter_60", seed);
    if (!frames) return frames.error();
    tool::ClockedInputs inputs(engine, std::make_unique<replay::NoInputs>(scene.settings.dt), std::move(*frames));
    for (std::uint64_t tick = 0; engine.time_s() < seconds; ++tick) {
      const auto input = inputs.next(tick);
      if (!input) return input.error();
      if (!*input) break;
      run.dts.push_back((*input)->dt);
      if (const Status did = engine.step(**input, nullptr); !did) return did.error();
    }
  }
  run.bodies = engine.bodies();
  run.hash = root_hash(engine.state());
  return run;
}

double farthest_px(const Run& a, const Run& b) {
  double most = 0;
  for (std::size_t i = 0; i < std::min(a.bodies.size(), b.bodies.size()); ++i)
    most = std::max(
        most, std::hypot(a.bodies[i].center.x - b.bodies[i].center.x, a.bodies[i].center.y - b.bodies[i].center.y) *
                  px_per_m);
  return most;
}

Status determinism() {
  TextTable table({"clock", "seconds", "thesis px", "impulse px", "tgs_soft px", "replayed"}, 1);
  for (const auto& clock : engine::clock_kinds)
    for (const ThesisClock& known : clocks) {
      std::vector<std::string> row{std::string(clock.name), fmt::format("{:g}", known.seconds)};
      row.push_back(clock.kind == engine::ClockKind::fixed      ? ms_text(known.fixed_px)
                    : clock.kind == engine::ClockKind::variable ? ms_text(known.variable_px)
                                                                : "no data");
      bool replayed = true;
      for (const bool is_thesis : {true, false}) {
        auto scene = mixed(6, Mix::all);
        if (!scene) return scene.error();
        if (is_thesis) use_thesis_solver(*scene);
        scene->settings.clock.kind = clock.kind;
        const auto first = run_for(*scene, known.seconds, 1, nullptr);
        if (!first) return first.error();
        const auto second = run_for(*scene, known.seconds, 2, nullptr);
        if (!second) return second.error();
        const auto replay = run_for(*scene, known.seconds, 0, &first->dts);
        if (!replay) return replay.error();
        replayed = replayed && replay->hash == first->hash;
        // Each run ends with the first frame that reaches its time.
        row.push_back(ms_text(farthest_px(*first, *second)));
      }
      row.emplace_back(replayed ? "every bit" : "other bits");
      table.add(std::move(row));
    }
  std::fputs(table.text().c_str(), stdout);
  return {};
}

int run(int argc, char** argv) {
  CLI::App app("The experiments of the thesis again, its numbers beside ours");
  app.require_subcommand(1);
  app.add_subcommand("performance", "Time of a tick by shapes and integrators, 150 to 10,000 bodies");
  app.add_subcommand("broad_phase", "Time of a tick by broad phase, 60 to 10,000 polygons");
  app.add_subcommand("determinism", "How far two runs part by clock, and whether a recorded one comes again");
  CLI11_PARSE(app, argc, argv);
  const Status status = app.got_subcommand("performance")   ? performance()
                        : app.got_subcommand("broad_phase") ? broad_phase()
                                                            : determinism();
  if (status) return 0;
  std::fprintf(stderr, "bench_thesis: error: %s\n", status.error().message.c_str());
  return 2;
}

}  // namespace
}  // namespace ticktrue

int main(int argc, char** argv) {
  return ticktrue::run(argc, argv);
}
