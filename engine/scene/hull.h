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

/// What a shape is without its radius, in the body's frame: the hull of a box or polygon, the two centres of a capsule,
/// the points of a segment or chain in their order; the centre of a circle. Requires: a valid shape.
std::vector<Point> core_of(const Shape& shape);

/// Mass, centre of mass and inertia about that centre.
struct MassProperties {
  double mass = 0;     // kg
  Point center;        // m, in the body's frame
  double inertia = 0;  // kg m^2
};

/// Of one shape at its density, exact. Segments and chains have none. Requires: a valid shape.
MassProperties shape_mass(const Shape& shape);

/// Of a body: its shapes together, or what it states itself. Zero mass and inertia for static and kinematic bodies,
/// zero inertia for fixed rotation; the centre is that of the shapes in any case, the body's origin where they have no
/// mass and none is stated.
MassProperties body_mass(const Body& body);

}  // namespace ticktrue::engine
