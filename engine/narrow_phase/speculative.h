// Contacts that come within the tick: found where the shapes will meet, before they do.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/narrow_phase/narrow_phase.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The manifold of two shapes that are still apart but will be near within dt, as far as velocities tell: normal and
/// points are those of that moment, anchors and separations those of the start of the tick. No points if they stay
/// apart. `gravity_displacement`: gravity_displacement_of_tick.
Manifold speculative_manifold(const Model& model, const ShapeModel& a, const ShapeModel& b, const BodyRow& body_a,
                              const BodyRow& body_b, Real gravity_displacement, Real dt);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
