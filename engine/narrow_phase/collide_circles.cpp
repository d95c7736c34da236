// Contacts that involve a circle.
// SPDX-License-Identifier: MIT
// Source: Ericson, "Real-Time Collision Detection", 2005, section 5.1 (closest points and Voronoi regions).
#include "engine/math/trig.h"
#include "engine/narrow_phase/narrow_phase.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// One point halfway between the surfaces of a round shape (center, radius) on A's side and one on B's side.
Manifold between_rounds(Vec2 center_a, Real radius_a, Vec2 center_b, Real radius_b, Real margin,
                        std::uint32_t feature) {
  Manifold manifold;
  const Vec2 offset = center_b - center_a;
  const Real distance = length(offset);
  const Real separation = distance - radius_a - radius_b;
  if (!(separation <= margin)) return manifold;
  // Coincident centres have no direction between them; any direction separates them: see parting_direction.
  manifold.normal = distance > 0 ? (1 / distance) * offset : Vec2{0, 1};
  const Vec2 on_a = center_a + radius_a * manifold.normal;
  const Vec2 on_b = center_b - radius_b * manifold.normal;
  manifold.point_count = 1;
  manifold.points[0] = {Real(0.5) * (on_a + on_b), {}, separation, feature};
  return manifold;
}

}  // namespace

Manifold collide_circles(const Model&, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a, Real margin) {
  return between_rounds(a.center, a.radius, b_in_a.position + rotate(b_in_a.rotation, b.center), b.radius, margin, 0);
}

Vec2 parting_direction(std::uint32_t id_a, std::uint32_t id_b) {
  constexpr double golden_angle = 2.39996322972865332;  // rad
  constexpr std::uint32_t seed_count = 1u << 16;        // keeps the angles small
  struct Seed {
    double x, y;
  };
  const auto seed_of = [&](std::uint32_t id) {
    const double number = id % seed_count;
    const SinCos angle = sin_cos(number * golden_angle);
    return Seed{__builtin_sqrt(number) * angle.cos, __builtin_sqrt(number) * angle.sin};
  };
  const Seed a = seed_of(id_a), b = seed_of(id_b);
  const double x = b.x - a.x, y = b.y - a.y;
  const double distance = __builtin_sqrt(x * x + y * y);
  if (!(distance > 0)) return {0, 1};
  return {static_cast<Real>(x / distance), static_cast<Real>(y / distance)};
}

namespace {

/// The ends of an edge v1, v2 that are closer to a circle than `margin`, or `nearest` if none is. Features: see below.
Manifold between_ends(const Vec2 (&ends)[2], const std::uint32_t (&features)[2], Vec2 center, Real radius,
                      const Manifold& nearest, Real margin) {
  Manifold manifold;
  manifold.normal = nearest.normal;
  for (int i = 0; i < 2; ++i) {
    const Real separation = length(center - ends[i]) - radius;
    if (!(separation <= margin)) continue;
    const Vec2 anchor = ends[i] + (Real(0.5) * separation) * nearest.normal;
    manifold.points[manifold.point_count++] = {anchor, {}, separation, features[i]};
  }
  return manifold.point_count > 0 ? manifold : nearest;
}

/// may_lie: an edge from which the circle is nowhere farther than the slop while it touches both ends lies on them. Its
/// closest point alone moves along the whole edge within a tick, and the edge would tip to and fro.
template <bool may_lie>
Manifold polygon_circle(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a,
                        Real margin) {
  const Vec2 center = b_in_a.position + rotate(b_in_a.rotation, b.center);
  const Vec2* vertices = &model.vertices[a.first_vertex];
  const Vec2* normals = &model.normals[a.first_vertex];
  std::uint32_t edge = 0;
  Real outside = dot(normals[0], center - vertices[0]);
  for (std::uint32_t i = 1; i < a.vertex_count; ++i) {
    const Real distance = dot(normals[i], center - vertices[i]);
    if (distance > outside) {
      outside = distance;
      edge = i;
    }
  }
  if (!(outside - b.radius <= margin)) return {};

  const std::uint32_t next = edge + 1 < a.vertex_count ? edge + 1 : 0;
  const Vec2 v1 = vertices[edge];
  const Vec2 v2 = vertices[next];
  const auto lying = [&](const Manifold& nearest) {
    if (!may_lie || nearest.point_count == 0 || !(outside > 0)) return nearest;
    if (length_squared(v2 - v1) > 8 * b.radius * linear_slop(pair_size(a, b))) return nearest;
    return between_ends({v1, v2}, {16 + edge, 16 + next}, center, b.radius, nearest, margin);
  };
  if (outside > 0) {
    // Beyond an end of the edge, the closest point is the vertex. Features 0..15 are edges, 16..31 vertices.
    if (dot(center - v1, v2 - v1) < 0) return lying(between_rounds(v1, 0, center, b.radius, margin, 16 + edge));
    if (dot(center - v2, v1 - v2) < 0) return lying(between_rounds(v2, 0, center, b.radius, margin, 16 + next));
  }
  Manifold manifold;
  manifold.normal = normals[edge];
  const Vec2 on_a = center - outside * manifold.normal;
  const Vec2 on_b = center - b.radius * manifold.normal;
  manifold.point_count = 1;
  manifold.points[0] = {Real(0.5) * (on_a + on_b), {}, outside - b.radius, edge};
  return lying(manifold);
}

template <bool may_lie>
Manifold circle_polygon(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a,
                        Real margin) {
  const Rotation a_rotation{b_in_a.rotation.c, -b_in_a.rotation.s};
  const Placement a_in_b{-rotate(a_rotation, b_in_a.position), a_rotation};
  Manifold manifold = polygon_circle<may_lie>(model, b, a, a_in_b, margin);
  manifold.normal = -rotate(b_in_a.rotation, manifold.normal);
  for (int i = 0; i < manifold.point_count; ++i)
    manifold.points[i].anchor_a = b_in_a.position + rotate(b_in_a.rotation, manifold.points[i].anchor_a);
  return manifold;
}

}  // namespace

Manifold collide_polygon_circle(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a,
                                Real margin) {
  return polygon_circle<false>(model, a, b, b_in_a, margin);
}
Manifold collide_circle_polygon(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a,
                                Real margin) {
  return circle_polygon<false>(model, a, b, b_in_a, margin);
}
Manifold collide_polygon_on_circle(const Model& model, const ShapeModel& a, const ShapeModel& b,
                                   const Placement& b_in_a, Real margin) {
  return polygon_circle<true>(model, a, b, b_in_a, margin);
}
Manifold collide_circle_under_polygon(const Model& model, const ShapeModel& a, const ShapeModel& b,
                                      const Placement& b_in_a, Real margin) {
  return circle_polygon<true>(model, a, b, b_in_a, margin);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
