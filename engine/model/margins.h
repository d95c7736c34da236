// Tolerances for shapes: slop, resting margin, speculative margin.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model/model.h"
#include "engine/model/state.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The length below which geometry does not matter, relative to the shape. A stack of 1 cm boxes and a stack of 100 m
/// boxes behave alike.
inline Real linear_slop(Real size) {
  return Real(0.005) * size;
}
/// The displacement by gravity in a tick, m.
inline Real gravity_displacement_of_tick(const Model& model, const State& state) {
  const Real dt = static_cast<Real>(model.scene.settings.dt);
  return length(state.world.gravity) * dt * dt;
}
/// Upper bound of the overlap and gap of a resting pair.
inline Real resting_margin(Real size) {
  return 4 * linear_slop(size);
}
/// The speculative margin: shapes closer than this get contact points before they touch. The margin includes the
/// gravity displacement, so that small shapes do not overlap deeply before their first contact. It is at most eight
/// sizes, so that no shape has contacts with the whole world.
inline Real speculative_margin(Real size, Real gravity_displacement) {
  return larger(resting_margin(size), smaller(gravity_displacement, 8 * size));
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
