// The distance of two convex shapes, for impacts.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/narrow_phase/narrow_phase.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Distance {
  Real separation = 0;  // m; < 0: they overlap, along `normal` by that much
  Vec2 normal;          // from A to B, unit
  Vec2 point;           // between the two, world, m
};

/// Exact where the shapes are apart, up to rounding. Poses are those of the bodies' centres of mass.
Distance distance(const Model& model, const ShapeModel& shape_a, const Placement& pose_a, const ShapeModel& shape_b,
                  const Placement& pose_b);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
