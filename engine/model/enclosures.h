// Circles and boxes around shapes with their margins.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model/margins.h"
#include "engine/model/model.h"
#include "engine/model/state.h"
#include "engine/simd/realx4.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The bounding circle of a proxy in this tick.
struct Circle {
  Vec2 center;  // world, m
  Real radius;  // with margin, m
};

/// The margin around a shape, besides its swept displacement: the speculative margin plus the rounding of coordinates
/// at this distance from the origin. No broad phase can then miss a pair that another one finds.
inline Real margin_around(Vec2 center, const ShapeModel& shape, Real gravity_displacement) {
  const Real extent = larger(magnitude(center.x), magnitude(center.y)) + shape.bounding_radius;
  return speculative_margin(shape.size, gravity_displacement) + 16 * epsilon * extent;
}

/// The circle and the box around a shape of a body with its margin and its swept displacement in this tick
/// (swept_displacement_of). If the narrow phase finds contact points, circles and boxes of the two shapes overlap.
/// `gravity_displacement`: gravity_displacement_of_tick.
inline Circle circle_around(const BodyRow& body, const ShapeModel& shape, Real gravity_displacement, Real swept) {
  const Vec2 center = body.position + rotate(body.rotation, shape.center);
  return {center, (shape.bounding_radius + margin_around(center, shape, gravity_displacement)) + swept};
}
Box box_around_hull(const Model& model, const BodyRow& body, const ShapeModel& shape, Real gravity_displacement,
                    Real swept);
/// `lower`, `upper`: the corners of the box around the vertices, from the body's position.
inline Box box_between(const BodyRow& body, const ShapeModel& shape, Vec2 lower, Vec2 upper, Real gravity_displacement,
                       Real swept) {
  const Vec2 center = body.position + rotate(body.rotation, shape.center);
  const Real around = (shape.radius + margin_around(center, shape, gravity_displacement)) + swept;
  const Vec2 extent{around, around};
  return {(body.position + lower) - extent, (body.position + upper) + extent};
}
inline Box box_around_quad(const Quad& corners, const BodyRow& body, const ShapeModel& shape, Real gravity_displacement,
                           Real swept) {
  const Realx4 x = load_x4(corners.x);
  const Realx4 y = load_x4(corners.y);
  const Rotation q = body.rotation;
  const Realx4 rotated_x = q.c * x - q.s * y;
  const Realx4 rotated_y = q.s * x + q.c * y;
  return box_between(body, shape, {smallest_lane(rotated_x), smallest_lane(rotated_y)},
                     {largest_lane(rotated_x), largest_lane(rotated_y)}, gravity_displacement, swept);
}
inline Box box_around(const Model& model, const BodyRow& body, const ShapeModel& shape, Real gravity_displacement,
                      Real swept) {
  if (shape.quad != no_quad) return box_around_quad(model.quads[shape.quad], body, shape, gravity_displacement, swept);
  if (shape.family != ShapeFamily::circle) return box_around_hull(model, body, shape, gravity_displacement, swept);
  const Circle circle = circle_around(body, shape, gravity_displacement, swept);
  const Vec2 extent{circle.radius, circle.radius};
  return {circle.center - extent, circle.center + extent};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
