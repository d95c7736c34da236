// Shock propagation: a body that hits a pile at rest is stopped by the whole pile within one substep.
// SPDX-License-Identifier: MIT
//
// One pass per substep propagates an impact through a few contacts only. Meanwhile the boxes of a tower move with a
// share of its speed. In a substep with an impact, rigid passes therefore solve the contacts of the island until
// velocities converge. Only with automatic substeps.
#pragma once

#include "engine/contacts/contact_batch.h"
#include "engine/impacts/impulse_rows.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct ShockWorkspace {
  std::vector<Twist> velocities;  // [body] before the last passes
  ImpulseStep step;
};

template <typename Visit>
void list_fields(ShockWorkspace& of, const Visit& visit) {
  auto& [velocities, step] = of;
  visit(velocities, step);
}

/// Saves the closing speeds of resting impacts, and the impulses of all contacts. Call before contacts are warm
/// started. `impacts`: TickLists::resting_impacts.
void begin_resting_impacts(const SolvedSet& solved, std::vector<RestingImpact>& impacts, ContactBatches& contacts);
/// The change of speed, m/s, below which the shock has propagated; 0 if no resting impact hit in the last pass.
/// Requires: the set has resting impacts.
Real settled_speed_of_impacts(const SolvedSet& solved);
inline Real settled_speed(const SolvedSet& solved) {
  return solved.set.has_resting_impacts ? settled_speed_of_impacts(solved) : Real(0);
}
/// Rigid passes until no velocity of a body changes by more than `settled`; no pass for 0. Ends early if
/// `tick.shock_work_left` does not suffice.
void propagate_shock(const SolvedSet& solved, Real settled, TickLists& tick, ContactBatches& contacts,
                     ShockWorkspace& work);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
