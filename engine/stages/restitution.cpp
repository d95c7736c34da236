// Restitution: contacts that hit in this tick get their bounce, once, at its end.
// SPDX-License-Identifier: MIT
#include "engine/model/bodies.h"
#include "engine/pipeline.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void apply_restitution(const Model& model, State& state, Scratch& scratch, Real) {
  bool any = false;
  for (const SolveGroup& group : scratch.groups) {
    if (!bounce_contacts(scratch, group, model.restitution_threshold)) continue;
    store_contacts(scratch, group, state);
    any = true;
  }
  if (any) store_velocities(scratch, state);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
