// Separating axes, closest features and contact points between facing edges, for all hulls.
// SPDX-License-Identifier: MIT
// Source: Gottschalk, "Separating Axis Theorem", 1996; Ericson, "Real-Time Collision Detection", 2005, section 5.1.
#pragma once

#include "base/limits.h"
#include "engine/narrow_phase/narrow_phase.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// A convex outline, counter-clockwise. Two vertices: a line with two opposite edges.
struct Hull {
  const Vec2* vertices;
  const Vec2* normals;
  std::uint32_t count;

  std::uint32_t next(std::uint32_t i) const { return i + 1 < count ? i + 1 : 0; }
};

struct Axis {
  std::uint32_t edge = 0;
  Real separation = 0;  // of the other hull beyond the edge, m
};

/// The edge of `a` beyond which `b` lies farthest out (or overlaps least).
inline Axis best_axis(const Hull& a, const Hull& b) {
  Axis best;
  for (std::uint32_t i = 0; i < a.count; ++i) {
    const Vec2 normal = a.normals[i];
    Real deepest = dot(normal, b.vertices[0]);
    for (std::uint32_t j = 1; j < b.count; ++j) deepest = smaller(deepest, dot(normal, b.vertices[j]));
    const Real separation = deepest - dot(normal, a.vertices[i]);
    if (i == 0 || separation > best.separation) best = {i, separation};
  }
  return best;
}

/// The edge whose outward normal points most against `normal`.
inline std::uint32_t opposite_edge(const Hull& hull, Vec2 normal) {
  std::uint32_t edge = 0;
  Real least = dot(normal, hull.normals[0]);
  for (std::uint32_t i = 1; i < hull.count; ++i) {
    const Real along = dot(normal, hull.normals[i]);
    if (along < least) {
      least = along;
      edge = i;
    }
  }
  return edge;
}

/// Feature of a point: the vertex on A's side and the vertex on B's side that bound it.
inline std::uint32_t feature_of(std::uint32_t vertex_a, std::uint32_t vertex_b) {
  return vertex_a << 8 | vertex_b;
}

/// Memory for a hull in another frame. It is not initialized, since initialization takes longer than filling.
struct HullBuffer {
  HullBuffer() {}
  union {
    Vec2 vertices[limits::polygon_vertex_count_max];
  };
  union {
    Vec2 normals[limits::polygon_vertex_count_max];
  };
};

inline Hull hull_of(const Model& model, const ShapeModel& shape) {
  return {&model.vertices[shape.first_vertex], &model.normals[shape.first_vertex], shape.vertex_count};
}
inline Hull hull_of(const Model& model, const ShapeModel& shape, const Placement& placement, HullBuffer& buffer) {
  for (std::uint32_t i = 0; i < shape.vertex_count; ++i) {
    buffer.vertices[i] = placement.position + rotate(placement.rotation, model.vertices[shape.first_vertex + i]);
    buffer.normals[i] = rotate(placement.rotation, model.normals[shape.first_vertex + i]);
  }
  return {buffer.vertices, buffer.normals, shape.vertex_count};
}

inline constexpr std::uint32_t no_vertex = 0xff;

/// The closest points of two hulls that do not overlap. At least one point is a vertex.
struct ClosestPoints {
  Vec2 on_a;
  Vec2 on_b;
  Real distance_squared = -1;
  std::uint32_t vertex_a = no_vertex;  // no_vertex: inside edge_a
  std::uint32_t vertex_b = no_vertex;
  std::uint32_t edge_a = 0;
  std::uint32_t edge_b = 0;
};
ClosestPoints closest_points(const Hull& a, const Hull& b);

/// Whether the hulls share a point, exact except for rounding, lines included.
struct Overlap {
  Axis axis_a;  // best_axis(a, b)
  Axis axis_b;  // best_axis(b, a), if the hulls are near
  bool found;
  bool is_within_distance;  // no axis separates them by more than `distance_max`
};
Overlap find_overlap(const Hull& a, const Hull& b, Real distance_max);

/// Up to two points between the edges of A and B that face each other along `normal`, at both ends of their common
/// width. The hulls may have radii. No points if the edges have no common width, or are farther apart than `margin`.
Manifold between_edges(const Hull& a, Real radius_a, const Hull& b, Real radius_b, Vec2 normal, Real margin);

/// One point between the closest points of two hulls; `normal` is from A to B.
Manifold between_points(const ClosestPoints& closest, Real radius_a, Real radius_b, Vec2 normal, Real margin);

/// The unit vector from A to B at their closest points. Requires: the hulls are apart.
Vec2 closest_normal(const Hull& a, const Hull& b, const ClosestPoints& closest);

/// The manifold of A and B, from a function that takes B and A.
template <CollideFunction collide_b_a>
Manifold swapped(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a, Real margin) {
  const Rotation a_rotation{b_in_a.rotation.c, -b_in_a.rotation.s};
  const Placement a_in_b{-rotate(a_rotation, b_in_a.position), a_rotation};
  Manifold manifold = collide_b_a(model, b, a, a_in_b, margin);
  manifold.normal = -rotate(b_in_a.rotation, manifold.normal);
  for (int i = 0; i < manifold.point_count; ++i)
    manifold.points[i].anchor_a = b_in_a.position + rotate(b_in_a.rotation, manifold.points[i].anchor_a);
  return manifold;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
