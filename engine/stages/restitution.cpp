// Restitution: contacts that hit in this tick get their bounce, once, at its end.
// SPDX-License-Identifier: MIT
#include "engine/constraints/bodies.h"
#include "engine/pipeline.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void apply_restitution(const Model& model, State& state, Scratch& scratch, Real) {
  if (!bounce_contacts(scratch, model.restitution_threshold)) return;
  store_velocities(model, scratch, state);
  store_contacts(scratch, state, scratch.substep);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
