// The bounds of a tick.
// SPDX-License-Identifier: MIT
#include "engine/model/motion_bounds.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

MotionBounds motion_bounds_of_tick(const Model& model, const State& state, Real dt) {
  const Settings& settings = model.scene.settings;
  MotionBounds bounds{
      dt, length(state.world.gravity), settings.locate_impacts, settings.auto_substeps.has_value(), settings.continuous,
      0};
  if (!settings.locate_impacts) return bounds;
  for (const BodyRow& body : state.bodies)
    bounds.farthest = larger(bounds.farthest, motion_bound_in(bounds, model.bodies[body.source], body));
  return bounds;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
