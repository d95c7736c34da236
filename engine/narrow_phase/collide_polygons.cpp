// Contacts of two convex polygons: separating axes of both, then the edges of deepest overlap clipped.
// SPDX-License-Identifier: MIT
// Source: Gottschalk, "Separating Axis Theorem", 1996; clipping after Sutherland and Hodgman, 1974.
#include "engine/narrow_phase/convex_hulls.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

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
  HullBuffer buffer;
  const Hull hull_a = hull_of(model, a);
  const Hull hull_b = hull_of(model, b, b_in_a, buffer);

  const Axis axis_a = best_axis(hull_a, hull_b);
  if (!(axis_a.separation <= margin)) return {};
  const Axis axis_b = best_axis(hull_b, hull_a);
  if (!(axis_b.separation <= margin)) return {};

  // A is preferred by a tenth of the slop, so that equal overlaps do not make the reference edge flicker.
  const Real preference = Real(0.1) * linear_slop(pair_size(a, b));
  if (axis_b.separation > axis_a.separation + preference) {
    Manifold manifold = clip(hull_b, axis_b.edge, hull_a, margin, false);
    manifold.normal = -manifold.normal;
    return manifold;
  }
  return clip(hull_a, axis_a.edge, hull_b, margin, true);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
