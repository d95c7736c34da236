// The table of solvers.
// SPDX-License-Identifier: MIT
#include "engine/solvers/solver.h"

#include <utility>

#include "engine/model/poison.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

using SolveFunction = void (*)(const Model& model, State& state, TickLists& tick, SolverWork& work, Real dt);

class Solver final : public Stage {
 public:
  Solver(SolveFunction solve, std::shared_ptr<SolverWork> work) : solve_(solve), work_(std::move(work)) {}
  void run(const Model& model, State& state, TickLists& tick, Real dt) override {
    solve_(model, state, tick, *work_, dt);
  }
  void list_caches(std::vector<TickCache*>& caches) override { list_fields(*work_, ListCaches{caches}); }
  void poison() override { list_fields(*work_, Poison{}); }

 private:
  SolveFunction solve_;
  std::shared_ptr<SolverWork> work_;
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
static_assert(rows_are_in_order(functions));

}  // namespace

std::unique_ptr<Stage> make_solver(SolverKind kind, std::shared_ptr<SolverWork> work) {
  return std::make_unique<Solver>(info_of(functions, kind).solve, std::move(work));
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
