// Contacts of hulls with a radius: capsules, rounded polygons, and segments, whose radius is 0.
// SPDX-License-Identifier: MIT
// Source: Ericson, "Real-Time Collision Detection", 2005, section 4.5.1 (sphere-swept volumes). The distance of two
// cores less their radii is exact while the cores are apart. Overlapping cores use separating axes.
#include "engine/narrow_phase/convex_hulls.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

Manifold collide_rounds(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a,
                        Real margin) {
  HullBuffer buffer;
  const Hull hull_a = hull_of(model, a);
  const Hull hull_b = hull_of(model, b, b_in_a, buffer);
  const Real distance_max = (a.radius + b.radius) + margin;
  const Overlap overlap = find_overlap(hull_a, hull_b, distance_max);
  if (!overlap.is_within_distance) return {};

  if (!overlap.found) {
    const ClosestPoints closest = closest_points(hull_a, hull_b);
    if (!(closest.distance_squared <= distance_max * distance_max)) return {};
    if (closest.distance_squared > 0) {
      const Vec2 normal = closest_normal(hull_a, hull_b, closest);
      const Manifold manifold = between_edges(hull_a, a.radius, hull_b, b.radius, normal, margin);
      return manifold.point_count > 0 ? manifold : between_points(closest, a.radius, b.radius, normal, margin);
    }
  }
  // A is preferred by a tenth of the slop, so that rounding does not switch the normal at equal overlaps.
  const Real preference = Real(0.1) * linear_slop(pair_size(a, b));
  const bool along_b = overlap.axis_b.separation > overlap.axis_a.separation + preference;
  const Vec2 normal = along_b ? -hull_b.normals[overlap.axis_b.edge] : hull_a.normals[overlap.axis_a.edge];
  return between_edges(hull_a, a.radius, hull_b, b.radius, normal, margin);
}

Manifold collide_round_circle(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a,
                              Real margin) {
  const Hull hull = hull_of(model, a);
  const Vec2 center = b_in_a.position + rotate(b_in_a.rotation, b.center);
  const Vec2 no_normals[1] = {};
  const Hull point{&center, no_normals, 1};
  const Axis axis = best_axis(hull, point);
  if (!(axis.separation - a.radius - b.radius <= margin)) return {};
  if (hull.count == 2 || axis.separation > 0) {
    const ClosestPoints closest = closest_points(hull, point);
    if (closest.distance_squared > 0)
      return between_points(closest, a.radius, b.radius, closest_normal(hull, point, closest), margin);
  }
  const Vec2 normal = hull.normals[axis.edge];
  const ClosestPoints inside{center - axis.separation * normal, center, 0, no_vertex, 0, axis.edge, 0};
  return between_points(inside, a.radius, b.radius, normal, margin);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
