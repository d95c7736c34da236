// The stage after the solver that applies restitution.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <utility>

#include "engine/model/stage.h"
#include "engine/solvers/solver_work.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

class Restitution final : public Stage {
 public:
  /// `work`: of the solver, with the contacts that it has solved.
  explicit Restitution(std::shared_ptr<SolverWork> work) : work_(std::move(work)) {}
  void run(const Model& model, State& state, TickLists& tick, Real dt) override;

 private:
  std::shared_ptr<SolverWork> work_;
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
