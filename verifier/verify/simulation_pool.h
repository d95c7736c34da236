// Simulations of one setup, made once and lent out again and again to those who load a state first.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <vector>

#include "base/state/simulation.h"

namespace ticktrue::verifier {

/// For one thread. Making a simulation of a thousand bodies takes as long as five of its ticks, loading a state one.
class SimulationPool {
 public:
  explicit SimulationPool(const SimulationInfo& real);
  SimulationPool(const SimulationPool&) = delete;
  SimulationPool& operator=(const SimulationPool&) = delete;

  /// Simulations like the real ones, but that their state is whatever it was until a state is loaded. The pool must
  /// outlive them. Requires of who gets one: always the same setup; load before step.
  const SimulationInfo& info() const { return info_; }

 private:
  class Loan;
  const SimulationInfo& real_;
  SimulationInfo info_;
  std::vector<std::unique_ptr<Simulation>> idle_;
};

}  // namespace ticktrue::verifier
