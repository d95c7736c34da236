// Lengths that shapes are compared with: slop, resting margin, speculative margin.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model/model.h"
#include "engine/model/state.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Lengths below which geometry does not matter, relative to the shape: a stack of 1 cm boxes and one of 100 m boxes
/// behave alike.
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
/// The speculative margin: shapes closer than this get contact points before they touch. It includes the gravity
/// displacement, so that shapes small against that do not overlap deeply before their first contact. At most eight
/// sizes, so that no shape has contacts with the whole world.
inline Real speculative_margin(Real size, Real gravity_displacement) {
  return larger(resting_margin(size), smaller(gravity_displacement, 8 * size));
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
