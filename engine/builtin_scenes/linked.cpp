// Built-in scenes with joints.
// SPDX-License-Identifier: MIT
#include "engine/builtin_scenes/families.h"
#include "engine/builtin_scenes/pieces.h"
#include "engine/math/trig.h"

namespace ticktrue::engine {
const std::array<SceneParameter, 1> pendulum_parameters{{
    {"angle", pi / 3, -pi, pi, false, "at the start, from hanging down, rad"},
}};
Scene build_pendulum(const SceneArguments& arguments) {
  const SinCos turn = sin_cos(arguments.real("angle"));
  Scene scene;
  scene.bodies.push_back(static_body("pivot", {}, circle(0.05)));
  scene.bodies.push_back(body("bob", BodyType::dynamic_body, {turn.sin, -turn.cos}, circle(0.1)));
  scene.bodies[1].mass = ExplicitMass{1, {}, {}};
  Joint rod;
  rod.name = "rod";
  rod.kind = JointKind::distance;
  rod.body_b = 1;
  rod.length = 1;
  scene.joints.push_back(std::move(rod));
  return scene;
}

const std::array<SceneParameter, 3> chain_parameters{{
    {"links", 20, 1, 1000, true, "links of 1 m and 1 kg"},
    {"angle", 0, -pi, pi, false, "at the start, from hanging down, rad"},
    {"end_mass", 1, 1e-6, 1e6, false, "of the last link, kg"},
}};
Scene build_chain(const SceneArguments& arguments) {
  const int count = arguments.whole("links");
  const double angle = arguments.real("angle");
  const SinCos turn = sin_cos(angle);
  Scene scene;
  scene.bodies.push_back(static_body("peg", {}, circle(0.1)));
  for (int i = 0; i < count; ++i) {
    const double along = i + 0.5;
    scene.bodies.push_back(
        dynamic_body("link", scene.bodies.size(), {along * turn.sin, -along * turn.cos}, box(0.1, 0.5)));
    Body& link = scene.bodies.back();
    link.angle = angle;
    link.mass = ExplicitMass{i + 1 < count ? 1 : arguments.real("end_mass"), {}, {}};
    const std::size_t last = scene.bodies.size() - 1;
    pin(scene, last - 1, i == 0 ? Point{} : Point{0, -0.5}, last, {0, 0.5});
  }
  return scene;
}

const std::array<SceneParameter, 1> bridge_parameters{{
    {"planks", 30, 1, 1000, true, "planks of 1 m between two pegs"},
}};
Scene build_bridge(const SceneArguments& arguments) {
  const int count = arguments.whole("planks");
  Shape plank = box(0.5, 0.125);
  plank.density = 20;
  Scene scene;
  scene.bodies.push_back(static_body("peg_left", {-0.5 * count, 0}, circle(0.125)));
  for (int i = 0; i < count; ++i) {
    scene.bodies.push_back(dynamic_body("plank", scene.bodies.size(), {i + 0.5 - 0.5 * count, 0}, plank));
    scene.bodies.back().linear_damping = 0.1;
    scene.bodies.back().angular_damping = 0.1;
    const std::size_t last = scene.bodies.size() - 1;
    pin(scene, last - 1, i == 0 ? Point{} : Point{0.5, 0}, last, {-0.5, 0});
  }
  scene.bodies.push_back(static_body("peg_right", {0.5 * count, 0}, circle(0.125)));
  pin(scene, scene.bodies.size() - 2, {0.5, 0}, scene.bodies.size() - 1, {});
  return scene;
}

const std::array<SceneParameter, 1> joint_grid_parameters{{
    {"columns", 100, 2, 200, true, "discs in a row, and rows"},
}};
Scene build_joint_grid(const SceneArguments& arguments) {
  const int count = arguments.whole("columns");
  Scene scene;
  for (int column = 0; column < count; ++column)
    for (int row = 0; row < count; ++row) {
      const Point position{static_cast<double>(column), static_cast<double>(-row)};
      const auto is_peg = [&](int at) { return row == 0 && 2 * at >= count - 6 && 2 * at <= count + 6; };
      const bool holds = is_peg(column);
      const std::size_t number = scene.bodies.size();
      const std::string name = (holds ? "peg_" : "disc_") + std::to_string(number);
      scene.bodies.push_back(body(name, holds ? BodyType::static_body : BodyType::dynamic_body, position, circle(0.4)));
      scene.bodies.back().shapes[0].filter = {2, 0xfffffffd, 0};  // grid bodies do not touch each other
      if (row > 0) pin(scene, number - 1, {0, -0.5}, number, {0, 0.5});
      if (column > 0 && !(holds && is_peg(column - 1)))  // two pegs need no joint
        pin(scene, number - static_cast<std::size_t>(count), {0.5, 0}, number, {-0.5, 0});
    }
  return scene;
}

}  // namespace ticktrue::engine
