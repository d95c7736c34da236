// Contacts of two convex polygons: separating axes of both, then the edges of deepest overlap clipped.
// SPDX-License-Identifier: MIT
// Source: Gottschalk, "Separating Axis Theorem", 1996; clipping: clip_edge.h.
//
// Two quadrilaterals test all axes of one polygon at once. Each lane does the operations of the loop over edges in the
// same order.
#include "engine/narrow_phase/clip_edge.h"
#include "engine/narrow_phase/convex_hulls.h"
#include "engine/simd/realx4.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

// ---- Any number of corners ----

Vec2 vertex_of(const Hull& hull, std::uint32_t i) {
  return hull.vertices[i];
}
Vec2 normal_of(const Hull& hull, std::uint32_t i) {
  return hull.normals[i];
}
std::uint32_t next_of(const Hull& hull, std::uint32_t i) {
  return hull.next(i);
}

// ---- Four corners ----

Vec2 vertex_of(const Quad& quad, std::uint32_t i) {
  return {quad.x[i], quad.y[i]};
}
Vec2 normal_of(const Quad& quad, std::uint32_t i) {
  return {quad.normal_x[i], quad.normal_y[i]};
}
std::uint32_t next_of(const Quad&, std::uint32_t i) {
  return (i + 1) & 3;
}

Realx4 dot_x4(const Realx4& ax, const Realx4& ay, const Realx4& bx, const Realx4& by) {
  return ax * bx + ay * by;
}

Axis best_axis(const Quad& a, const Quad& b) {
  const Realx4 normal_x = load_x4(a.normal_x);
  const Realx4 normal_y = load_x4(a.normal_y);
  const auto along = [&](int j) { return b.x[j] * normal_x + b.y[j] * normal_y; };
  const Realx4 deepest = smaller(smaller(smaller(along(0), along(1)), along(2)), along(3));
  Real separations[4];
  store_x4(separations, deepest - dot_x4(normal_x, normal_y, load_x4(a.x), load_x4(a.y)));
  Axis best{0, separations[0]};
  for (std::uint32_t i = 1; i < 4; ++i) {  // selections, since the best axis is hard to predict
    const bool is_better = separations[i] > best.separation;
    best.edge = is_better ? i : best.edge;
    best.separation = is_better ? separations[i] : best.separation;
  }
  return best;
}

std::uint32_t opposite_edge(const Quad& quad, Vec2 normal) {
  Real along[4];
  store_x4(along, normal.x * load_x4(quad.normal_x) + normal.y * load_x4(quad.normal_y));
  std::uint32_t edge = 0;
  Real least = along[0];
  for (std::uint32_t i = 1; i < 4; ++i) {
    const bool is_better = along[i] < least;
    edge = is_better ? i : edge;
    least = is_better ? along[i] : least;
  }
  return edge;
}

Quad seen_from(const Placement& placement, const Quad& quad) {
  const Rotation q = placement.rotation;
  const Realx4 x = load_x4(quad.x), y = load_x4(quad.y);
  const Realx4 normal_x = load_x4(quad.normal_x), normal_y = load_x4(quad.normal_y);
  Quad seen;
  store_x4(seen.x, placement.position.x + (q.c * x - q.s * y));
  store_x4(seen.y, placement.position.y + (q.s * x + q.c * y));
  store_x4(seen.normal_x, q.c * normal_x - q.s * normal_y);
  store_x4(seen.normal_y, q.s * normal_x + q.c * normal_y);
  return seen;
}

// ---- Both ----

/// Clips the incident edge of `other` to the width of the reference edge of `reference`. The normal of the result
/// points away from `reference`. Features name the vertices of A first, whichever polygon is the reference.
template <typename Outline>
void clip(const Outline& reference, std::uint32_t edge, const Outline& other, Real margin, bool reference_is_a,
          Manifold& manifold) {
  const std::uint32_t r1 = edge;
  const std::uint32_t r2 = next_of(reference, edge);
  const Vec2 normal = normal_of(reference, edge);
  const std::uint32_t i1 = opposite_edge(other, normal);
  const std::uint32_t i2 = next_of(other, i1);

  const Vec2 from = vertex_of(reference, r1), to = vertex_of(reference, r2);
  const Vec2 incident_from = vertex_of(other, i1), incident_to = vertex_of(other, i2);
  const ClippedEdge<Real> clipped = clip_edge<Real>({from.x, from.y, to.x, to.y}, normal.x, normal.y,
                                                    {incident_from.x, incident_from.y, incident_to.x, incident_to.y});
  if (clipped.is_beside) return;

  manifold.normal = normal;
  const auto add = [&](int point, std::uint32_t reference_vertex, std::uint32_t other_vertex) {
    if (!(clipped.separation[point] <= margin)) return;
    manifold.points[manifold.point_count++] = {
        {clipped.middle_x[point], clipped.middle_y[point]},
        {},
        clipped.separation[point],
        reference_is_a ? feature_of(reference_vertex, other_vertex) : feature_of(other_vertex, reference_vertex)};
  };
  add(0, r1, i2);
  add(1, r2, i1);
}

template <typename Outline>
Manifold collide_outlines(const Outline& a, const Outline& b, Real margin, Real preference) {
  Manifold manifold;
  const Axis axis_a = best_axis(a, b);
  if (!(axis_a.separation <= margin)) return manifold;
  const Axis axis_b = best_axis(b, a);
  if (!(axis_b.separation <= margin)) return manifold;
  if (axis_b.separation > axis_a.separation + preference) {
    clip(b, axis_b.edge, a, margin, false, manifold);
    manifold.normal = -manifold.normal;
  } else {
    clip(a, axis_a.edge, b, margin, true, manifold);
  }
  return manifold;
}

}  // namespace

Manifold collide_polygons(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a,
                          Real margin) {
  // A is preferred by a tenth of the slop, so that rounding does not switch the reference edge at equal overlaps.
  const Real preference = Real(0.1) * linear_slop(pair_size(a, b));
  if (a.quad != no_quad && b.quad != no_quad)
    return collide_outlines(model.quads[a.quad], seen_from(b_in_a, model.quads[b.quad]), margin, preference);
  HullBuffer buffer;
  return collide_outlines(hull_of(model, a), hull_of(model, b, b_in_a, buffer), margin, preference);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
