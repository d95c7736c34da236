// Boxes around hulls.
// SPDX-License-Identifier: MIT
#include "engine/model/enclosures.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

Box box_around_hull(const Model& model, const BodyRow& body, const ShapeModel& shape, Real gravity_displacement,
                    Real swept) {
  const Vec2* vertices = &model.vertices[shape.first_vertex];
  Vec2 lower = rotate(body.rotation, vertices[0]);
  Vec2 upper = lower;
  for (std::uint32_t i = 1; i < shape.vertex_count; ++i) {
    const Vec2 v = rotate(body.rotation, vertices[i]);
    lower = {smaller(lower.x, v.x), smaller(lower.y, v.y)};
    upper = {larger(upper.x, v.x), larger(upper.y, v.y)};
  }
  return box_between(body, shape, lower, upper, gravity_displacement, swept);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
