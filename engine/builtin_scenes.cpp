// The built-in scenes, their parameters, and how `name?key=value&key=value` is read.
// SPDX-License-Identifier: MIT
// Source: thesis scene: Claes, "Building a custom 2D physics engine in C++", 2024 (the set-up of its program);
// pyramids: geometry of the benchmarks of Box2D 3.
#include "engine/builtin_scenes.h"

#include <array>
#include <optional>
#include <utility>

#include "base/assert.h"
#include "base/limits.h"
#include "engine/geometry/hull.h"
#include "engine/math/random.h"
#include "engine/math/trig.h"
#include "engine/number_text.h"

namespace ticktrue::engine {

/// What was asked for: a value for each of the scene's own parameters, and the settings that were named.
struct SceneArguments {
  std::span<const SceneParameter> parameters;
  std::vector<double> values;  // [parameter]
  std::optional<Precision> precision;
  std::optional<double> dt;
  std::optional<int> substeps;
  bool auto_substeps = false;
  std::optional<int> sleep;  // 0 or 1, as the two below
  std::optional<int> locate_impacts;
  std::optional<int> continuous;
  std::optional<SolverKind> solver;
  std::optional<IntegratorKind> integrator;
  std::optional<BroadPhaseKind> broad_phase;
  std::optional<ClockKind> clock;
  std::optional<double> gravity;

