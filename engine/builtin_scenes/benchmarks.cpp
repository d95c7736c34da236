// Built-in scenes for timing: the benchmarks of Box2D 3 that are not elsewhere, a gas and a crowd of free bodies.
// SPDX-License-Identifier: MIT
// Source: geometry of tumbler, smash, spinner and rain: the benchmarks of Box2D 3 (names, measures, materials).
#include "base/random.h"
#include "engine/builtin_scenes/families.h"
#include "engine/builtin_scenes/pieces.h"
#include "engine/math/trig.h"

namespace ticktrue::engine {
namespace {

constexpr double unlimited_torque = 1e9;  // N m

/// A static body that touches nothing, for joints to the world.
Body axle(Point position) {
  Body result = static_body("axle", position, circle(0.1));
  result.shapes[0].filter.mask = 0;
  return result;
}

Joint& drive(Scene& scene, std::size_t a, Point anchor_a, std::size_t b, double speed, double torque_max) {
  Joint& joint = pin(scene, a, anchor_a, b, {});
  joint.motor = JointMotor{speed, torque_max};
  return joint;
}

}  // namespace

const std::array<SceneParameter, 1> tumbler_parameters{{
    {"columns", 45, 1, 70, true, "boxes in a row, and rows"},
}};
Scene build_tumbler(const SceneArguments& arguments) {
  const int count = arguments.whole("columns");
  Scene scene;
  scene.settings.sleep.emplace();
  scene.bodies.push_back(axle({}));
  Body drum = body("drum", BodyType::dynamic_body, {0, 10}, box(0.5, 10, {10, 0}));
  drum.shapes.push_back(box(0.5, 10, {-10, 0}));
  drum.shapes.push_back(box(10, 0.5, {0, 10}));
  drum.shapes.push_back(box(10, 0.5, {0, -10}));
  for (Shape& wall : drum.shapes) wall.density = 50;
  scene.bodies.push_back(std::move(drum));
  drive(scene, 0, {0, 10}, 1, 25 * pi / 180, 1e8);
  const double pitch = count > 45 ? 18.0 / count : 0.4;
  for (int row = 0; row < count; ++row)
    for (int column = 0; column < count; ++column) {
      const Point position{(column - 0.5 * count) * pitch, (row - 0.5 * count) * pitch + 10};
      scene.bodies.push_back(dynamic_body("box", scene.bodies.size(), position, box(0.125, 0.125)));
    }
  return scene;
}

const std::array<SceneParameter, 2> smash_parameters{{
    {"columns", 120, 1, 400, true, "boxes in a row of the wall"},
    {"rows", 80, 1, 200, true, "rows of the wall"},
}};
Scene build_smash(const SceneArguments& arguments) {
  const int row_count = arguments.whole("rows");
  const double edge = 0.4;
  Scene scene;
  scene.gravity = {0, 0};
  if (arguments.solver != SolverKind::impulse) scene.settings.sleep.emplace();
  scene.bodies.push_back(body("ram", BodyType::dynamic_body, {-20, 0}, box(4, 4)));
  scene.bodies[0].velocity = {40, 0};
  scene.bodies[0].shapes[0].density = 8;
  for (int column = 0; column < arguments.whole("columns"); ++column)
    for (int row = 0; row < row_count; ++row) {
      const Point position{column * edge + 30, (row - 0.5 * row_count) * edge};
      scene.bodies.push_back(dynamic_body("box", scene.bodies.size(), position, box(edge / 2, edge / 2)));
    }
  return scene;
}

const std::array<SceneParameter, 1> spinner_parameters{{
    {"bodies", 6076, 1, 10'000, true, "capsules, circles and boxes in turn"},
}};
Scene build_spinner(const SceneArguments& arguments) {
  Scene scene;
  scene.settings.sleep.emplace();
  std::vector<Point> rim;
  for (int i = 0; i < 360; ++i) {
    const SinCos turn = sin_cos(2 * pi * i / 360);
    rim.push_back({40 * turn.cos, 32 - 40 * turn.sin});
  }
  Shape ring = with(line(ShapeKind::chain, std::move(rim)), 0.1, 0);
  ring.loop = true;
  scene.bodies.push_back(static_body("ring", {}, std::move(ring)));
  Shape bar = with(box(0.4, 20), 0, 0);
  bar.radius = 0.2;
  scene.bodies.push_back(body("spinner", BodyType::dynamic_body, {0, 12}, std::move(bar)));
  scene.bodies.back().can_sleep = false;
  drive(scene, 0, {0, 12}, 1, 5, unlimited_torque);
  const Shape pieces[] = {line(ShapeKind::capsule, {{-0.25, 0}, {0.25, 0}}, 0.25), circle(0.35), box(0.35, 0.35)};
  const char* const names[] = {"capsule", "circle", "box"};
  const int column_count = 92;
  for (int i = 0; i < arguments.whole("bodies"); ++i) {
    const int row = i / column_count;
    const Point position{-23 + 0.5 * (i % column_count), 2 + 0.5 * row};
    scene.bodies.push_back(dynamic_body(names[i % 3], scene.bodies.size(), position, with(pieces[i % 3], 0.1, 0.1)));
    scene.bodies.back().shapes[0].density = 0.25;
  }
  return scene;
}

namespace {

/// A part of a figure of about 1.6 m: a capsule along y with a revolute joint to the part from which it hangs.
struct Bone {
  const char* name;
  int parent;     // -1: none
  double height;  // of the body's origin above the feet, m
  double lower;   // ends of the capsule, from the origin, m
  double upper;
  double radius;     // m
  double damping;    // 1/s
  double pivot;      // height of the revolute joint, m
  double angle_min;  // rad / pi
  double angle_max;
  double reference;  // rad / pi
  double friction;   // share of the joint's friction
  bool has_foot;
};
constexpr int bone_count = 11;
constexpr Bone bones[bone_count] = {
    {"hip", -1, 0.95, -0.02, 0.02, 0.095, 0, 0, 0, 0, 0, 0, false},
    {"torso", 0, 1.2, -0.135, 0.135, 0.09, 0, 1.0, -0.25, 0, 0, 0.5, false},
    {"head", 1, 1.475, -0.038, 0.039, 0.075, 0.1, 1.4, -0.3, 0.1, 0, 0.25, false},
    {"thigh_left", 0, 0.775, -0.125, 0.125, 0.06, 0, 0.9, -0.05, 0.4, 0, 1, false},
    {"shin_left", 3, 0.475, -0.155, 0.125, 0.045, 0, 0.625, -0.5, -0.02, 0, 0.5, true},
    {"thigh_right", 0, 0.775, -0.125, 0.125, 0.06, 0, 0.9, -0.05, 0.4, 0, 1, false},
    {"shin_right", 5, 0.475, -0.155, 0.125, 0.045, 0, 0.625, -0.5, -0.02, 0, 0.5, true},
    {"arm_left", 1, 1.225, -0.125, 0.125, 0.035, 0, 1.35, -0.1, 0.8, 0, 0.5, false},
    {"forearm_left", 7, 0.975, -0.125, 0.125, 0.03, 0.1, 1.1, -0.2, 0.3, 0.25, 0.1, false},
    {"arm_right", 1, 1.225, -0.125, 0.125, 0.035, 0, 1.35, -0.1, 0.8, 0, 0.5, false},
    {"forearm_right", 9, 0.975, -0.125, 0.125, 0.03, 0.1, 1.1, -0.2, 0.3, 0.25, 0.1, false},
};

/// The parts of one figure do not touch each other, nor other parts of their group; feet touch the ground alone.
void add_figure(Scene& scene, Point feet, int group, double spring_hertz) {
  const std::size_t first = scene.bodies.size();
  for (const Bone& bone : bones) {
    Shape limb = with(line(ShapeKind::capsule, {{0, bone.lower}, {0, bone.upper}}, bone.radius), 0.2, 0);
    limb.filter = {2, 1 | 2, -group};
    const std::size_t number = scene.bodies.size();
    scene.bodies.push_back(dynamic_body(bone.name, number, {feet.x, feet.y + bone.height}, limb));
    scene.bodies.back().linear_damping = bone.damping;
    if (bone.has_foot) {
      Shape foot = with(polygon({{-0.03, -0.185}, {0.11, -0.185}, {0.11, -0.16}, {-0.03, -0.14}}), 0.05, 0);
      foot.radius = 0.015;
      foot.filter = {2, 1, -group};
      scene.bodies.back().shapes.push_back(std::move(foot));
    }
    if (bone.parent < 0) continue;
    Joint& joint = pin(scene, first + static_cast<std::size_t>(bone.parent),
                       {0, bone.pivot - bones[bone.parent].height}, number, {0, bone.pivot - bone.height});
    joint.limits = Range{bone.angle_min * pi, bone.angle_max * pi};
    joint.reference_angle = bone.reference * pi;
    joint.motor = JointMotor{0, 0.05 * bone.friction};
    if (spring_hertz > 0) joint.spring = JointSpring{false, spring_hertz, 0.5, 0, 0};
  }
}

}  // namespace

const std::array<SceneParameter, 4> rain_parameters{{
    {"rows", 5, 1, 10, true, "floors above each other"},
    {"columns", 40, 1, 80, true, "groups of figures over a floor"},
    {"group", 5, 1, 10, true, "figures in a group"},
    {"spring", 0, 0, 60, false, "of the figures' joints, Hz; 0: none"},
}};
Scene build_rain(const SceneArguments& arguments) {
  const int column_count = arguments.whole("columns");
  const int tile_count = 500;
  const double tile = 0.5, span = tile * tile_count, floor_pitch = 45;
  Scene scene;
  scene.settings.sleep.emplace();
  for (int row = 0; row < arguments.whole("rows"); ++row) {
    Body floor =
        static_body("floor_" + std::to_string(row), {0, row * floor_pitch}, box(tile / 2, tile / 2, {-span / 2, 0}));
    for (int i = 1; i <= tile_count; ++i) floor.shapes.push_back(box(tile / 2, tile / 2, {i * tile - span / 2, 0}));
    scene.bodies.push_back(std::move(floor));
  }
  for (int column = 0; column < column_count; ++column)
    for (int row = 0; row < arguments.whole("rows"); ++row)
      for (int i = 0; i < arguments.whole("group"); ++i)
        add_figure(scene, {span * (column + 0.5) / column_count - span / 2 + 0.5 * i, 40 + row * floor_pitch}, i + 1,
                   arguments.real("spring"));
  return scene;
}

const std::array<SceneParameter, 3> gas_parameters{{
    {"bodies", 5000, 1, 100'000, true, "discs of 0.5 m"},
    {"speed", 5, 0, 100, false, "largest starting velocity along each axis, m/s"},
    {"seed", 1, 0, seed_max, true, "of the velocities"},
}};
Scene build_gas(const SceneArguments& arguments) {
  const int count = arguments.whole("bodies");
  const double pitch = 1, speed = arguments.real("speed");
  int column_count = 1;
  while (column_count * column_count < count) ++column_count;
  const double half = pitch * column_count / 2;
  Random random(arguments.seed());
  Scene scene;
  scene.gravity = {0, 0};
  const Shape along = with(box(half + 1, 0.5), 0, 1), across = with(box(0.5, half + 1), 0, 1);
  scene.bodies.push_back(static_body("wall_bottom", {0, -half - 0.5}, along));
  scene.bodies.push_back(static_body("wall_top", {0, half + 0.5}, along));
  scene.bodies.push_back(static_body("wall_left", {-half - 0.5, 0}, across));
  scene.bodies.push_back(static_body("wall_right", {half + 0.5, 0}, across));
  for (int i = 0; i < count; ++i) {
    const int row = i / column_count;
    const Point position{(i % column_count + 0.5) * pitch - half, (row + 0.5) * pitch - half};
    scene.bodies.push_back(dynamic_body("disc", scene.bodies.size(), position, with(circle(0.25), 0, 1)));
    const double vx = random.real(-speed, speed);
    scene.bodies.back().velocity = {vx, random.real(-speed, speed)};
  }
  return scene;
}

const std::array<SceneParameter, 3> loose_parameters{{
    {"bodies", 10'000, 1, 100'000, true, "boxes of 0.5 m, 4 m apart"},
    {"speed", 1, 0, 100, false, "largest starting velocity along each axis, m/s"},
    {"seed", 1, 0, seed_max, true, "of the velocities"},
}};
Scene build_loose(const SceneArguments& arguments) {
  const int count = arguments.whole("bodies");
  const double pitch = 4, speed = arguments.real("speed");
  int column_count = 1;
  while (column_count * column_count < count) ++column_count;
  Random random(arguments.seed());
  Scene scene;
  scene.gravity = {0, 0};
  for (int i = 0; i < count; ++i) {
    const int row = i / column_count;
    const Point position{(i % column_count) * pitch, row * pitch};
    scene.bodies.push_back(dynamic_body("box", scene.bodies.size(), position, box(0.25, 0.25)));
    const double vx = random.real(-speed, speed);
    scene.bodies.back().velocity = {vx, random.real(-speed, speed)};
    scene.bodies.back().angular_velocity = random.real(-1, 1);
  }
  return scene;
}

const std::array<SceneParameter, 2> resting_parameters{{
    {"bodies", 10'000, 1, 100'000, true, "boxes of 0.5 m that lie on the ground in stacks of four"},
    {"moving", 10, 0, 1000, true, "discs that go on bouncing beside them"},
}};
Scene build_resting(const SceneArguments& arguments) {
  const int count = arguments.whole("bodies");
  const int moving_count = arguments.whole("moving");
  const double pitch = 0.75;
  const int column_count = (count + 3) / 4;
  const double right = column_count * pitch + 1;
  Scene scene;
  if (arguments.solver != SolverKind::impulse) scene.settings.sleep.emplace();
  const double length = right + 2.0 * moving_count;
  scene.bodies.push_back(static_body("ground", {length / 2, -0.5}, with(box(length / 2 + 10, 0.5), 0.6, 1)));
  for (int i = 0; i < count; ++i) {
    const int column = i / 4;
    scene.bodies.push_back(
        dynamic_body("box", scene.bodies.size(), {column * pitch, (i % 4 + 0.5) * 0.5}, box(0.25, 0.25)));
  }
  // Only the ground and the discs bounce: boxes have no restitution, and the smaller restitution of a pair counts.
  scene.settings.restitution_mix = MixRule::minimum;
  for (int i = 0; i < moving_count; ++i)
    scene.bodies.push_back(
        dynamic_body("disc", scene.bodies.size(), {right + 2.0 * i, 5.0 + 0.1 * i}, with(circle(0.5), 0, 1)));
  return scene;
}

}  // namespace ticktrue::engine
