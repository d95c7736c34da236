// Built-in scenes of single motions: flight, impact, sliding, sensors.
// SPDX-License-Identifier: MIT
#include "engine/builtin_scenes/families.h"
#include "engine/builtin_scenes/pieces.h"

namespace ticktrue::engine {
const std::array<SceneParameter, 3> projectile_parameters{{
    {"vx", 3, -1e6, 1e6, false, "starting velocity to the right, m/s"},
    {"vy", 7, -1e6, 1e6, false, "starting velocity upwards, m/s"},
    {"bodies", 1, 1, 100'000, true, "balls side by side, which meet nothing"},
}};
Scene build_projectile(const SceneArguments& arguments) {
  Scene scene;
  scene.settings.solver = SolverKind::free_flight;
  scene.bodies.push_back(body("ball", BodyType::dynamic_body, {}, circle(0.5)));
  scene.bodies[0].velocity = {arguments.real("vx"), arguments.real("vy")};
  for (int i = 1; i < arguments.whole("bodies"); ++i) {
    scene.bodies[0].shapes[0].filter.mask = 0;
    scene.bodies.push_back(scene.bodies[0]);
    scene.bodies.back().name += "_" + std::to_string(i);
    scene.bodies.back().position.x = 2.0 * i;
  }
  return scene;
}

const std::array<SceneParameter, 3> billiards_parameters{{
    {"speed", 20, 0, 1000, false, "of the cue ball, m/s"},
    {"gap", 0.01, 0, 1, false, "between the racked balls, m"},
    {"walls", 0, 0, 1, true, "1: a table of 30 x 15 m with walls"},
}};
Scene build_billiards(const SceneArguments& arguments) {
  const double radius = 0.5;
  const double distance = 2 * radius + arguments.real("gap");
  const double row_distance = distance * __builtin_sqrt(3.0) / 2;
  Scene scene;
  scene.gravity = {0, 0};
  scene.settings.restitution_threshold = 0;
  const Shape ball = with(circle(radius), 0, 1);
  scene.bodies.push_back(body("cue", BodyType::dynamic_body, {-10, 0}, ball));
  scene.bodies[0].velocity = {arguments.real("speed"), 0};
  for (int row = 0; row < 5; ++row)
    for (int i = 0; i <= row; ++i) {
      const Point position{row * row_distance, (i - 0.5 * row) * distance};
      scene.bodies.push_back(dynamic_body("ball", scene.bodies.size(), position, ball));
    }
  if (arguments.whole("walls") == 1) {
    const Shape along = with(box(16, 0.5), 0, 1), across = with(box(0.5, 7.5), 0, 1);
    scene.bodies.push_back(static_body("wall_bottom", {0, -8}, along));
    scene.bodies.push_back(static_body("wall_top", {0, 8}, along));
    scene.bodies.push_back(static_body("wall_left", {-15.5, 0}, across));
    scene.bodies.push_back(static_body("wall_right", {15.5, 0}, across));
  }
  return scene;
}

const std::array<SceneParameter, 2> slide_parameters{{
    {"speed", 10, 0, 1000, false, "starting velocity to the right, m/s"},
    {"friction", 0.5, 0, 1000, false, "of box and floor"},
}};
Scene build_slide(const SceneArguments& arguments) {
  const double friction = arguments.real("friction");
  Scene scene;
  scene.bodies.push_back(static_body("floor", {0, -1}, with(box(100, 1), friction, 0)));
  scene.bodies.push_back(body("box", BodyType::dynamic_body, {0, 0.5}, with(box(0.5, 0.5), friction, 0)));
  scene.bodies[1].velocity = {arguments.real("speed"), 0};
  return scene;
}

const std::array<SceneParameter, 2> sensors_parameters{{
    {"bodies", 12, 1, 1000, true, "balls that fall, every other one unseen by the upper sensor"},
    {"conveyor", 2, -100, 100, false, "speed of the belt to the left, m/s"},
}};
Scene build_sensors(const SceneArguments& arguments) {
  const int count = arguments.whole("bodies");
  Scene scene;
  scene.settings.events = true;
  const double half_width = 0.75 * count + 2;
  scene.bodies.push_back(static_body("belt", {0, -0.5}, box(half_width, 0.5)));
  scene.bodies.back().shapes[0].material.tangent_speed = arguments.real("conveyor");
  const auto sensor = [&](const char* name, double height) {
    scene.bodies.push_back(static_body(name, {0, height}, box(half_width, 0.25)));
    scene.bodies.back().shapes[0].sensor = true;
  };
  sensor("upper", 4);
  scene.bodies.back().shapes[0].filter.mask = 1;
  sensor("lower", 2);
  for (int i = 0; i < count; ++i) {
    const Point position{1.5 * i - 0.75 * (count - 1), 5.5 + 0.25 * (i % 4)};
    scene.bodies.push_back(dynamic_body("ball", scene.bodies.size(), position, circle(0.4)));
    Shape& ball = scene.bodies.back().shapes[0];
    ball.material.rolling_resistance = 0.05;
    ball.filter.category = i % 2 == 0 ? 1 : 2;
  }
  scene.bounds = Bounds{{-half_width - 5, -20}, {half_width + 5, 20}};
  return scene;
}

}  // namespace ticktrue::engine
