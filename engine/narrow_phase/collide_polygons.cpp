// Contacts of two convex polygons: separating axes of both, then the edges of deepest overlap clipped.
// SPDX-License-Identifier: MIT
// Source: Gottschalk, "Separating Axis Theorem", 1996; clipping after Sutherland and Hodgman, 1974.
#include "base/limits.h"
#include "engine/narrow_phase/narrow_phase.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

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
Axis best_axis(const Hull& a, const Hull& b) {
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
std::uint32_t opposite_edge(const Hull& hull, Vec2 normal) {
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
std::uint32_t feature_of(std::uint32_t vertex_a, std::uint32_t vertex_b) {
  return vertex_a << 8 | vertex_b;
}

/// Clips the incident edge of `other` to the width of the reference edge of `reference`. The normal of the result
/// points away from `reference`; features name the vertices of A first, whichever hull that is.
Manifold clip(const Hull& reference, std::uint32_t edge, const Hull& other, Real margin, bool reference_is_a) {
  const std::uint32_t r1 = edge;
  const std::uint32_t r2 = reference.next(edge);
  const Vec2 normal = reference.normals[edge];
  const std::uint32_t i1 = opposite_edge(other, normal);
  const std::uint32_t i2 = other.next(i1);

  // Along the reference edge, from r1 to r2; the incident edge runs the other way, from i2's end to i1's.
  const Vec2 v1 = reference.vertices[r1];
  const Vec2 tangent = cross(Real(1), normal);
  const Real reference_end = dot(reference.vertices[r2] - v1, tangent);
  const Vec2 lower_vertex = other.vertices[i2];
  const Vec2 upper_vertex = other.vertices[i1];
  const Real lower = dot(lower_vertex - v1, tangent);
  const Real upper = dot(upper_vertex - v1, tangent);
  Manifold manifold;
  if (upper < 0 || lower > reference_end) return manifold;

  Vec2 lower_point = lower_vertex;
  Vec2 upper_point = upper_vertex;
  if (lower < 0 && upper - lower > 0)
    lower_point = lower_vertex + (-lower / (upper - lower)) * (upper_vertex - lower_vertex);
  if (upper > reference_end && upper - lower > 0)
    upper_point = lower_vertex + ((reference_end - lower) / (upper - lower)) * (upper_vertex - lower_vertex);

  manifold.normal = normal;
  const auto add = [&](Vec2 point, std::uint32_t reference_vertex, std::uint32_t other_vertex) {
    const Real separation = dot(point - v1, normal);
    if (!(separation <= margin)) return;
    const Vec2 middle = point - (Real(0.5) * separation) * normal;
    manifold.points[manifold.point_count++] = {
        middle,
        {},
        separation,
        reference_is_a ? feature_of(reference_vertex, other_vertex) : feature_of(other_vertex, reference_vertex)};
  };
  add(lower_point, r1, i2);
  add(upper_point, r2, i1);
  return manifold;
}

}  // namespace

Manifold collide_polygons(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a,
                          Real margin) {
  Vec2 vertices[limits::polygon_vertex_count_max];
  Vec2 normals[limits::polygon_vertex_count_max];
  for (std::uint32_t i = 0; i < b.vertex_count; ++i) {
    vertices[i] = b_in_a.position + rotate(b_in_a.rotation, model.vertices[b.first_vertex + i]);
    normals[i] = rotate(b_in_a.rotation, model.normals[b.first_vertex + i]);
  }
  const Hull hull_a{&model.vertices[a.first_vertex], &model.normals[a.first_vertex], a.vertex_count};
  const Hull hull_b{vertices, normals, b.vertex_count};

  const Axis axis_a = best_axis(hull_a, hull_b);
  if (!(axis_a.separation <= margin)) return {};
  const Axis axis_b = best_axis(hull_b, hull_a);
  if (!(axis_b.separation <= margin)) return {};

  // A is preferred by a tenth of the slop, so that equal overlaps do not make the reference edge flicker.
  const Real preference = Real(0.1) * linear_slop(smaller(a.size, b.size));
  if (axis_b.separation > axis_a.separation + preference) {
    Manifold manifold = clip(hull_b, axis_b.edge, hull_a, margin, false);
    manifold.normal = -manifold.normal;
    return manifold;
  }
  return clip(hull_a, axis_a.edge, hull_b, margin, true);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
