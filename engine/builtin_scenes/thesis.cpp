// The scene of the thesis.
// SPDX-License-Identifier: MIT
// Source: Claes, "Building a custom 2D physics engine in C++", 2024 (the set-up of its program).
#include "base/random.h"
#include "engine/builtin_scenes/families.h"
#include "engine/builtin_scenes/pieces.h"
#include "engine/math/trig.h"
#include "engine/scene/hull.h"

namespace ticktrue::engine {
namespace {

/// The thesis measures in pixels with y down, 25 to the metre, in a window of 800 x 600.
Point thesis_point(double x_px, double y_px) {
  return {x_px / 25, (600 - y_px) / 25};
}
double thesis_length(double px) {
  return px / 25;
}

/// Six vertices at jittered angles, 20..50 px from the middle. The thesis accepts every draw; here the first draw that
/// is a convex hexagon is used, always the same one.
std::vector<Point> thesis_hexagon() {
  Random random(2024);
  for (;;) {
    std::vector<Point> vertices;
    for (int i = 0; i < 6; ++i) {
      const double angle = i * (pi / 3) + random.real(-pi / 6, pi / 6);
      const double radius = thesis_length(random.real(20, 50));
      const SinCos direction = sin_cos(angle);
      vertices.push_back({radius * direction.cos, radius * direction.sin});
    }
    if (auto hull = build_hull(vertices)) return *hull;
  }
}

}  // namespace

Scene build_thesis(const SceneArguments& arguments) {
  Scene scene;
  scene.gravity = {0, -9.81};
  scene.settings.dt = 0.0167;
  scene.settings.friction_mix = MixRule::minimum;
  scene.settings.restitution_mix = MixRule::minimum;
  // In the thesis every contact bounces. Its own solver does the same; the other solvers need a threshold for resting
  // contacts.
  if (arguments.solver == SolverKind::impulse) scene.settings.restitution_threshold = 0;

  scene.bodies.push_back(static_body("disc", thesis_point(200, 300), with(circle(thesis_length(50)), 0.5, 1)));
  scene.bodies.push_back(
      static_body("block", thesis_point(500, 300), with(box(thesis_length(50), thesis_length(50)), 0.5, 0.5)));
  scene.bodies.back().angle = -0.45 * pi;  // mirrored with the y axis
  scene.bodies.push_back(
      static_body("floor", thesis_point(400, 585), with(box(thesis_length(400), thesis_length(30)), 0.2, 0.8)));
  const Shape wall = with(box(thesis_length(30), thesis_length(300)), 0.2, 0.2);
  scene.bodies.push_back(static_body("wall_left", thesis_point(15, 255), wall));
  scene.bodies.push_back(static_body("wall_right", thesis_point(785, 255), wall));

  const auto prototype = [&](const char* name, Shape shape) {
    scene.prototypes.push_back(body(name, BodyType::dynamic_body, {}, std::move(shape)));
    scene.prototypes.back().mass = ExplicitMass{1, {}, {}};
  };
  prototype("circle", with(circle(thesis_length(15)), 0.5, 0.5));
  prototype("box", with(box(thesis_length(25), thesis_length(25)), 0.2, 0.1));
  prototype("polygon", with(polygon(thesis_hexagon()), 0.5, 0.5));

  scene.inputs = {InputKind::spawn, InputKind::remove,  InputKind::impulse, InputKind::press,
                  InputKind::drag,  InputKind::release, InputKind::end};
  scene.pointer.emplace();
  scene.pointer->spawns = {"circle", "box", "polygon"};
  scene.pointer->window = Bounds{{0, 0}, {32, 24}};
  scene.bounds = Bounds{{-8, -8}, {40, 40}};
  scene.spawned_max = 150;
  return scene;
}

const std::array<SceneParameter, 2> thesis_mix_parameters{{
    {"bodies", 150, 1, 20'000, true, "circles, boxes and polygons in turn"},
    {"seed", 1, 0, seed_max, true, "of their angles"},
}};
Scene build_thesis_mix(const SceneArguments& arguments) {
  const int count = arguments.whole("bodies");
  Scene scene = build_thesis(arguments);
  scene.inputs.clear();
  scene.pointer.reset();
  scene.bounds.reset();
  scene.spawned_max.reset();
  const std::vector<Body> kinds = std::move(scene.prototypes);
  scene.prototypes.clear();
  // The window holds 150 bodies. For more bodies the window grows; disc and block keep their places relative to its
  // lower left corner.
  int scale = 1;
  while (150 * scale * scale < count) ++scale;
  const double width = 32.0 * scale, height = 24.0 * scale;
  Shape& floor = scene.bodies[2].shapes[0];
  floor.half_size.x = width / 2;
  scene.bodies[2].position.x = width / 2;
  for (const std::size_t wall : {std::size_t{3}, std::size_t{4}}) {
    // The walls are three times as high as the window, so that bodies dropped above the window stay inside.
    scene.bodies[wall].shapes[0].half_size.y = 1.5 * height;
    scene.bodies[wall].position.y = 1.8 + 1.5 * height;
  }
  scene.bodies[4].position.x = width - 0.6;
  Random random(arguments.seed());
  const double pitch = 3.5;  // neighbours cannot overlap
  const int column_count = static_cast<int>((width - 4) / pitch);
  const double first_row = 16;  // above disc and block
  for (int i = 0; i < count; ++i) {
    Body body = kinds[static_cast<std::size_t>(i % 3)];
    body.name += "_" + std::to_string(scene.bodies.size());
    const int row = i / column_count;
    body.position = {3.5 + pitch * (i % column_count), first_row + pitch * row};
    body.angle = random.real(-pi, pi);
    scene.bodies.push_back(std::move(body));
  }
  return scene;
}

}  // namespace ticktrue::engine
