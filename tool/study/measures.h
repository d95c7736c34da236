// Measurements of a run: time of the steps, energy, momentum, overlaps, gaps of joints.
// SPDX-License-Identifier: MIT
//
// `energy` is kinetic energy and that of the scene's gravity. Energies of springs, motors and pointers are not counted.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "base/result.h"
#include "engine/engine.h"

namespace ticktrue::verifier {

using Bodies = std::vector<engine::BodyReport>;

/// Kinetic energy, J, of the moving bodies.
double kinetic_energy(const Bodies& bodies);
/// Kinetic energy and that of the scene's gravity, J.
double energy_of(const engine::Scene& scene, const Bodies& bodies);
engine::Point momentum_of(const Bodies& bodies);
/// Deepest overlap of two shapes, m; 0 if none.
double deepest_overlap(const std::vector<engine::ContactReport>& contacts);
/// How far each joint of the scene is from what it holds, m: anchors apart (revolute, weld), off the axis (prismatic,
/// wheel), off its length (a rod). Others, and those of bodies that are gone: 0.
std::vector<double> joint_gaps(const engine::Scene& scene, const Bodies& bodies);
double largest(const std::vector<double>& values);
/// The largest substep count of the state's table `substeps`; 0 without one.
int substeps_most(const engine::Engine& engine);
bool all_finite(const Bodies& bodies);
double speed_of(const engine::BodyReport& body);
/// Sum over the bodies that move.
double fastest(const Bodies& bodies);

/// CPU time of this thread, s. Other load on the machine is not included. Falls back to a steady clock on systems
/// without a CPU clock.
double computed_s();

/// A run that times the steps and nothing else.
class Run {
 public:
  /// Errors: those of make_engine.
  static Result<Run> make(const engine::Scene& scene, const engine::EngineOptions& options = {});

  /// Ticks of `dt` (the scene's, if 0). Errors: those of Simulation::step.
  Status advance(std::uint64_t tick_count, double dt = 0);

  /// One tick of an input of its own; returns its time, s. Requires: the engine accepts it. Errors: those of
  /// Simulation::step.
  Result<double> step(const TickInput& input);

  engine::Engine& engine() { return *engine_; }
  const engine::Engine& engine() const { return *engine_; }
  Bodies bodies() const { return engine_->bodies(); }
  double step_time_s() const { return step_time_s_; }  // of the steps so far

 private:
  std::unique_ptr<engine::Engine> engine_;
  double step_time_s_ = 0;
};

/// Least, median and interquartile range.
struct SampleSpread {
  double min = 0;
  double median = 0;
  double iqr = 0;
};
/// Requires: not empty.
SampleSpread spread_of(std::vector<double> samples);

}  // namespace ticktrue::verifier
