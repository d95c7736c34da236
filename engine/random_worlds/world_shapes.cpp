// Shapes of random worlds: one maker for each kind.
// SPDX-License-Identifier: MIT
#include "engine/builtin_scenes/pieces.h"
#include "engine/random_worlds/world_builder.h"

namespace ticktrue::engine {
namespace {

/// A point of the unit circle with rational coordinates, computed without a library function.
Point on_circle(double slope) {
  const double below = 1 + slope * slope;
  return {(1 - slope * slope) / below, 2 * slope / below};
}

Shape make_circle(Draw&, double size) {
  return circle(size / 2);
}

Shape make_box(Draw& draw, double size) {
  const double height = draw.chance(60) ? size : size * draw.one_of({0.25, 0.5, 0.75, 1.5});
  return box(size / 2, height / 2);
}

/// Points of a circle are convex. Both signs of the slope and of x give all quarters.
Shape make_polygon(Draw& draw, double size) {
  const double radius = size / 2;
  if (draw.chance(25)) return polygon({{radius, -radius}, {0, radius}, {-radius, -radius}});
  const int steps = draw.between(1, 3);  // of each quarter
  std::vector<Point> vertices;
  for (int i = 0; i < steps; ++i) {
    const Point p = on_circle((draw.half() ? i : i + 0.25) / steps);
    // Four points, each the last one rotated by a quarter turn.
    for (const Point& q : {Point{p.x, p.y}, Point{-p.y, p.x}, Point{-p.x, -p.y}, Point{p.y, -p.x}})
      vertices.push_back({radius * q.x, radius * q.y});
  }
  return polygon(vertices);
}

Shape make_capsule(Draw& draw, double size) {
  const double radius = size * draw.one_of({0.125, 0.25, 0.375});
  const double half = size / 2 - radius;
  return draw.half() ? line(ShapeKind::capsule, {{-half, 0}, {half, 0}}, radius)
                     : line(ShapeKind::capsule, {{0, -half}, {0, half}}, radius);
}

Shape make_segment(Draw& draw, double size) {
  const double slope = size * draw.one_of({0, 0, 0.125, -0.25});
  return line(ShapeKind::segment, {{-size / 2, -slope}, {size / 2, slope}});
}

/// A chain from right to left, so that its right side is up.
Shape make_chain(Draw& draw, double size) {
  if (draw.chance(30)) {
    Shape loop = line(ShapeKind::chain, {{size / 2, 0}, {0, size / 2}, {-size / 2, 0}, {0, -size / 2}});
    loop.loop = true;
    return loop;
  }
  const int edge_count = draw.between(1, 6);
  std::vector<Point> points;
  for (int i = 0; i <= edge_count; ++i) {
    const double x = size * (0.5 - static_cast<double>(i) / edge_count);
    points.push_back({x, draw.half() ? 0 : size * draw.part(-4, 4, 32)});
  }
  return line(ShapeKind::chain, points);
}

struct ShapeMaker {
  ShapeKind kind;
  Shape (*make)(Draw& draw, double size);
};
constexpr std::array<ShapeMaker, shape_kinds.size()> shape_makers{{
    {ShapeKind::circle, make_circle},
    {ShapeKind::box, make_box},
    {ShapeKind::polygon, make_polygon},
    {ShapeKind::capsule, make_capsule},
    {ShapeKind::segment, make_segment},
    {ShapeKind::chain, make_chain},
}};
static_assert(rows_are_in_order(shape_makers), "a shape without its maker");

}  // namespace

Shape make_shape(Draw& draw, ShapeKind kind, double size) {
  return info_of(shape_makers, kind).make(draw, size);
}

}  // namespace ticktrue::engine
