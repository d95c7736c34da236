// Restitution: applied once, at the end of the tick, to contacts that hit in the tick.
// SPDX-License-Identifier: MIT
#include "engine/solvers/restitution.h"

#include "engine/islands/solver_sets.h"
#include "engine/model/bodies.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void Restitution::run(const Model& model, State& state, TickLists& tick, Real) {
  ContactBatches& batches = work_->contacts.batches;
  bool any = false;
  for (std::uint32_t i = 0; i < tick.solver_sets.size(); ++i) {
    const SolvedSet solved = solver_set(model, state, tick, work_->bodies, i);
    const Real threshold = model.restitution_threshold;
    const bool arms_bounced =
        bounce_jointed_contacts(solved, threshold, work_->direct, batches, work_->jointed_impacts);
    if (!bounce_contacts(solved, batches, threshold) && !arms_bounced) continue;
    project_direct_again(solved, work_->direct);
    store_contacts(solved, batches, state);
    any = true;
  }
  if (any) store_velocities(work_->bodies, tick, state);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
