// The length scale at which Box2D simulates a scene.
// SPDX-License-Identifier: MIT
#include "tool/box2d/length_scale.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace ticktrue::tool {
namespace {

using engine::BodyType;
using engine::Point;
using engine::Shape;
using engine::ShapeKind;

// Box2D is tuned for moving bodies of 0.1 m to 10 m: slop 5 mm, skin 1 cm, bounce threshold 1 m/s.
constexpr double tuned_size_min_m = 0.1;
constexpr double tuned_size_max_m = 10;

}  // namespace

double extent_of(const Shape& shape) {
  switch (shape.kind) {
    case ShapeKind::circle:
      return 2 * shape.radius;
    case ShapeKind::box:
      return 2 * std::sqrt(shape.half_size.x * shape.half_size.x + shape.half_size.y * shape.half_size.y);
    case ShapeKind::polygon:
    case ShapeKind::capsule:
    case ShapeKind::segment:
    case ShapeKind::chain:
      break;
  }
  double extent = 0;
  for (const Point& a : shape.vertices)
    for (const Point& b : shape.vertices) extent = std::max(extent, std::hypot(a.x - b.x, a.y - b.y));
  return extent;
}

double choose_length_scale(const engine::Scene& scene) {
  std::vector<double> extents;
  for (const engine::Body& body : scene.bodies) {
    if (body.type != BodyType::dynamic_body) continue;
    double extent = 0;
    for (const Shape& shape : body.shapes) extent = std::max(extent, extent_of(shape));
    extents.push_back(extent);
  }
  if (extents.empty()) return 1;
  std::nth_element(extents.begin(), extents.begin() + static_cast<std::ptrdiff_t>(extents.size() / 2), extents.end());
  const double median = extents[extents.size() / 2];
  double scale = 1;
  if (median > tuned_size_max_m)
    while (median * scale > 2) scale /= 2;
  if (median < tuned_size_min_m)
    while (median * scale < 1) scale *= 2;
  return scale;
}

}  // namespace ticktrue::tool
