// The run time of automatic substeps against 64 fixed substeps, measured in turns on one thread.
// SPDX-License-Identifier: MIT
//
// Results are reported and never judged, because run times depend on the machine. Overlaps and joint gaps stand beside
// the run time, because a run is quick if it neglects both.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "engine/scene/scene.h"

namespace ticktrue::tool {

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
  std::uint64_t tick_count = 0;  // ticks of each of the two runs
  double automatic_s = 0;        // CPU time of all ticks
  double fixed_s = 0;            // CPU time of all ticks with 64 substeps
  double default_s = 0;          // CPU time of all ticks with 4 substeps
  double automatic_later_s = 0;  // CPU time after the first `run_time_settling` ticks
  double default_later_s = 0;    // likewise, with 4 substeps
  double worst_ratio = 0;        // the largest ratio in a window of `run_time_window` ticks
  int substeps_most = 0;
  std::uint64_t ticks_at_most = 0;  // ticks in which an island used the largest count that the scene allows
  std::uint64_t cut_ticks = 0;      // ticks in which the budget left a shock unsettled
  std::uint64_t limited_ticks = 0;  // ticks in which the budget took substeps from an island
  double overlap = 0;               // deepest overlap after any window, relative to the smallest shape
  double gap = 0;                   // largest joint gap after any window, m
  double ratio() const { return fixed_s > 0 ? automatic_s / fixed_s : 0; }
  double default_ratio() const { return default_s > 0 ? automatic_s / default_s : 0; }
  double default_later_ratio() const { return default_later_s > 0 ? automatic_later_s / default_later_s : 0; }
};

inline constexpr std::uint64_t run_time_window = 10;     // ticks of one run before the turn of the other
inline constexpr std::uint64_t run_time_settling = 120;  // ticks in which scenes at rest come to rest

struct RunTimeOptions {
  std::vector<std::string> names;  // names of scenes, or their beginnings; empty: all
  std::vector<engine::Precision> precisions{engine::Precision::f32};
  engine::SubstepLoads loads = engine::SubstepLoads::measured;
  int budget = engine::default_substep_budget;  // Settings::substep_budget
  std::uint64_t tick_count = 300;
  double seconds_max = 20;  // CPU time: a scene ends after the window that reaches this time
  std::function<void(std::uint64_t done, std::uint64_t total)> progress;  // counts ticks of all scenes
};
/// Errors: usage (no scene has this name); those of Simulation::step.
Result<std::vector<RunTimeRow>> run_times(const RunTimeOptions& options);

}  // namespace ticktrue::tool
