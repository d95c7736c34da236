// The length of the next tick that keeps its error at a tolerance, found by step doubling.
// SPDX-License-Identifier: MIT
// Source: Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I", 1993, section II.4.
//
// A trial saves the simulation's state and runs one tick of dt. From the same state it then runs two ticks of dt / 2,
// and loads the state back. The difference d of the poses gives the error of the long tick: e = d / (1 - 2^-p) for a
// scheme of order p. Lengths are tried until e is below the tolerance; the caller then runs the tick itself. Trials
// leave out the tick's inputs.
#pragma once

#include <vector>

#include "engine/clock/tick_clock.h"
#include "engine/engine.h"

namespace ticktrue::engine {

class StepControl {
 public:
  explicit StepControl(const Engine& engine);

  /// A length of at most `due_s` whose error is at most the tolerance, or dt_min. Leaves the engine as it was.
  /// Errors: those of Simulation::step for a trial tick, and of Simulation::load.
  Result<double> choose(Engine& engine, double due_s, ClockReport& report);

 private:
  Result<double> error_of(Engine& engine, double dt);
  Result<std::vector<BodyReport>> try_ticks(Engine& engine, double dt, int tick_count);

  ClockSettings settings_;
  int order_;
  double next_s_;  // the length to try first
  Bytes image_;
};

}  // namespace ticktrue::engine
