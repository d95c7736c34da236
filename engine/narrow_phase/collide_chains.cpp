// Contacts with an edge of a chain, from its right side only. The neighbours of the edge restrict its normals, so that
// a shape slides or rolls over a corner without a bump.
// SPDX-License-Identifier: MIT
// Source: van den Bergen, "Game Physics Pearls", 2010, chapter 4 (Voronoi regions of a mesh decide which normals are
// real). A convex corner owns the normals between those of its edges, and belongs to the edge that ends there. A
// straight or concave corner owns no normal. A point is in the same region from either edge, bit for bit.
#include "engine/narrow_phase/convex_hulls.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// Corners with a smaller sine count as straight: a hull lies flat on both edges.
constexpr Real straight_sine = Real(0.01);
/// The share by which a region is enlarged where a lost contact is worse than a double contact.
constexpr Real region_tolerance = Real(1e-3);

struct Edge {
  Vec2 begin, end;
  Vec2 along;   // end - begin
  Vec2 normal;  // to the right
  bool has_before, has_after;
  Vec2 along_before;  // of the edge before this one
  Vec2 along_after;   // of the edge after this one
  bool convex_before, convex_after;
};

/// Whether a corner is convex. A tip where the chain reverses is convex, too: it must have contacts from ahead.
bool is_convex(Vec2 first, Vec2 second) {
  const Real limit = straight_sine * square_root(length_squared(first) * length_squared(second));
  const Real sine = cross(first, second);
  return sine > limit || (sine >= -limit && dot(first, second) < 0);
}

Edge edge_of(const Model& model, const ShapeModel& shape) {
  Edge edge;
  edge.begin = model.vertices[shape.first_vertex];
  edge.end = model.vertices[shape.first_vertex + 1];
  edge.along = edge.end - edge.begin;
  edge.normal = model.normals[shape.first_vertex];
  edge.has_before = shape.has_before;
  edge.has_after = shape.has_after;
  edge.along_before = edge.begin - shape.before;
  edge.along_after = shape.after - edge.end;
  edge.convex_before = shape.has_before && is_convex(edge.along_before, edge.along);
  edge.convex_after = shape.has_after && is_convex(edge.along, edge.along_after);
  return edge;
}

/// Whether a normal belongs to a corner at an end of the edge.
bool belongs_to_corner(const Edge& edge, Vec2 normal) {
  const Real along = dot(edge.along, normal);
  if (along > 0) {
    if (!edge.has_after) return dot(edge.normal, normal) >= 0;
    return edge.convex_after && dot(edge.along_after, normal) <= 0;
  }
  if (!edge.has_before) return dot(edge.normal, normal) >= 0;
  return edge.convex_before && dot(edge.along_before, normal) >= 0;
}

enum class Region : std::uint8_t { none, face, corner };

/// The region of an edge that contains the closest point. The region decides the normal.
Region region_of(const Edge& edge, const ClosestPoints& closest, bool in_front) {
  const Region face = in_front ? Region::face : Region::none;
  if (closest.vertex_a == no_vertex) return face;
  const Vec2 offset = closest.on_b - closest.on_a;
  const bool at_end = closest.vertex_a == 1;
  if (at_end ? !edge.has_after : !edge.has_before) return dot(edge.normal, offset) >= 0 ? Region::corner : Region::none;
  if (at_end ? !edge.convex_after : !edge.convex_before) return face;
  if (!at_end) return Region::none;  // the edge before owns this corner
  const Real limit = region_tolerance * square_root(length_squared(edge.along_after) * closest.distance_squared);
  return dot(edge.along_after, offset) <= limit ? Region::corner : Region::none;
}

/// The normal of overlapping cores: that of the edge, or a hull normal that belongs to a corner, if its overlap is
/// smaller.
Vec2 overlap_normal(const Edge& edge, const Hull& line, const Hull& hull, Real preference) {
  const Hull face{line.vertices, line.normals, 2};
  Real deepest = dot(edge.normal, hull.vertices[0] - edge.begin);
  for (std::uint32_t i = 1; i < hull.count; ++i)
    deepest = smaller(deepest, dot(edge.normal, hull.vertices[i] - edge.begin));
  Vec2 best = edge.normal;
  Real best_separation = deepest + preference;
  for (std::uint32_t i = 0; i < hull.count; ++i) {
    const Vec2 normal = -hull.normals[i];
    const Real separation = smaller(dot(hull.normals[i], face.vertices[0] - hull.vertices[i]),
                                    dot(hull.normals[i], face.vertices[1] - hull.vertices[i]));
    if (separation <= best_separation || !belongs_to_corner(edge, normal)) continue;
    best = normal;
    best_separation = separation;
  }
  return best;
}

}  // namespace

