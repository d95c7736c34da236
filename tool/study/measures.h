// Measurements of a run: time of the steps, energy, momentum, overlaps, joint gaps.
// SPDX-License-Identifier: MIT
//
// `energy` is kinetic energy plus potential energy of the scene's gravity. Energies of springs, motors and mouse joints
// are not counted.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "base/result.h"
#include "engine/engine.h"
#include "tool/drawing/joint_geometry.h"

namespace ticktrue::tool {

using Bodies = std::vector<engine::BodyReport>;

/// Kinetic energy of the bodies, J.
double kinetic_energy(const Bodies& bodies);
/// Kinetic energy plus potential energy of the scene's gravity, J.
double energy_of(const engine::Scene& scene, const Bodies& bodies);
engine::Point momentum_of(const Bodies& bodies);
/// Deepest overlap of two shapes, m; 0 if none.
double deepest_overlap(const std::vector<engine::ContactReport>& contacts);
double largest(const std::vector<double>& values);
/// The largest substep count of the state's table `substeps`; 0 without one.
int substeps_most(const engine::Engine& engine);
bool all_finite(const Bodies& bodies);
double speed_of(const engine::BodyReport& body);
/// The largest speed of a dynamic body, m/s; 0 without one.
double fastest(const Bodies& bodies);

/// CPU time of this thread, s, which excludes other load on the machine. A system without a CPU clock gives the time of
/// a steady clock.
double computed_s();

/// A run that times the steps and nothing else.
class Run {
 public:
  /// Errors: those of make_engine.
  static Result<Run> make(const engine::Scene& scene, const engine::EngineOptions& options = {});

  /// Advances ticks of `dt` (0: the scene's dt). Errors: those of Simulation::step.
  Status advance(std::uint64_t tick_count, double dt = 0);

  /// Advances one tick with its own input and returns the run time of that tick, s. Requires: the engine accepts the
  /// input. Errors: those of Simulation::step.
  Result<double> step(const TickInput& input);

  engine::Engine& engine() { return *engine_; }
  const engine::Engine& engine() const { return *engine_; }
  Bodies bodies() const { return engine_->bodies(); }
  double step_time_s() const { return step_time_s_; }  // of the steps so far

 private:
  std::unique_ptr<engine::Engine> engine_;
  double step_time_s_ = 0;
};

/// Minimum, median and interquartile range.
struct SampleSpread {
  double min = 0;
  double median = 0;
  double iqr = 0;
};
/// Requires: `samples` is not empty.
SampleSpread spread_of(std::vector<double> samples);

}  // namespace ticktrue::tool
