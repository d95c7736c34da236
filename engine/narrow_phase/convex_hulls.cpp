// Closest features of two hulls, and contact points between facing edges.
// SPDX-License-Identifier: MIT
// Source: Ericson, "Real-Time Collision Detection", 2005, section 5.1.2 (closest point on a segment).
#include "engine/narrow_phase/convex_hulls.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr Real degenerate_share = Real(1e-4);

std::uint32_t edge_count(const Hull& hull) {
  return hull.count == 2 ? 1 : hull.count;
}

/// The closest point of an edge to a point, and the vertex if the point is a vertex.
struct OnEdge {
  Vec2 point;
  std::uint32_t vertex;
};
OnEdge closest_on_edge(const Hull& hull, std::uint32_t edge, Vec2 p) {
  const std::uint32_t next = hull.next(edge);
  const Vec2 v1 = hull.vertices[edge];
  const Vec2 v2 = hull.vertices[next];
  const Vec2 along = v2 - v1;
  const Real share = dot(p - v1, along);
  const Real whole = dot(along, along);
  if (share <= 0) return {v1, edge};
  if (share >= whole) return {v2, next};
  return {v1 + (share / whole) * along, no_vertex};
}

Real clamped_share(Real part, Real whole) {
  return whole > 0 ? smaller(larger(part / whole, 0), 1) : Real(0);
}

}  // namespace

ClosestPoints closest_points(const Hull& a, const Hull& b) {
  ClosestPoints best;
  for (std::uint32_t i = 0; i < a.count; ++i)
    for (std::uint32_t j = 0; j < edge_count(b); ++j) {
      const OnEdge on_b = closest_on_edge(b, j, a.vertices[i]);
      const Real distance = length_squared(on_b.point - a.vertices[i]);
      if (best.distance_squared >= 0 && distance >= best.distance_squared) continue;
      best = {a.vertices[i], on_b.point, distance, i, on_b.vertex, i, j};
    }
  for (std::uint32_t j = 0; j < b.count; ++j)
    for (std::uint32_t i = 0; i < edge_count(a); ++i) {
      const OnEdge on_a = closest_on_edge(a, i, b.vertices[j]);
      const Real distance = length_squared(b.vertices[j] - on_a.point);
      if (distance >= best.distance_squared) continue;
      best = {on_a.point, b.vertices[j], distance, on_a.vertex, j, i, j};
    }
  return best;
}

Overlap find_overlap(const Hull& a, const Hull& b, Real distance_max) {
  const Axis axis_a = best_axis(a, b);
  if (!(axis_a.separation <= distance_max)) return {axis_a, axis_a, false, false};
  const Axis axis_b = best_axis(b, a);
  const Real separation = larger(axis_a.separation, axis_b.separation);
  // Two lines overlap if they cross. Two lines on one line, or end to end, have no separating axis.
  const bool lines = a.count == 2 && b.count == 2;
  return {axis_a, axis_b, lines ? separation < 0 : separation <= 0, axis_b.separation <= distance_max};
}

Vec2 closest_normal(const Hull& a, const Hull& b, const ClosestPoints& closest) {
  const Vec2 offset = closest.on_b - closest.on_a;
  // Beside an edge, the normal of the edge is more exact than the difference of two points. A line has a normal on each
  // side.
  if (closest.vertex_a == no_vertex) {
    const Vec2 normal = a.normals[closest.edge_a];
    return dot(normal, offset) < 0 ? -normal : normal;
  }
  if (closest.vertex_b == no_vertex) {
    const Vec2 normal = -b.normals[closest.edge_b];
    return dot(normal, offset) < 0 ? -normal : normal;
  }
  return (1 / length(offset)) * offset;
}

Manifold between_points(const ClosestPoints& closest, Real radius_a, Real radius_b, Vec2 normal, Real margin) {
  Manifold manifold;
  const Real separation = dot(closest.on_b - closest.on_a, normal) - radius_a - radius_b;
  if (!(separation <= margin)) return manifold;
  manifold.normal = normal;
  manifold.point_count = 1;
  // Vertices count from 0, edges from 16.
  const std::uint32_t feature_a = closest.vertex_a == no_vertex ? 16 + closest.edge_a : closest.vertex_a;
  const std::uint32_t feature_b = closest.vertex_b == no_vertex ? 16 + closest.edge_b : closest.vertex_b;
  manifold.points[0] = {
      closest.on_a + (radius_a + Real(0.5) * separation) * normal, {}, separation, feature_of(feature_a, feature_b)};
  return manifold;
}

Manifold between_edges(const Hull& a, Real radius_a, const Hull& b, Real radius_b, Vec2 normal, Real margin) {
  // A's edge runs along the tangent, B's edge in the opposite direction.
  const std::uint32_t a1 = opposite_edge(a, -normal);
  const std::uint32_t a2 = a.next(a1);
  const std::uint32_t b1 = opposite_edge(b, normal);
  const std::uint32_t b2 = b.next(b1);
  const Vec2 tangent = cross(Real(1), normal);
  const Vec2 begin_a = a.vertices[a1];
  const Vec2 edge_a = a.vertices[a2] - begin_a;
  const Vec2 begin_b = b.vertices[b2];
  const Vec2 edge_b = b.vertices[b1] - begin_b;
  const Real end_a = dot(edge_a, tangent);
  const Real lower_b = dot(begin_b - begin_a, tangent);
  const Real upper_b = dot(b.vertices[b1] - begin_a, tangent);
  Manifold manifold;
  const Real common = smaller(end_a, upper_b) - larger(0, lower_b);
  // Edges that diverge from one point have no common width except rounding.
  if (!(common >= degenerate_share * smaller(end_a, upper_b - lower_b))) return manifold;

  manifold.normal = normal;
  const auto add = [&](Vec2 on_a, Vec2 on_b, std::uint32_t vertex_a, std::uint32_t vertex_b) {
    const Real separation = dot(on_b - on_a, normal) - radius_a - radius_b;
    if (!(separation <= margin)) return;
    manifold.points[manifold.point_count++] = {
        on_a + (radius_a + Real(0.5) * separation) * normal, {}, separation, feature_of(vertex_a, vertex_b)};
  };
  // At each end of the common width, one of the two edges ends.
  const auto at_a = [&](Real along) { return begin_a + clamped_share(along, end_a) * edge_a; };
  const auto at_b = [&](Real along) { return begin_b + clamped_share(along - lower_b, upper_b - lower_b) * edge_b; };
  if (lower_b < 0)
    add(begin_a, at_b(0), a1, b2);
  else
    add(at_a(lower_b), begin_b, a1, b2);
  if (upper_b > end_a)
    add(a.vertices[a2], at_b(end_a), a2, b1);
  else
    add(at_a(upper_b), b.vertices[b1], a2, b1);
  return manifold;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