EdgeNormal edge_normal(const Model& model, const ShapeModel& shape, Vec2 normal, Vec2 center) {
  const Edge edge = edge_of(model, shape);
  const bool in_front = dot(edge.normal, center - edge.begin) >= 0;
  const Real limit = 16 * epsilon * square_root(length_squared(edge.along));  // the rounding of two rotations
  const bool along_own = absolute(dot(edge.along, normal)) <= limit;
  if (dot(edge.normal, normal) > 0 && (along_own || belongs_to_corner(edge, normal))) {
    const bool is_owned = along_own || !edge.has_before || dot(edge.along, normal) > 0;
    return {true, in_front, is_owned, normal};
  }
  return {false, in_front, true, edge.normal};
}

Manifold collide_chain_circle(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a,
                              Real margin) {
  const Edge edge = edge_of(model, a);
  const Vec2 center = b_in_a.position + rotate(b_in_a.rotation, b.center);
  const Vec2 from_begin = center - edge.begin;
  const Vec2 from_end = center - edge.end;
  const Real height = dot(edge.normal, from_begin);
  const Real distance_max = b.radius + margin;
  if (!(height <= distance_max)) return {};
  ClosestPoints closest;
  closest.on_b = center;
  closest.vertex_b = 0;
  if (dot(edge.along, from_begin) <= 0) {
    if (edge.has_before) return {};
    closest.on_a = edge.begin;
    closest.vertex_a = 0;
  } else if (dot(edge.along, from_end) >= 0) {
    if (edge.has_after && dot(edge.along_after, from_end) > 0) return {};
    closest.on_a = edge.end;
    closest.vertex_a = 1;
  }
  if (closest.vertex_a == no_vertex) {
    if (height < 0) return {};
    closest.on_a = center - height * edge.normal;
    return between_points(closest, 0, b.radius, edge.normal, margin);
  }
  const Vec2 offset = closest.on_b - closest.on_a;
  const Real distance = length(offset);
  const bool at_joint = closest.vertex_a == 1 && edge.has_after;
  const bool in_front = height >= 0 || (at_joint && dot(right_turn(edge.along_after), offset) >= 0);
  if (!in_front || !(distance <= distance_max)) return {};
  return between_points(closest, 0, b.radius, distance > 0 ? (1 / distance) * offset : edge.normal, margin);
}

Manifold collide_chain_hull(const Model& model, const ShapeModel& a, const ShapeModel& b, const Placement& b_in_a,
                            Real margin) {
  HullBuffer buffer;
  const Hull line = hull_of(model, a);
  const Hull hull = hull_of(model, b, b_in_a, buffer);
  const Real distance_max = b.radius + margin;
  const Overlap overlap = find_overlap(line, hull, distance_max);
  if (!overlap.is_within_distance) return {};
  const Edge edge = edge_of(model, a);
  const Vec2 center = b_in_a.position + rotate(b_in_a.rotation, b.center);
  const bool in_front = dot(edge.normal, center - edge.begin) >= 0;

  if (!overlap.found) {
    const ClosestPoints closest = closest_points(line, hull);
    if (!(closest.distance_squared <= distance_max * distance_max)) return {};
    if (closest.distance_squared > 0) {
      const Region region = region_of(edge, closest, in_front);
      if (region == Region::none) return {};
      if (region == Region::face) return between_edges(line, 0, hull, b.radius, edge.normal, margin);
      const Vec2 normal = closest_normal(line, hull, closest);
      const Manifold manifold = between_edges(line, 0, hull, b.radius, normal, margin);
      return manifold.point_count > 0 ? manifold : between_points(closest, 0, b.radius, normal, margin);
    }
  }
  if (!in_front) return {};
  const Real preference = Real(0.1) * linear_slop(b.size);
  return between_edges(line, 0, hull, b.radius, overlap_normal(edge, line, hull, preference), margin);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
