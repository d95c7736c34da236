// Speculative contacts: contacts that will begin within the tick.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/narrow_phase/narrow_phase.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The manifold of two separated shapes that will be close within dt according to their velocities. Normal and points
/// are those at that time; anchors and separations are those at the start of the tick. No points if the shapes stay
/// apart. `gravity_displacement`: gravity_displacement_of_tick.
Manifold speculative_manifold(const Model& model, const ShapeModel& a, const ShapeModel& b, const BodyRow& body_a,
                              const BodyRow& body_b, Real gravity_displacement, Real dt);

/// Adds the second point of two shapes that touch or will be close at one point, if the second point may close within
/// dt. A body that lands on one corner turns about it, and its next corner would overlap deeply before its first
/// contact. `manifold`: of these poses.
void add_later_point(const Model& model, const ShapeModel& a, const ShapeModel& b, const BodyRow& body_a,
                     const BodyRow& body_b, Real gravity_displacement, Real dt, Manifold& manifold);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
