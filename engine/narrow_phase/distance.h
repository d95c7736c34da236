// The distance of two convex shapes, for impacts.
// SPDX-License-Identifier: MIT
#pragma once

#include <limits>

#include "engine/narrow_phase/narrow_phase.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

inline constexpr Real no_distance_is_enough = std::numeric_limits<Real>::infinity();

struct Distance {
  Real separation = 0;  // m; < 0: overlap along `normal`
  Vec2 normal;          // from A to B, unit
  Vec2 point;           // between the two shapes, world, m
};

/// Exact up to rounding where the shapes are apart. Poses are those of the bodies' centres of mass. Of shapes that an
/// axis separates by more than `enough`, m, the result is that axis and that separation, which is at most the distance.
Distance distance(const Model& model, const ShapeModel& shape_a, const Placement& pose_a, const ShapeModel& shape_b,
                  const Placement& pose_b, Real enough = no_distance_is_enough);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
