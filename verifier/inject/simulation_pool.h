// A pool of simulations of one setup. A simulation is reused by callers that load a state first.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <vector>

#include "base/state/simulation.h"

namespace ticktrue::verifier {

/// For one thread. Making a simulation of a thousand bodies costs five ticks; loading a state costs one.
class SimulationPool {
 public:
  explicit SimulationPool(const SimulationInfo& real);
  SimulationPool(const SimulationPool&) = delete;
  SimulationPool& operator=(const SimulationPool&) = delete;

  /// Makes simulations whose initial state is undefined until a state is loaded. The pool must outlive them.
  /// Requires of the caller: always the same setup; load before step.
  const SimulationInfo& info() const { return info_; }

 private:
  class PooledSimulation;
  const SimulationInfo& real_;
  SimulationInfo info_;
  std::vector<std::unique_ptr<Simulation>> idle_;
};

}  // namespace ticktrue::verifier
