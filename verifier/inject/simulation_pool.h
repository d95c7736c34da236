// A pool of simulations of one setup. A simulation is reused by callers that load a state first.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <vector>

#include "base/state/simulation.h"

namespace ticktrue::verifier {

/// For one thread. Making a simulation of a thousand bodies takes as long as five ticks; loading a state, as long as
/// one.
class SimulationPool {
 public:
  explicit SimulationPool(const SimulationInfo& real);
  SimulationPool(const SimulationPool&) = delete;
  SimulationPool& operator=(const SimulationPool&) = delete;

  /// The simulation that lends from this pool. The pool must outlive the simulations that it makes. Their initial state
  /// is undefined.
  /// Requires: all calls of make have the same setup; a state is loaded before step.
  const SimulationInfo& info() const { return info_; }

 private:
  class PooledSimulation;
  const SimulationInfo& real_;
  SimulationInfo info_;
  std::vector<std::unique_ptr<Simulation>> idle_;
};

}  // namespace ticktrue::verifier
