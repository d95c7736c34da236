// The table of solvers.
// SPDX-License-Identifier: MIT
#include "engine/solvers/solver.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

using SolveFunction = void (*)(const Model& model, State& state, Scratch& scratch, Real dt);

class Solver final : public Stage {
 public:
  explicit Solver(SolveFunction solve) : solve_(solve) {}
  void run(const Model& model, State& state, TickLists& tick, Real dt) override {
    solve_(model, state, static_cast<Scratch&>(tick), dt);
  }

 private:
  SolveFunction solve_;
};

struct SolverEntry {
  SolverKind kind;
  SolveFunction solve;
};
constexpr std::array<SolverEntry, solvers.size()> functions{{
    {SolverKind::free_flight, solve_free_flight},
    {SolverKind::impulse, solve_impulse},
    {SolverKind::tgs_soft, solve_tgs_soft},
    {SolverKind::pgs, solve_pgs},
}};

}  // namespace

std::unique_ptr<Stage> make_solver(SolverKind kind) {
  return std::make_unique<Solver>(info_of(functions, kind).solve);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
