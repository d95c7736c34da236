// Distance of two convex shapes anywhere, for impacts found ahead of time.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Where a body is: its centre of mass and rotation.
struct Pose {
  Vec2 position;  // m
  Rotation rotation;
};

struct Distance {
  Real separation = 0;  // m; < 0: they overlap by at least this much
  Vec2 normal;          // from A to B, unit
  Vec2 point;           // between the two, world, m
};

/// Exact where the shapes are apart, up to rounding; where they overlap, along the axis of least overlap.
Distance distance(const Model& model, const ShapeModel& a, const Pose& pose_a, const ShapeModel& b, const Pose& pose_b);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
