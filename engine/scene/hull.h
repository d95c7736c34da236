// Convex hulls: built from points in any order, validated, with exact mass properties.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "engine/scene/scene.h"

namespace ticktrue::engine {

/// Orders the points counter-clockwise, starting at the lowest (then leftmost) one.
/// Errors: invalid_scene, without place: fewer than 3 or more than 16 points, duplicates (closer than 1e-4 of the
/// extent), a point inside the hull of the others or on one of its edges (concave or collinear), no area.
Result<std::vector<Point>> build_hull(const std::vector<Point>& points);

/// The core of a shape, without its radius, in the body's frame: the hull of a box or polygon, the two centres of a
/// capsule, the points of a segment or chain in their order, the centre of a circle. Requires: a valid shape.
std::vector<Point> core_of(const Shape& shape);

/// Mass, centre of mass and inertia about the centre of mass.
struct MassProperties {
  double mass = 0;     // kg
  Point center;        // m, in the body's frame
  double inertia = 0;  // kg m^2
};

/// The exact mass properties of one shape at its density. Segments and chains have no mass. Requires: a valid shape.
MassProperties shape_mass(const Shape& shape);

/// The mass properties of a body: those of its shapes together, or those that the body states. Static and kinematic
/// bodies have zero mass and inertia; fixed rotation gives zero inertia. The centre is always that of the shapes. If
/// the shapes have no mass and the body states none, the centre is the body's origin.
MassProperties body_mass(const Body& body);

}  // namespace ticktrue::engine