  double real(std::string_view name) const {
    for (std::size_t i = 0; i < parameters.size(); ++i)
      if (parameters[i].name == name) return values[i];
    TICKTRUE_ASSERT(false && "a builder asks for a parameter that its row does not list");
    return 0;
  }
  int whole(std::string_view name) const { return static_cast<int>(real(name)); }
  /// Seeds are whole numbers up to 2^53.
  std::uint64_t seed() const { return static_cast<std::uint64_t>(real("seed")); }
};

namespace {

constexpr double seed_max = 9007199254740991;  // the largest run of whole numbers that doubles hold

// ---- Pieces ----

Shape circle(double radius, Point center = {}) {
  Shape shape;
  shape.kind = ShapeKind::circle;
  shape.radius = radius;
  shape.center = center;
  return shape;
}

Shape box(double half_width, double half_height, Point center = {}) {
  Shape shape;
  shape.kind = ShapeKind::box;
  shape.half_size = {half_width, half_height};
  shape.center = center;
  return shape;
}

Shape polygon(std::vector<Point> vertices) {
  Shape shape;
  shape.kind = ShapeKind::polygon;
  shape.vertices = std::move(vertices);
  return shape;
}

Shape with(Shape shape, double friction, double restitution) {
  shape.material = {friction, restitution};
  return shape;
}

Body body(std::string name, BodyType type, Point position, Shape shape) {
  Body result;
  result.name = std::move(name);
  result.type = type;
  result.position = position;
  result.shapes.push_back(std::move(shape));
  return result;
}

Body dynamic_body(const char* kind, std::size_t number, Point position, Shape shape) {
  return body(kind + ("_" + std::to_string(number)), BodyType::dynamic_body, position, std::move(shape));
}

Body static_body(std::string name, Point position, Shape shape) {
  return body(std::move(name), BodyType::static_body, position, std::move(shape));
}

/// Boxes of 1 m in a pyramid without gaps, the longest row at the bottom.
void add_pyramid(Scene& scene, int base, Point offset) {
  const double half = 0.5;
  for (int i = 0; i < base; ++i)
    for (int j = i; j < base; ++j) {
      const Point position{(i + 1) * half + 2 * (j - i) * half + offset.x, (2 * i + 1) * half + offset.y};
      scene.bodies.push_back(dynamic_body("box", scene.bodies.size(), position, box(half, half)));
    }
}

// ---- Scenes ----

/// The thesis measures in pixels with y down, 25 to the metre, in a window of 800 x 600.
Point thesis_point(double x_px, double y_px) {
  return {x_px / 25, (600 - y_px) / 25};
}
double thesis_length(double px) {
  return px / 25;
}

/// Six vertices at jittered angles, 20..50 px from the middle. The thesis takes whatever comes; here the first draw
/// that is a convex hexagon, always the same one.
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

Scene build_thesis(const SceneArguments& arguments) {
  Scene scene;
  scene.gravity = {0, -9.81};
  scene.settings.dt = 0.0167;
  scene.settings.friction_mix = MixRule::minimum;
  scene.settings.restitution_mix = MixRule::minimum;
  // The thesis lets every contact bounce. Its own solver keeps that; resting contacts of the others need a threshold.
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

constexpr std::array<SceneParameter, 4> stack_parameters{{
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

constexpr std::array<SceneParameter, 1> pyramid_parameters{{
    {"base", 20, 1, 600, true, "boxes in the lowest row"},
}};
Scene pyramid_of(int base) {
  Scene scene;
  scene.bodies.push_back(static_body("floor", {0, -1}, box(base > 100 ? base : 100, 1)));
  add_pyramid(scene, base, {-0.5 * base, 0});
  return scene;
}
Scene build_pyramid(const SceneArguments& arguments) {
  return pyramid_of(arguments.whole("base"));
}
Scene build_large_pyramid(const SceneArguments&) {
  return pyramid_of(100);
}

/// Tents of two leaning cards, their tops touching; from tent to tent a card lies across and carries the next floor.
/// Each lying card has an inner corner of either tent under its ends; half a millimetre stays between neighbours.
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

constexpr std::array<SceneParameter, 1> card_house_parameters{{
    {"tents", 5, 1, 30, true, "tents on the ground floor"},
}};
Scene build_card_house(const SceneArguments& arguments) {
  return card_house_of(arguments.whole("tents"));
}

constexpr std::array<SceneParameter, 2> many_pyramids_parameters{{
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
  // A floor is a box whose top lies where the benchmark has a segment; there are no segments yet.
  Body floors = static_body("floors", {}, box(width / 2, 0.25, {0, -0.25}));
  for (int row = 1; row < row_count; ++row) floors.shapes.push_back(box(width / 2, 0.25, {0, row * pitch - 0.25}));
  scene.bodies.push_back(std::move(floors));
  for (int row = 0; row < row_count; ++row)
    for (int column = 0; column < column_count; ++column)
      add_pyramid(scene, base, {-width / 2 + column * pitch + 1 - 0.5, row * pitch});
  return scene;
}

constexpr std::array<SceneParameter, 5> circles_parameters{{
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
  // The tub, too, is made of circles, a radius apart, so that only circles ever meet.
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

constexpr std::array<SceneParameter, 2> mixed_pile_parameters{{
    {"bodies", 100, 1, 100'000, true, "circles, boxes and polygons together"},
    {"seed", 1, 0, seed_max, true, "of shapes, sizes and angles"},
}};
Scene build_mixed_pile(const SceneArguments& arguments) {
  const int count = arguments.whole("bodies");
  const double pitch = 1.5;  // no shape reaches further than 0.75 m from its middle
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
        // Distinct angles on a circle: always convex.
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

constexpr std::array<SceneParameter, 2> projectile_parameters{{
    {"vx", 3, -1e6, 1e6, false, "starting velocity to the right, m/s"},
    {"vy", 7, -1e6, 1e6, false, "starting velocity upwards, m/s"},
}};
Scene build_projectile(const SceneArguments& arguments) {
  Scene scene;
  scene.settings.solver = SolverKind::free_flight;
  scene.bodies.push_back(body("ball", BodyType::dynamic_body, {}, circle(0.5)));
  scene.bodies[0].velocity = {arguments.real("vx"), arguments.real("vy")};
  return scene;
}

constexpr std::array<SceneParameter, 3> billiards_parameters{{
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

constexpr std::array<SceneParameter, 2> slide_parameters{{
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

Shape line(ShapeKind kind, std::vector<Point> points, double radius = 0) {
  Shape shape;
  shape.kind = kind;
  shape.vertices = std::move(points);
  shape.radius = radius;
  return shape;
}

constexpr std::array<SceneParameter, 2> shapes_parameters{{
    {"bodies", 60, 1, 100'000, true, "circles, capsules, boxes and polygons, sharp and rounded"},
    {"seed", 1, 0, seed_max, true, "of shapes, sizes and angles"},
}};
Scene build_shapes(const SceneArguments& arguments) {
  const int count = arguments.whole("bodies");
  const double pitch = 1.5;  // no shape reaches further than 0.75 m from its middle
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

constexpr std::array<SceneParameter, 2> sensors_parameters{{
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

// ---- Scenes with joints ----

/// Pins `b` to `a` at anchors in their frames. Bodies are indices.
void pin(Scene& scene, std::size_t a, Point anchor_a, std::size_t b, Point anchor_b) {
  Joint joint;
  joint.kind = JointKind::revolute;
  joint.body_a = static_cast<std::uint32_t>(a);
  joint.body_b = static_cast<std::uint32_t>(b);
  joint.anchor_a = anchor_a;
  joint.anchor_b = anchor_b;
  scene.joints.push_back(std::move(joint));
}

constexpr std::array<SceneParameter, 1> pendulum_parameters{{
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

constexpr std::array<SceneParameter, 3> chain_parameters{{
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

constexpr std::array<SceneParameter, 1> bridge_parameters{{
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

constexpr std::array<SceneParameter, 1> joint_grid_parameters{{
    {"columns", 20, 2, 200, true, "discs in a row, and rows"},
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
      scene.bodies.back().shapes[0].filter = {2, 0xfffffffd, 0};  // they touch nothing of their kind
      if (row > 0) pin(scene, number - 1, {0, -0.5}, number, {0, 0.5});
      if (column > 0 && !(holds && is_peg(column - 1)))  // two pegs need no pin
        pin(scene, number - static_cast<std::size_t>(count), {0.5, 0}, number, {-0.5, 0});
    }
  return scene;
}

const std::array<BuiltinScene, 17> scenes{{
    {"thesis",
     "the thesis' window: fixed disc, block, floor and walls; a mouse adds circles, boxes, polygons",
     {},
     build_thesis},
    {"stack", "boxes on top of each other", stack_parameters, build_stack},
    {"pyramid", "a pyramid of 1 m boxes", pyramid_parameters, build_pyramid},
    {"large_pyramid", "a pyramid of 5,050 boxes, as benchmarked in Box2D", {}, build_large_pyramid},
    {"many_pyramids", "400 pyramids of 55 boxes, as benchmarked in Box2D", many_pyramids_parameters,
     build_many_pyramids},
    {"circles", "a grid of circles falls into a tub made of circles", circles_parameters, build_circles},
    {"mixed_pile", "circles, boxes and polygons fall into a container", mixed_pile_parameters, build_mixed_pile},
    {"projectile", "one ball in free flight", projectile_parameters, build_projectile},
    {"billiards", "a disc hits fifteen, elastic and without friction", billiards_parameters, build_billiards},
    {"slide", "a box slides to rest", slide_parameters, build_slide},
    {"shapes", "every shape falls into a tub made of a chain", shapes_parameters, build_shapes},
    {"sensors", "balls fall through two sensors onto a conveyor; events are told", sensors_parameters, build_sensors},
    {"pendulum", "a disc on a rod of 1 m", pendulum_parameters, build_pendulum},
    {"chain", "links hang from a peg, or swing down", chain_parameters, build_chain},
    {"bridge", "planks pinned end to end between two pegs", bridge_parameters, build_bridge},
    {"joint_grid", "a net of discs hangs from seven of its own; columns=100 is benchmarked in Box2D",
     joint_grid_parameters, build_joint_grid},
    {"card_house", "thin cards lean against each other, floor upon floor", card_house_parameters, build_card_house},
}};

// ---- Reading `name?key=value` ----

constexpr std::array<std::string_view, 11> setting_names{
    "precision", "dt",    "substeps", "solver",         "integrator", "broad_phase",
    "gravity",   "clock", "sleep",    "locate_impacts", "continuous"};

Error usage(std::string_view text, const std::string& what, std::string hint = {}) {
  return Error{ErrorCode::usage, std::string(text) + ": " + what, std::move(hint)};
}

/// One number of a parameter: range and wholeness checked. `value` "1/60" counts as a quotient.
Result<double> read_number(std::string_view text, std::string_view key, std::string_view value, double min, double max,
                           bool whole) {
  const std::size_t slash = value.find('/');
  std::optional<double> number = parse_number(value.substr(0, slash));
  if (number && slash != std::string_view::npos) {
    const std::optional<double> below = parse_number(value.substr(slash + 1));
    number = below && *below > 0 ? std::optional(*number / *below) : std::nullopt;
  }
  const std::string expected = (whole ? "a whole number " : "") + number_text(min) + ".." + number_text(max);
  if (!number)
    return usage(text, std::string(key) + ": not a number: found \"" + std::string(value) + "\", expected " + expected);
  // The range comes first: only then does the conversion to an integer exist.
  if (!(*number >= min && *number <= max) ||
      (whole && static_cast<double>(static_cast<std::int64_t>(*number)) != *number))
    return usage(text, std::string(key) + ": out of range: found " + number_text(*number) + ", expected " + expected);
  return *number;
}

template <typename Table, typename Kind>
Status read_choice(std::string_view text, std::string_view key, std::string_view value, const Table& table,
                   std::optional<Kind>& out) {
  const auto* row = find_choice(table, value);
  if (row == nullptr)
    return usage(text,
                 std::string(key) + ": unknown: found \"" + std::string(value) + "\", expected " + choice_names(table));
  out = row->kind;
  return {};
}

Status read_argument(std::string_view text, std::string_view key, std::string_view value, SceneArguments& out) {
  const auto number = [&](double min, double max, bool whole, auto& target) -> Status {
    const Result<double> result = read_number(text, key, value, min, max, whole);
    if (!result) return result.error();
    target = static_cast<typename std::decay_t<decltype(target)>::value_type>(*result);
    return {};
  };
  if (key == "precision") return read_choice(text, key, value, precisions, out.precision);
  if (key == "dt") return number(limits::dt_min_s, limits::dt_max_s, false, out.dt);
  if (key == "substeps" && value == "auto") {
    out.auto_substeps = true;
    return {};
  }
  if (key == "substeps") return number(1, limits::substep_count_max, true, out.substeps);
  if (key == "solver") return read_choice(text, key, value, solvers, out.solver);
  if (key == "integrator") return read_choice(text, key, value, integrators, out.integrator);
  if (key == "broad_phase") return read_choice(text, key, value, broad_phases, out.broad_phase);
  if (key == "clock") return read_choice(text, key, value, clock_kinds, out.clock);
  if (key == "sleep") return number(0, 1, true, out.sleep);
  if (key == "locate_impacts") return number(0, 1, true, out.locate_impacts);
  if (key == "continuous") return number(0, 1, true, out.continuous);
  if (key == "gravity") return number(-limits::speed_max, limits::speed_max, false, out.gravity);
  std::string known;
  for (std::size_t i = 0; i < out.parameters.size(); ++i) {
    const SceneParameter& parameter = out.parameters[i];
    if (key == parameter.name) {
      const Result<double> result = read_number(text, key, value, parameter.min, parameter.max, parameter.whole);
      if (!result) return result.error();
      out.values[i] = *result;
      return {};
    }
    known += std::string(parameter.name) + ", ";
  }
  for (std::size_t i = 0; i < setting_names.size(); ++i)
    known += std::string(i == 0 ? "" : i + 1 == setting_names.size() ? " or " : ", ") + std::string(setting_names[i]);
  return usage(text, "unknown parameter: found \"" + std::string(key) + "\", expected " + known);
}

void apply_settings(const SceneArguments& arguments, Scene& scene) {
  Settings& settings = scene.settings;
  if (arguments.precision) settings.precision = *arguments.precision;
  if (arguments.dt) settings.dt = *arguments.dt;
  if (arguments.solver) settings.solver = *arguments.solver;
  if (!info_of(solvers, settings.solver).substeps) settings.substeps = 1;
  if (arguments.substeps) settings.substeps = *arguments.substeps;
  if (arguments.auto_substeps) settings.auto_substeps.emplace();
  if (arguments.sleep && *arguments.sleep == 1) settings.sleep.emplace();
  if (arguments.locate_impacts) settings.locate_impacts = *arguments.locate_impacts == 1;
  if (arguments.continuous) settings.continuous = *arguments.continuous == 1;
  if (arguments.integrator) settings.integrator = *arguments.integrator;
  if (arguments.broad_phase) settings.broad_phase = *arguments.broad_phase;
  if (arguments.clock) settings.clock.kind = *arguments.clock;
  if (arguments.gravity) scene.gravity = {0, 0 - *arguments.gravity};  // 0 - 0 is 0, not -0
}

}  // namespace

std::span<const BuiltinScene> builtin_scenes() {
  return scenes;
}
std::span<const std::string_view> scene_setting_names() {
  return setting_names;
}

Result<Scene> make_builtin_scene(std::string_view text) {
  if (text.size() > limits::name_size_max)
    return Error{ErrorCode::usage,
                 "scene: name too long: found " + std::to_string(text.size()) + " bytes, expected at most " +
                     std::to_string(limits::name_size_max),
                 ""};
  const std::size_t question = text.find('?');
  const std::string_view name = text.substr(0, question);
  const BuiltinScene* builtin = nullptr;
  std::string known;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (scenes[i].name == name) builtin = &scenes[i];
    known += std::string(i == 0 ? "" : i + 1 == scenes.size() ? " or " : ", ") + std::string(scenes[i].name);
  }
  if (builtin == nullptr)
    return usage(text, "no built-in scene has this name: found \"" + std::string(name) + "\", expected " + known,
                 "a scene of your own is the path of a JSON file");

  SceneArguments arguments;
  arguments.parameters = builtin->parameters;
  for (const SceneParameter& parameter : builtin->parameters) arguments.values.push_back(parameter.value);
  std::string_view rest = question == std::string_view::npos ? std::string_view() : text.substr(question + 1);
  std::vector<std::string_view> seen;
  while (!rest.empty()) {
    const std::size_t end = rest.find('&');
    const std::string_view part = rest.substr(0, end);
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos)
      return usage(text, "parameter without value: found \"" + std::string(part) + "\", expected key=value");
    const std::string_view key = part.substr(0, equals);
    for (const std::string_view other : seen)
      if (other == key) return usage(text, "parameter given twice: found \"" + std::string(key) + "\" again");
    seen.push_back(key);
    if (Status status = read_argument(text, key, part.substr(equals + 1), arguments); !status) return status.error();
  }

  Scene scene = builtin->build(arguments);
  scene.name = text;
  apply_settings(arguments, scene);
  if (Status status = check_scene(scene, std::string(text)); !status) return status.error();
  return scene;
}

}  // namespace ticktrue::engine
