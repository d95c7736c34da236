// The length of the next tick that keeps its error at a tolerance, found by step doubling.
// SPDX-License-Identifier: MIT
// Source: Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I", 1993, section II.4.
//
// The simulation's state is saved, run for one tick of dt and, from the same state, for two of dt / 2, and loaded back.
// The difference d of the poses tells the error of the long tick: e = d / (1 - 2^-p) for a scheme of order p. Lengths
// are tried until e is below the tolerance; the tick itself is then the caller's to run. The tick's inputs are left
// out of the trials.
#pragma once

#include <vector>

#include "engine/clock/tick_clock.h"
#include "engine/engine.h"

namespace ticktrue::engine {

class StepControl {
 public:
  explicit StepControl(const Engine& engine);

  /// A length of at most `due_s` whose error is at most the tolerance, or dt_min. Leaves the engine as it was.
  /// Errors: those of Simulation::step, of a tick that was tried, and of Simulation::load.
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
