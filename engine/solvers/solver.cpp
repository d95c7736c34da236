// The table of solvers.
// SPDX-License-Identifier: MIT
#include "engine/solvers/solver.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

struct SolverEntry {
  SolverKind kind;
  StageFunction solve;
};
constexpr std::array<SolverEntry, solvers.size()> functions{{
    {SolverKind::free_flight, solve_free_flight},
    {SolverKind::impulse, solve_impulse},
    {SolverKind::tgs_soft, solve_tgs_soft},
    {SolverKind::pgs, solve_pgs},
}};

}  // namespace

StageFunction solver_function(SolverKind kind) {
  return info_of(functions, kind).solve;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
