// What automatic substeps cost beside 64 fixed ones, measured in turns on one thread.
// SPDX-License-Identifier: MIT
//
// Reported, never judged: run times are the machine's. How far shapes overlap and joints gape stands beside the time,
// since a run that gives both up is quick.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "engine/scene/scene.h"

namespace ticktrue::verifier {

struct RunTimeScene {
  std::string_view name;
  std::string_view what;
  Result<engine::Scene> (*make)();
};
const std::vector<RunTimeScene>& run_time_scenes();

struct RunTimeRow {
  std::string scene;
  std::string what;
  engine::Precision precision = engine::Precision::f32;
  std::uint64_t tick_count = 0;  // done by each
  double automatic_s = 0;        // CPU time of all ticks
  double fixed_s = 0;            // the same with 64 substeps
  double worst_ratio = 0;        // of a window of `run_time_window` ticks
  int substeps_most = 0;
  std::uint64_t ticks_at_most = 0;  // in which an island had as many substeps as the scene allows
  double overlap = 0;               // deepest after any window, of the smallest size in the scene
  double gap = 0;                   // widest after any window, m
  double ratio() const { return fixed_s > 0 ? automatic_s / fixed_s : 0; }
};

inline constexpr std::uint64_t run_time_window = 10;  // ticks of one before the other's turn

struct RunTimeOptions {
  std::vector<std::string> names;  // of scenes, or how they begin; empty: all
  std::vector<engine::Precision> precisions{engine::Precision::f32};
  std::uint64_t tick_count = 300;
  double seconds_max = 20;  // of CPU time: a scene that has taken as long ends with the window
  std::function<void(std::uint64_t done, std::uint64_t total)> progress;  // ticks of all scenes
};
/// Errors: usage (no scene has that name); those of Simulation::step.
Result<std::vector<RunTimeRow>> run_times(const RunTimeOptions& options);

}  // namespace ticktrue::verifier
