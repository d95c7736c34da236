// Restitution: applied once, at the end of the tick, to contacts that hit in it.
// SPDX-License-Identifier: MIT
#include "engine/solvers/restitution.h"

#include "engine/model/bodies.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void Restitution::run(const Model& model, State& state, TickLists& tick, Real) {
  auto& scratch = static_cast<Scratch&>(tick);
  bool any = false;
  for (const SolverSet& set : scratch.solver_sets) {
    if (!bounce_contacts(scratch, set, model.restitution_threshold)) continue;
    store_contacts(scratch, set, state);
    any = true;
  }
  if (any) store_velocities(scratch, state);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
