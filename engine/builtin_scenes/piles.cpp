// Built-in scenes of many bodies that fall together.
// SPDX-License-Identifier: MIT
#include "base/random.h"
#include "engine/builtin_scenes/families.h"
#include "engine/builtin_scenes/pieces.h"
#include "engine/math/trig.h"

namespace ticktrue::engine {
const std::array<SceneParameter, 5> circles_parameters{{
    {"columns", 20, 1, 200, true, "circles in a row"},
    {"rows", 10, 1, 400, true, "rows"},
    {"radius", 0.5, 0.001, 100, false, "of each circle, m"},
    {"jitter", 0.05, 0, 0.1, false, "largest sideways shift, in radii"},
    {"seed", 1, 0, seed_max, true, "of the shifts"},
}};
Scene build_circles(const SceneArguments& arguments) {
  const int column_count = arguments.whole("columns");
  const int row_count = arguments.whole("rows");
  const double radius = arguments.real("radius");
  const double jitter = arguments.real("jitter") * radius;
  const double pitch = 2.2 * radius;
  Random random(arguments.seed());
  // The container, too, is made of circles a radius apart, so that only pairs of circles touch.
  const double left = -pitch * column_count / 2 - radius;
  const auto row_of_circles = [&](const char* name, Point first, Point step, int count) {
    Body row = static_body(name, first, circle(radius));
    for (int i = 1; i < count; ++i) row.shapes.push_back(circle(radius, {i * step.x, i * step.y}));
    return row;
  };
  const int floor_count = static_cast<int>(-2 * left / radius + 1.5);
  const int wall_count = static_cast<int>((row_count + 1) * pitch / radius + 0.5);
  Scene scene;
  scene.bodies.push_back(row_of_circles("floor", {left, -radius}, {radius, 0}, floor_count));
  scene.bodies.push_back(row_of_circles("wall_left", {left, 0}, {0, radius}, wall_count));
  scene.bodies.push_back(row_of_circles("wall_right", {-left, 0}, {0, radius}, wall_count));
  for (int row = 0; row < row_count; ++row)
    for (int column = 0; column < column_count; ++column) {
      const double shift = random.real(-jitter, jitter);
      const Point position{left + radius + (column + 0.5) * pitch + shift, (row + 0.5) * pitch};
      scene.bodies.push_back(dynamic_body("circle", scene.bodies.size(), position, circle(radius)));
    }
  return scene;
}

const std::array<SceneParameter, 2> mixed_pile_parameters{{
    {"bodies", 100, 1, 100'000, true, "circles, boxes and polygons together"},
    {"seed", 1, 0, seed_max, true, "of shapes, sizes and angles"},
}};
Scene build_mixed_pile(const SceneArguments& arguments) {
  const int count = arguments.whole("bodies");
  const double pitch = 1.5;  // no shape reaches farther than 0.75 m from its centre
  int column_count = 1;
  while (column_count * column_count < count) ++column_count;
  const double half_width = pitch * column_count / 2;
  const double half_height = half_width + 2;
  Random random(arguments.seed());
  Scene scene;
  scene.bodies.push_back(static_body("floor", {0, -0.5}, box(half_width + 1, 0.5)));
  scene.bodies.push_back(static_body("wall_left", {-half_width - 0.5, half_height}, box(0.5, half_height)));
  scene.bodies.push_back(static_body("wall_right", {half_width + 0.5, half_height}, box(0.5, half_height)));
  for (int i = 0; i < count; ++i) {
    const int column = i % column_count;
    const int row = i / column_count;
    const Point position{(column + 0.5) * pitch - half_width, (row + 0.5) * pitch};
    const std::size_t number = scene.bodies.size();
    switch (random.below(3)) {
      case 0:
        scene.bodies.push_back(dynamic_body("circle", number, position, circle(random.real(0.25, 0.5))));
        break;
      case 1: {
        const double half_x = random.real(0.2, 0.5);
        const double half_y = random.real(0.2, 0.5);
        scene.bodies.push_back(dynamic_body("box", number, position, box(half_x, half_y)));
        break;
      }
      default: {
        // Distinct angles on a circle give a convex polygon.
        const int vertex_count = 3 + static_cast<int>(random.below(6));
        const double radius = random.real(0.3, 0.6);
        std::vector<Point> vertices;
        for (int k = 0; k < vertex_count; ++k) {
          const SinCos direction = sin_cos(2 * pi * (k + random.real(-0.3, 0.3)) / vertex_count);
          vertices.push_back({radius * direction.cos, radius * direction.sin});
        }
        scene.bodies.push_back(dynamic_body("polygon", number, position, polygon(std::move(vertices))));
        break;
      }
    }
    scene.bodies.back().angle = random.real(-pi, pi);
  }
  return scene;
}

const std::array<SceneParameter, 2> shapes_parameters{{
    {"bodies", 60, 1, 100'000, true, "circles, capsules, boxes and polygons, sharp and rounded"},
    {"seed", 1, 0, seed_max, true, "of shapes, sizes and angles"},
}};
Scene build_shapes(const SceneArguments& arguments) {
  const int count = arguments.whole("bodies");
  const double pitch = 1.5;  // no shape reaches farther than 0.75 m from its centre
  int column_count = 1;
  while (column_count * column_count < count) ++column_count;
  const double half_width = pitch * column_count / 2 + 1;
  const double top = pitch * column_count + 4;
  Random random(arguments.seed());
  Scene scene;
  // A chain from the top right down, along a bumpy floor to the left and up: its right side is the inside.
  std::vector<Point> tub{{half_width, top}};
  const int step_count = 4 * column_count;
  for (int i = 0; i <= step_count; ++i)
    tub.push_back({half_width - 2 * half_width * i / step_count, random.real(-0.2, 0.2)});
  tub.push_back({-half_width, top});
  scene.bodies.push_back(static_body("tub", {}, line(ShapeKind::chain, std::move(tub))));
  const double shelf = half_width / 2;
  scene.bodies.push_back(static_body("shelf", {}, line(ShapeKind::segment, {{-shelf, 1.5}, {0, 1}})));
  for (int i = 0; i < count; ++i) {
    const double x = (i % column_count + 0.5) * pitch - half_width + 1;
    const int row = i / column_count;
    const Point position{x, (row + 1.5) * pitch};
    const std::size_t number = scene.bodies.size();
    const double size = random.real(0.2, 0.5);
    const double half = 0.7 * size;
    Shape shape;
    switch (i % 6) {
      case 0:
        scene.bodies.push_back(dynamic_body("circle", number, position, circle(size)));
        break;
      case 1:
        shape = line(ShapeKind::capsule, {{-half, 0}, {half, 0}}, 0.25);
        scene.bodies.push_back(dynamic_body("capsule", number, position, shape));
        break;
      case 2:
        scene.bodies.push_back(dynamic_body("box", number, position, box(size, half)));
        break;
      case 3:
        shape = box(half, 0.5 * half);
        shape.radius = 0.1;
        scene.bodies.push_back(dynamic_body("rounded_box", number, position, shape));
        break;
      default: {
        const int vertex_count = 3 + static_cast<int>(random.below(6));
        for (int k = 0; k < vertex_count; ++k) {
          const SinCos direction = sin_cos(2 * pi * (k + random.real(-0.3, 0.3)) / vertex_count);
          shape.vertices.push_back({size * direction.cos, size * direction.sin});
        }
        shape = polygon(std::move(shape.vertices));
        if (i % 6 == 5) shape.radius = 0.1;
        scene.bodies.push_back(dynamic_body(i % 6 == 5 ? "rounded_polygon" : "polygon", number, position, shape));
        break;
      }
    }
    scene.bodies.back().angle = random.real(-pi, pi);
  }
  return scene;
}

}  // namespace ticktrue::engine
