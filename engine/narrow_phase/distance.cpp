// The closest features of separated shapes, or the axis of least overlap.
// SPDX-License-Identifier: MIT
#include "engine/narrow_phase/distance.h"

#include "engine/narrow_phase/convex_hulls.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// The core of a shape in the world: a circle is a hull of one vertex.
Hull core_of(const Model& model, const ShapeModel& shape, const Placement& pose, HullBuffer& buffer) {
  if (shape.family != ShapeFamily::circle) return hull_of(model, shape, pose, buffer);
  buffer.vertices[0] = pose.position + rotate(pose.rotation, shape.center);
  return {buffer.vertices, buffer.normals, 1};
}

/// The vertex that lies farthest along `direction`.
Vec2 farthest_vertex(const Hull& hull, Vec2 direction) {
  Vec2 farthest = hull.vertices[0];
  for (std::uint32_t i = 1; i < hull.count; ++i)
    if (dot(direction, hull.vertices[i]) > dot(direction, farthest)) farthest = hull.vertices[i];
  return farthest;
}

}  // namespace

Distance distance(const Model& model, const ShapeModel& shape_a, const Placement& pose_a, const ShapeModel& shape_b,
                  const Placement& pose_b, Real enough) {
  HullBuffer buffer_a, buffer_b;
  // Coordinates relative to A's position: differences of small numbers are more exact.
  const Hull a = core_of(model, shape_a, {{0, 0}, pose_a.rotation}, buffer_a);
  const Hull b = core_of(model, shape_b, {pose_b.position - pose_a.position, pose_b.rotation}, buffer_b);
  Distance best;
  bool has_axis = false;
  bool axis_is_of_a = false;
  bool is_separated = false;
  if (a.count > 1) {
    const Axis axis = best_axis(a, b);
    best.separation = axis.separation;
    best.normal = a.normals[axis.edge];
    has_axis = axis_is_of_a = true;
  }
  if (b.count > 1) {
    const Axis axis = best_axis(b, a);
    if (!has_axis || axis.separation > best.separation) {
      best.separation = axis.separation;
      best.normal = -b.normals[axis.edge];
      axis_is_of_a = false;
    }
    has_axis = true;
  }
  const Real radii = shape_a.radius + shape_b.radius;
  if (has_axis && best.separation - radii > enough) {
    best.separation = best.separation - radii;
    return best;
  }
  const ClosestPoints closest = closest_points(a, b);
  if (!has_axis || best.separation > 0) {
    const Real gap = square_root(closest.distance_squared);
    // Two corners too close for a direction: the normal of an edge is used.
    const Real blur = 64 * epsilon * (shape_a.bounding_radius + shape_b.bounding_radius);
    const bool corners = closest.vertex_a != no_vertex && closest.vertex_b != no_vertex;
    const Vec2 normal = gap > 0 ? closest_normal(a, b, closest) : Vec2{0, 0};
    // Within rounding of each other, the closest points may be in the wrong order.
    const bool agrees = !has_axis || dot(normal, best.normal) > 0;
    if (gap > 0 && agrees && !(has_axis && corners && gap < blur)) {
      best.separation = gap;
      best.normal = normal;
      is_separated = true;
    } else if (!has_axis) {
      best.separation = 0;
      best.normal = a.count > 1 ? a.normals[0] : Vec2{0, 1};
    }
  }
  // Parallel faces touch in the middle of their common width; other shapes touch midway between the closest features.
  if (a.count > 1 && b.count > 1) {
    const Real tolerance = Real(1e-3) * pair_size(shape_a, shape_b);
    const Manifold faces =
        between_edges(a, shape_a.radius, b, shape_b.radius, best.normal, (best.separation - radii) + tolerance);
    if (faces.point_count == 2) {
      best.point = pose_a.position + Real(0.5) * (faces.points[0].anchor_a + faces.points[1].anchor_a);
      best.separation = best.separation - radii;
      return best;
    }
  }
  Vec2 middle = Real(0.5) * (closest.on_a + closest.on_b);
  // Overlapping shapes touch at the corner that is deepest in the other shape.
  if (has_axis && !is_separated) {
    const Vec2 deepest = axis_is_of_a ? farthest_vertex(b, -best.normal) : farthest_vertex(a, best.normal);
    middle = deepest + (axis_is_of_a ? Real(-0.5) : Real(0.5)) * best.separation * best.normal;
  }
  best.point = pose_a.position + middle + (Real(0.5) * (shape_a.radius - shape_b.radius)) * best.normal;
  best.separation = best.separation - radii;
  return best;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
