// Built-in scenes of standing structures: stacks, pyramids, card houses.
// SPDX-License-Identifier: MIT
// Source: geometry of the pyramids: the benchmarks of Box2D 3.
#include "base/random.h"
#include "engine/builtin_scenes/families.h"
#include "engine/builtin_scenes/pieces.h"
#include "engine/math/trig.h"

namespace ticktrue::engine {
namespace {

/// Boxes of 1 m in a pyramid without gaps, the longest row at the bottom.
void add_pyramid(Scene& scene, int base, Point offset) {
  const double half = 0.5;
  for (int i = 0; i < base; ++i)
    for (int j = i; j < base; ++j) {
      const Point position{(i + 1) * half + 2 * (j - i) * half + offset.x, (2 * i + 1) * half + offset.y};
      scene.bodies.push_back(dynamic_body("box", scene.bodies.size(), position, box(half, half)));
    }
}

Scene pyramid_of(int base) {
  Scene scene;
  scene.bodies.push_back(static_body("floor", {0, -1}, box(base > 100 ? base : 100, 1)));
  add_pyramid(scene, base, {-0.5 * base, 0});
  return scene;
}

/// Builds tents of two leaning cards whose tops touch. A card lies across from tent to tent and carries the next floor.
/// An inner corner of either tent is under each end of a lying card. Neighbouring cards are half a millimetre apart.
Scene card_house_of(int base) {
  const double length = 0.4, thickness = 0.002, gap = 0.0005;
  const double lean = 25 * pi / 180;
  const SinCos turn = sin_cos(lean);
  const double half_width = (length * turn.sin + thickness * turn.cos) / 2;  // of a leaning card
  const double half_height = (length * turn.cos + thickness * turn.sin) / 2;
  const double pitch = length + gap;
  const Shape card = with(box(thickness / 2, length / 2), 0.7, 0);
  Scene scene;
  scene.bodies.push_back(static_body("floor", {0, -1}, with(box(10 + pitch * base, 1), 0.7, 0)));
  const auto add = [&](double x, double y, double angle) {
    scene.bodies.push_back(dynamic_body("card", scene.bodies.size(), {x, y}, card));
    scene.bodies.back().angle = angle;
  };
  for (int floor = 0; floor < base; ++floor) {
    const double bottom = floor * (2 * half_height + thickness);
    const int tent_count = base - floor;
    for (int tent = 0; tent < tent_count; ++tent) {
      const double x = (tent - 0.5 * (tent_count - 1)) * pitch;
      add(x - half_width, bottom + half_height, -lean);
      add(x + half_width, bottom + half_height, lean);
      if (tent + 1 < tent_count) add(x + pitch / 2, bottom + 2 * half_height + thickness / 2, pi / 2);
    }
  }
  return scene;
}

}  // namespace

const std::array<SceneParameter, 4> stack_parameters{{
    {"boxes", 10, 1, 1000, true, "boxes in the stack"},
    {"size", 1, 0.001, 1000, false, "edge of a box, m"},
    {"jitter", 0, 0, 1000, false, "largest sideways shift of a box, m"},
    {"seed", 1, 0, seed_max, true, "of the shifts"},
}};
Scene build_stack(const SceneArguments& arguments) {
  const int count = arguments.whole("boxes");
  const double size = arguments.real("size");
  const double jitter = arguments.real("jitter");
  Random random(arguments.seed());
  Scene scene;
  scene.bodies.push_back(static_body("floor", {0, -size}, box(20 * size + count * size, size)));
  for (int i = 0; i < count; ++i) {
    const Point position{random.real(-jitter, jitter), (i + 0.5) * size};
    scene.bodies.push_back(dynamic_body("box", scene.bodies.size(), position, box(size / 2, size / 2)));
  }
  return scene;
}

const std::array<SceneParameter, 1> pyramid_parameters{{
    {"base", 20, 1, 600, true, "boxes in the lowest row"},
}};

Scene build_pyramid(const SceneArguments& arguments) {
  return pyramid_of(arguments.whole("base"));
}
Scene build_large_pyramid(const SceneArguments&) {
  return pyramid_of(100);
}

const std::array<SceneParameter, 1> card_house_parameters{{
    {"tents", 5, 1, 30, true, "tents on the ground floor"},
}};
Scene build_card_house(const SceneArguments& arguments) {
  return card_house_of(arguments.whole("tents"));
}

const std::array<SceneParameter, 2> many_pyramids_parameters{{
    {"rows", 20, 1, 40, true, "floors above each other"},
    {"columns", 20, 1, 40, true, "pyramids on a floor"},
}};
Scene build_many_pyramids(const SceneArguments& arguments) {
  const int row_count = arguments.whole("rows");
  const int column_count = arguments.whole("columns");
  const int base = 10;
  const double pitch = base + 1;
  const double width = pitch * column_count;
  Scene scene;
  // The benchmark has a segment as floor. Here the top of a box takes its place.
  Body floors = static_body("floors", {}, box(width / 2, 0.25, {0, -0.25}));
  for (int row = 1; row < row_count; ++row) floors.shapes.push_back(box(width / 2, 0.25, {0, row * pitch - 0.25}));
  scene.bodies.push_back(std::move(floors));
  for (int row = 0; row < row_count; ++row)
    for (int column = 0; column < column_count; ++column)
      add_pyramid(scene, base, {-width / 2 + column * pitch + 1 - 0.5, row * pitch});
  return scene;
}

}  // namespace ticktrue::engine
