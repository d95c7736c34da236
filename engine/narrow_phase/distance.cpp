// Separating axes while shapes overlap, nearest features while they are apart.
// SPDX-License-Identifier: MIT
// Source: Ericson, "Real-Time Collision Detection", 2004, sections 5.1.2 (point and segment) and 5.2.1 (separating
// axes).
#include "engine/narrow_phase/distance.h"

#include "base/limits.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// A shape in the world: a hull of 1..16 vertices and a radius around it.
struct Placed {
  Vec2 vertices[limits::polygon_vertex_count_max];
  Vec2 normals[limits::polygon_vertex_count_max];
  std::uint32_t count;
  Real radius;

  std::uint32_t next(std::uint32_t i) const { return i + 1 < count ? i + 1 : 0; }
};

Placed place(const Model& model, const ShapeModel& shape, const Pose& pose) {
  Placed out;
  out.radius = shape.radius;
  if (shape.vertex_count == 0) {
    out.count = 1;
    out.vertices[0] = pose.position + rotate(pose.rotation, shape.center);
    return out;
  }
  out.count = shape.vertex_count;
  for (std::uint32_t i = 0; i < out.count; ++i) {
    out.vertices[i] = pose.position + rotate(pose.rotation, model.vertices[shape.first_vertex + i]);
    out.normals[i] = rotate(pose.rotation, model.normals[shape.first_vertex + i]);
  }
  return out;
}

/// The edge of `a` beyond which `b` lies farthest out. Normal from a to b. Only for hulls with edges.
Distance axis_of(const Placed& a, const Placed& b) {
  Distance best;
  for (std::uint32_t i = 0; i < a.count; ++i) {
    const Vec2 normal = a.normals[i];
    std::uint32_t deepest = 0;
    Real least = dot(normal, b.vertices[0] - a.vertices[i]);
    for (std::uint32_t j = 1; j < b.count; ++j) {
      const Real along = dot(normal, b.vertices[j] - a.vertices[i]);
      if (along < least) {
        least = along;
        deepest = j;
      }
    }
    if (i == 0 || least > best.separation) best = {least, normal, b.vertices[deepest] - (Real(0.5) * least) * normal};
  }
  return best;
}

/// The nearest points of a vertex of `b` and an edge (or the only vertex) of `a`, if nearer than `best`.
void nearest(const Placed& a, const Placed& b, bool flipped, Real& best_squared, Vec2& on_a, Vec2& on_b) {
  const std::uint32_t edge_count = a.count > 2 ? a.count : 1;
  for (std::uint32_t j = 0; j < b.count; ++j)
    for (std::uint32_t i = 0; i < edge_count; ++i) {
      const Vec2 start = a.vertices[i];
      const Vec2 along = a.vertices[a.next(i)] - start;
      const Real size = length_squared(along);
      const Real t = size > 0 ? dot(b.vertices[j] - start, along) / size : Real(0);
      const Vec2 point = start + (t < 0 ? Real(0) : (t > 1 ? Real(1) : t)) * along;
      const Real squared = length_squared(b.vertices[j] - point);
      if (!(squared < best_squared)) continue;
      best_squared = squared;
      (flipped ? on_b : on_a) = point;
      (flipped ? on_a : on_b) = b.vertices[j];
    }
}

}  // namespace

Distance distance(const Model& model, const ShapeModel& shape_a, const Pose& pose_a, const ShapeModel& shape_b,
                  const Pose& pose_b) {
  const Placed a = place(model, shape_a, pose_a);
  const Placed b = place(model, shape_b, pose_b);
  const Real radius = a.radius + b.radius;
  Distance best;
  bool has_axis = false;
  if (a.count > 2) {
    best = axis_of(a, b);
    has_axis = true;
  }
  if (b.count > 2) {
    Distance axis = axis_of(b, a);
    axis.normal = -axis.normal;
    if (!has_axis || axis.separation > best.separation) best = axis;
    has_axis = true;
  }
  if (!has_axis || best.separation > 0) {
    Vec2 on_a = a.vertices[0];
    Vec2 on_b = b.vertices[0];
    Real squared = length_squared(on_b - on_a);
    nearest(a, b, false, squared, on_a, on_b);
    nearest(b, a, true, squared, on_a, on_b);
    const Real gap = square_root(squared);
    if (gap > 0) {
      best.separation = gap;
      best.normal = (1 / gap) * (on_b - on_a);
    } else if (!has_axis) {
      best = {0, a.count > 1 ? a.normals[0] : Vec2{0, 1}, on_a};
    }
    best.point = Real(0.5) * (on_a + on_b);
  }
  // The point midway between the two surfaces.
  best.point = best.point + (Real(0.5) * (a.radius - b.radius)) * best.normal;
  best.separation = best.separation - radius;
  return best;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
