// Removes bodies that have left the bounds of the scene.
// SPDX-License-Identifier: MIT
#include "engine/stages/stages.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void cull(const Model& model, State& state, TickLists& tick, Real) {
  if (!model.has_bounds) return;
  for (std::size_t row = state.bodies.size(); row-- > 0;) {
    const BodyRow& body = state.bodies[row];
    if (model.bodies[body.source].type == BodyType::static_body) continue;
    const bool inside = body.position.x >= model.bounds.lower.x && body.position.x <= model.bounds.upper.x &&
                        body.position.y >= model.bounds.lower.y && body.position.y <= model.bounds.upper.y;
    if (!inside) remove_body(model, state, tick, row);
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
