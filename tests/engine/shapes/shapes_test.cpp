// Every shape, filter, sensor, event and surface of the engine, against brute-force geometry and closed forms.
// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "base/random.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/engine.h"
#include "engine/math/trig.h"
#include "engine/scene/hull.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/scenes.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::BodyReport;
using engine::ContactReport;
using engine::Engine;

namespace {

// ---- Distance of two cores by brute force ----

struct Placed {
  std::vector<Point> core;  // world
  double radius;
};

Placed placed(const Body& body) {
  const engine::SinCos turn = engine::sin_cos(body.angle);
  Placed result{{}, body.shapes[0].radius};
  for (const Point& p : engine::core_of(body.shapes[0]))
    result.core.push_back(
        {body.position.x + turn.cos * p.x - turn.sin * p.y, body.position.y + turn.sin * p.x + turn.cos * p.y});
  return result;
}

struct Gap {
  double distance = 1e300;
  Point from_a;  // the vector from the closest point of A's core to that of B's
};

void look_at(Point p, Point a, Point b, double sign, Gap& gap) {
  const double ex = b.x - a.x, ey = b.y - a.y;
  const double whole = ex * ex + ey * ey;
  double share = whole > 0 ? ((p.x - a.x) * ex + (p.y - a.y) * ey) / whole : 0;
  share = std::fmin(std::fmax(share, 0), 1);
  const double dx = a.x + share * ex - p.x, dy = a.y + share * ey - p.y;
  const double distance = std::hypot(dx, dy);
  if (distance < gap.distance) gap = {distance, {sign * dx, sign * dy}};
}

// Requires: the cores are apart.
Gap gap_of(const Placed& a, const Placed& b) {
  Gap gap;
  for (const Point& p : a.core)
    for (std::size_t j = 0; j < b.core.size(); ++j) look_at(p, b.core[j], b.core[(j + 1) % b.core.size()], 1, gap);
  for (const Point& p : b.core)
    for (std::size_t i = 0; i < a.core.size(); ++i) look_at(p, a.core[i], a.core[(i + 1) % a.core.size()], -1, gap);
  return gap;
}

double rounded_to(Precision precision, double value) {
  return precision == Precision::f32 ? static_cast<double>(static_cast<float>(value)) : value;
}

std::vector<Point> random_hull(Random& random) {
  const int count = 3 + static_cast<int>(random.below(14));
  std::vector<Point> vertices;
  for (int i = 0; i < count; ++i) {
    const engine::SinCos at = engine::sin_cos(2 * engine::pi * (i + random.real(-0.3, 0.3)) / count);
    vertices.push_back({at.cos, at.sin});
  }
  return vertices;
}

constexpr int family_count = 5;  // circle, capsule, segment, rounded hull, sharp hull
Shape random_shape(int family, Random& random) {
  switch (family) {
    case 0:
      return disc_shape(random.real(0.3, 1));
    case 1:
      return capsule_shape({random.real(-1, -0.2), 0}, {random.real(0.2, 1), random.real(-1, 1)},
                           random.real(0.2, 0.6));
    case 2:
      return segment_shape({random.real(-2, -0.5), 0}, {random.real(0.5, 2), random.real(-1, 1)});
    default: {
      Shape shape = polygon_shape(random_hull(random));
      if (family == 3) shape.radius = random.real(0.1, 0.5);
      return shape;
    }
  }
}

Body with_mass(Body body) {
  body.mass = engine::ExplicitMass{1, 1.0, Point{0, 0}};
  return body;
}

std::vector<ContactReport> contacts_of(Precision precision, const Body& a, const Body& b) {
  Scene scene = empty_scene(precision);
  scene.bodies = {a, b};
  return make_engine_or_fail(scene)->contacts();
}

// Rows of a table of u32 columns.
template <std::size_t columns>
std::vector<std::array<std::uint32_t, columns>> rows_of(const Engine& engine, const char* table) {
  const StateView& state = engine.state();
  const auto index = state.schema->find_table(table);
  REQUIRE(index.has_value());
  REQUIRE(state.schema->tables[*index].row_size == 4 * columns);
  std::vector<std::array<std::uint32_t, columns>> rows(state.tables[*index].row_count);
  if (!rows.empty()) std::memcpy(rows.data(), state.tables[*index].data, rows.size() * 4 * columns);
  return rows;
}

// Points of a straight chain from right to left: its right side is up.
std::vector<Point> level_points(int edge_count, double edge_length) {
  std::vector<Point> points;
  for (int i = edge_count; i >= 0; --i) points.push_back({i * edge_length, 0});
  return points;
}

Body chain_ground(std::vector<Point> points) {
  return body_of(chain_shape(std::move(points)), {0, 0}, BodyType::static_body);
}

// The same edges as separate shapes.
Body segment_ground(const std::vector<Point>& points) {
  Body body = body_of(segment_shape(points[0], points[1]), {0, 0}, BodyType::static_body);
  for (std::size_t i = 1; i + 1 < points.size(); ++i) body.shapes.push_back(segment_shape(points[i], points[i + 1]));
  return body;
}

}  // namespace

TEST_CASE("contacts of disjoint shapes have the distance and direction of brute force, also when swapped",
          "[engine][shapes][analytic]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    const double limit = precision == Precision::f32 ? 1e-5 : 1e-12;
    Random random(11);
    int checked = 0;
    for (int trial = 0; trial < 1500; ++trial) {
      const int family_a = trial % family_count, family_b = trial / family_count % family_count;
      if (family_a == 2 && family_b == 2) continue;  // lines do not collide
      if (family_a == 4 && family_b == 4) continue;  // two sharp hulls have no rounding that could touch
      Body a = with_mass(body_of(random_shape(family_a, random), {random.real(-2, 2), random.real(-2, 2)}));
      Body b = with_mass(body_of(random_shape(family_b, random), {}));
      a.angle = random.real(-3, 3);
      b.angle = random.real(-3, 3);
      const engine::SinCos direction = engine::sin_cos(random.real(-3.1, 3.1));
      b.position = {a.position.x + 9 * direction.cos, a.position.y + 9 * direction.sin};
      // Moving B along the closest direction keeps the closest points and reduces the distance.
      const Gap far = gap_of(placed(a), placed(b));
      const double move = far.distance - a.shapes[0].radius - b.shapes[0].radius - random.real(0.0001, 0.003);
      b.position.x = rounded_to(precision, b.position.x - move * far.from_a.x / far.distance);
      b.position.y = rounded_to(precision, b.position.y - move * far.from_a.y / far.distance);
      a.position = {rounded_to(precision, a.position.x), rounded_to(precision, a.position.y)};

      const Gap near = gap_of(placed(a), placed(b));
      const double separation = near.distance - a.shapes[0].radius - b.shapes[0].radius;
      CAPTURE(precision, trial, family_a, family_b, separation);
      const std::vector<ContactReport> found = contacts_of(precision, a, b);
      REQUIRE(found.size() == 1);
      const ContactReport& contact = found[0];
      double least = contact.separation[0];
      if (contact.point_count == 2) least = std::fmin(least, contact.separation[1]);
      CHECK(std::fabs(least - separation) < limit);
      // The direction of cores nearer than rounding cannot be measured.
      const double direction_limit = 8 * limit / std::fmin(1, near.distance);
      CHECK(std::fabs(contact.normal.x - near.from_a.x / near.distance) < direction_limit);
      CHECK(std::fabs(contact.normal.y - near.from_a.y / near.distance) < direction_limit);

      const std::vector<ContactReport> swapped = contacts_of(precision, b, a);
      REQUIRE(swapped.size() == 1);
      CHECK(swapped[0].point_count == contact.point_count);
      CHECK(std::fabs(swapped[0].normal.x + contact.normal.x) < direction_limit);
      CHECK(std::fabs(swapped[0].normal.y + contact.normal.y) < direction_limit);
      double swapped_least = swapped[0].separation[0];
      if (swapped[0].point_count == 2) swapped_least = std::fmin(swapped_least, swapped[0].separation[1]);
      CHECK(std::fabs(swapped_least - least) < limit);
      ++checked;
    }
    CHECK(checked > 1000);
  }
}

TEST_CASE("a capsule lies and a rounded box stands at its radius above the ground", "[engine][shapes][analytic]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    const auto height_of = [&](Shape shape, double start) {
      Scene scene = empty_scene(precision);
      scene.bodies = {ground(), body_of(std::move(shape), {0, start})};
      const auto engine = make_engine_or_fail(scene);
      run_ticks(*engine, 120);
      const BodyReport body = engine->bodies()[1];
      CHECK(std::fabs(body.velocity.y) < 1e-3);
      CHECK(std::fabs(body.angle) < 1e-3);
      return body.center.y;
    };
    const double slop = 0.005 * 0.6;  // of the smallest shape
    CHECK(std::fabs(height_of(capsule_shape({-0.5, 0}, {0.5, 0}, 0.3), 0.3) - 0.3) < slop);
    Shape rounded = box_shape(0.4, 0.3);
    rounded.radius = 0.1;
    const double rounded_height = height_of(rounded, 0.4);
    CHECK(std::fabs(rounded_height - 0.4) < slop);
    CHECK(std::fabs(rounded_height - height_of(box_shape(0.5, 0.4), 0.4)) < slop);
  }
}

TEST_CASE("a body lies on a segment from either side and on a chain from its right side only",
          "[engine][shapes][analytic]") {
  const auto height_after_a_second = [](Body line, Shape shape) {
    Scene scene = empty_scene();
    scene.bodies = {std::move(line), body_of(std::move(shape), {2.5, 0.5})};
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 60);
    return engine->bodies()[1].center.y;
  };
  const std::vector<Point> to_left = level_points(5, 1);
  const std::vector<Point> to_right(to_left.rbegin(), to_left.rend());
  for (const Shape& shape : {disc_shape(0.5), box_shape(0.5, 0.5), capsule_shape({-0.2, 0}, {0.2, 0}, 0.5)}) {
    CHECK(std::fabs(height_after_a_second(segment_ground(to_left), shape) - 0.5) < 0.005);
    CHECK(std::fabs(height_after_a_second(segment_ground(to_right), shape) - 0.5) < 0.005);
    CHECK(std::fabs(height_after_a_second(chain_ground(to_left), shape) - 0.5) < 0.005);
    CHECK(height_after_a_second(chain_ground(to_right), shape) < -4);
  }
}

TEST_CASE("a counter-clockwise loop is solid, a clockwise one is a room", "[engine][shapes][analytic]") {
  const std::vector<Point> counter_clockwise{{-2, -2}, {2, -2}, {2, 2}, {-2, 2}};
  const std::vector<Point> clockwise(counter_clockwise.rbegin(), counter_clockwise.rend());
  const auto height_of = [](std::vector<Point> points, Point start) {
    Shape loop = chain_shape(std::move(points));
    loop.loop = true;
    Scene scene = empty_scene();
    scene.bodies = {body_of(loop, {0, 0}, BodyType::static_body), body_of(disc_shape(0.5), start)};
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 120);
    return engine->bodies()[1].center.y;
  };
  CHECK(std::fabs(height_of(counter_clockwise, {0, 3}) - 2.5) < 0.01);
  CHECK(height_of(counter_clockwise, {0, 0}) < -10);
  CHECK(std::fabs(height_of(clockwise, {0, 0}) + 1.5) < 0.01);
  CHECK(std::fabs(height_of(clockwise, {1.4, 0}) + 1.5) < 0.01);  // in the corner
}

TEST_CASE("what slides or rolls over the joints of a level chain does not feel them", "[engine][shapes][analytic]") {
  const std::vector<Point> points = level_points(100, 1);
  const auto run = [&](Body line, Body body, Precision precision) {
    Scene scene = empty_scene(precision);
    body.position = {2, 0.5};
    body.velocity = {10, 0};
    scene.bodies = {std::move(line), std::move(body)};
    const auto engine = make_engine_or_fail(scene);
    double up_max = 0;
    for (int tick = 0; tick < 540; ++tick) {
      run_ticks(*engine, 1);
      up_max = std::fmax(up_max, std::fabs(engine->bodies()[1].velocity.y));
    }
    const BodyReport report = engine->bodies()[1];
    return std::array{report.velocity.x, up_max, report.center.x};
  };
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    for (Shape shape :
         {disc_shape(0.5), box_shape(0.5, 0.5), capsule_shape({-0.3, 0}, {0.3, 0}, 0.5), box_shape(0.4, 0.4)}) {
      if (shape.half_size.x == 0.4) shape.radius = 0.1;
      shape.material.friction = 0;
      CAPTURE(precision, shape.kind, shape.radius);
      const auto [speed, up, x] = run(chain_ground(points), body_of(shape, {}), precision);
      CHECK(std::fabs(speed - 10) < 1e-5);
      CHECK(up < 0.5 * 10.0 / 240);  // less than half the speed of one substep of free fall
      CHECK(std::fabs(x - 92) < 1e-3);
    }
  }
  // A rolling disc moves as on one long edge.
  Body roller = body_of(disc_shape(0.5), {});
  roller.angular_velocity = -20;
  const auto rolled = run(chain_ground(points), roller, Precision::f64);
  const auto expected = run(chain_ground({{100, 0}, {0, 0}}), roller, Precision::f64);
  CHECK(std::fabs(rolled[0] - expected[0]) < 1e-5);
  CHECK(std::fabs(rolled[1] - expected[1]) < 1e-5);
  CHECK(std::fabs(rolled[2] - expected[2]) < 1e-3);

  Shape box = box_shape(0.5, 0.5);
  box.material.friction = 0;
  const auto snagged = run(segment_ground(points), body_of(box, {}), Precision::f64);
  CHECK(std::fabs(snagged[0] - 10) > 0.1);  // the ends of the segments stop the disc
}

TEST_CASE("down a slope of many edges the speed without friction is g t sin(slope)", "[engine][shapes][analytic]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    // 720 rounded additions of up to 9 m/s. In f32 also the normals of the edges, accurate to 1e-6.
    const double limit = precision == Precision::f32 ? 1e-5 : 1e-12;
    for (const double length : {1.0, 0.1})
      for (Shape shape : {disc_shape(0.5), box_shape(0.5, 0.5), capsule_shape({-0.3, 0}, {0.3, 0}, 0.5)}) {
        CAPTURE(precision, length, shape.kind);
        const engine::SinCos slope = engine::sin_cos(0.3);
        std::vector<Point> points;
        for (int i = static_cast<int>(60 / length); i >= 0; --i)
          points.push_back({i * length * slope.cos, -i * length * slope.sin});
        shape.material.friction = 0;
        Scene scene = empty_scene(precision);
        scene.bodies = {chain_ground(points),
                        body_of(shape, {3 * slope.cos + 0.5 * slope.sin, -3 * slope.sin + 0.5 * slope.cos})};
        scene.bodies[1].angle = -0.3;
        const auto engine = make_engine_or_fail(scene);
        run_ticks(*engine, 180);
        const BodyReport body = engine->bodies()[1];
        const double speed = body.velocity.x * slope.cos - body.velocity.y * slope.sin;
        CHECK(std::fabs(speed / (10 * slope.sin * 3) - 1) < limit);
      }
  }
}

TEST_CASE("a box slides through a valley and over a hill of a chain without a jump of its speed",
          "[engine][shapes][conservation]") {
  // Slopes of 1:20. At each corner the velocity turns by 0.05 rad (0.1 rad at the two in the middle). Its component
  // along the new normal is lost, at most 0.1 v. That is at most 0.5 (0.1 v)^2 of the energy, or 1 % at a corner.
  Scene scene = empty_scene();
  scene.bodies = {chain_ground({{40, 0}, {30, 0}, {25, 0.25}, {20, 0}, {15, -0.25}, {10, 0}, {0, 0}})};
  Shape box = box_shape(0.5, 0.5);
  box.material.friction = 0;
  scene.bodies.push_back(body_of(box, {5, 0.5}));
  scene.bodies[1].velocity = {8, 0};
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 240);
  const BodyReport body = engine->bodies()[1];
  CHECK(body.center.x > 33);
  CHECK(body.center.x < 5 + 8 * 4 + 0.2);
  CHECK(body.velocity.x > 8 * 0.97);
  CHECK(body.velocity.x < 8.01);
}

TEST_CASE("a body of segments alone moves by its stated mass", "[engine][shapes][analytic]") {
  Body cross = body_of(segment_shape({-0.5, 0}, {0.5, 0}), {0, 1});
  cross.shapes.push_back(segment_shape({0, -0.5}, {0, 0.5}));
  cross.mass = engine::ExplicitMass{2, 0.5, {}};
  Scene scene = empty_scene();
  scene.bodies = {ground(), cross};
  const auto engine = make_engine_or_fail(scene);
  CHECK(engine->bodies()[1].mass == 2);
  CHECK(engine->bodies()[1].inertia == 0.5);
  run_ticks(*engine, 240);
  const BodyReport body = engine->bodies()[1];
  CHECK(body.center.y > 0.3);  // the body stands on two ends, or on one
  CHECK(body.center.y < 0.51);

  scene.bodies[1].mass->inertia.reset();
  CHECK_FALSE(engine::make_engine(scene).has_value());  // nothing gives the body an inertia
  scene.bodies[1].mass.reset();
  CHECK_FALSE(engine::make_engine(scene).has_value());
}

TEST_CASE("filters let meet exactly whom groups, else categories and masks, allow", "[engine][shapes][analytic]") {
  struct Case {
    engine::Filter a, b;
    bool meet;
  };
  const Case cases[] = {
      {{1, 0xffffffff, 0}, {1, 0xffffffff, 0}, true},
      {{1, 2, 0}, {2, 1, 0}, true},
      {{1, 2, 0}, {2, 2, 0}, false},
      {{1, 1, 0}, {2, 1, 0}, false},
      {{1, 0, 3}, {2, 0, 3}, true},
      {{1, 0xffffffff, -3}, {1, 0xffffffff, -3}, false},
      {{1, 0xffffffff, -3}, {1, 0xffffffff, 3}, true},
      {{0x80000000, 0x80000000, 0}, {0x80000000, 0x80000000, 0}, true},
      {{1, 0, 0}, {1, 0xffffffff, 0}, false},
      {{0, 0xffffffff, 0}, {1, 0xffffffff, 0}, false},
  };
  for (const Case& c : cases) {
    CAPTURE(c.a.category, c.a.mask, c.a.group, c.b.category, c.b.mask, c.b.group);
    Body a = body_of(disc_shape(0.5), {0, 0}), b = body_of(disc_shape(0.5), {0.9, 0});
    a.shapes[0].filter = c.a;
    b.shapes[0].filter = c.b;
    CHECK((contacts_of(Precision::f32, a, b).size() == 1) == c.meet);
    CHECK((contacts_of(Precision::f32, b, a).size() == 1) == c.meet);
  }
}

TEST_CASE("a sensor sees a ball from the tick it enters to the tick it has left, and does not touch it",
          "[engine][shapes][analytic]") {
  // At the start of tick k the ball is at 2.01 - 3 (k - 1) / 60. Its radius is 0.25, and the sensor spans -1..0. They
  // overlap while -1.25 <= y <= 0.25.
  for (const bool sensor_first : {true, false}) {
    Scene scene = empty_scene();
    scene.gravity = {0, 0};
    Body zone = body_of(box_shape(2, 0.5), {0, -0.5}, BodyType::static_body);
    zone.shapes[0].sensor = true;
    Body ball = body_of(disc_shape(0.25), {0, 2.01});
    ball.velocity = {0, -3};
    scene.bodies = sensor_first ? std::vector{zone, ball} : std::vector{ball, zone};
    const std::uint32_t sensor = sensor_first ? 0 : 1;
    const auto engine = make_engine_or_fail(scene);
    for (int tick = 1; tick <= 100; ++tick) {
      run_ticks(*engine, 1);
      const double y = 2.01 - 3.0 * (tick - 1) / 60;
      const bool inside = y <= 0.25 && y >= -1.25;
      const double before = y + 3.0 / 60;
      const bool was_inside = tick > 1 && before <= 0.25 && before >= -1.25;
      CAPTURE(tick, y);
      const auto sensors = rows_of<4>(*engine, "sensors");
      CHECK(sensors.size() == (inside ? 1 : 0));
      if (!sensors.empty()) CHECK(sensors[0] == std::array<std::uint32_t, 4>{sensor, 0, 1 - sensor, 0});
      const auto events = rows_of<5>(*engine, "events");
      REQUIRE(events.size() == (inside != was_inside ? 1 : 0));
      if (!events.empty()) CHECK(events[0] == std::array<std::uint32_t, 5>{inside ? 2u : 3u, sensor, 0, 1 - sensor, 0});
    }
    CHECK(engine->bodies()[1 - sensor].velocity == Point{0, -3});
    CHECK(rows_of<5>(*engine, "events").empty());
  }
}

TEST_CASE("contacts begin with the first overlap and end with the last, or with their body",
          "[engine][shapes][analytic]") {
  Scene scene = empty_scene();
  scene.settings.events = true;
  scene.inputs = {engine::InputKind::remove, engine::InputKind::set_velocity};
  scene.bodies = {ground(), body_of(disc_shape(0.5), {0, 1.0})};
  const auto engine = make_engine_or_fail(scene);
  const auto step = [&](std::vector<engine::Input> inputs) {
    Bytes bytes;
    engine::encode_inputs(inputs, bytes);
    const TickInput input{scene.settings.dt, bytes};
    REQUIRE(engine->accept(input).has_value());
    REQUIRE(engine->step(input, nullptr));
    return rows_of<5>(*engine, "events");
  };
  using Row = std::array<std::uint32_t, 5>;
  int begin_tick = 0;
  for (int tick = 1; tick <= 120; ++tick) {
    const bool touched = engine->bodies()[1].center.y <= 0.5;
    const auto events = step({});
    CAPTURE(tick);
    if (touched && begin_tick == 0) {
      begin_tick = tick;
      CHECK(events == std::vector<Row>{{0, 0, 0, 1, 0}});
    } else {
      CHECK(events.empty());
    }
  }
  CHECK(begin_tick > 15);
  engine::Input up;
  up.kind = engine::InputKind::set_velocity;
  up.body = 1;
  up.values[1] = 4;
  step({up});
  CHECK(step({}) == std::vector<Row>{{1, 0, 0, 1, 0}});
  for (int tick = 0; tick < 90; ++tick) step({});
  CHECK(rows_of<4>(*engine, "touching").size() == 1);
  engine::Input gone;
  gone.kind = engine::InputKind::remove;
  gone.body = 1;
  CHECK(step({gone}) == std::vector<Row>{{1, 0, 0, 1, 0}});
  CHECK(step({}).empty());
}

TEST_CASE("a conveyor brings a box to its speed at mu g", "[engine][shapes][analytic]") {
  // On the upper side of a belt, counter-clockwise means to the left.
  for (const double speed : {2.0, -3.0}) {
    Scene scene = empty_scene();
    scene.bodies = {ground(), unit_box({0, 0.5})};
    scene.bodies[0].shapes[0].material.tangent_speed = speed;
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 10);
    // a = mu g = 6 m/s^2 once the contact carries the weight, at most one substep late.
    CHECK(engine->bodies()[1].velocity.x == Approx(speed > 0 ? -1.0 : 1.0).margin(6.0 / 240 * 1.01));
    run_ticks(*engine, 110);
    CHECK(engine->bodies()[1].velocity.x == Approx(-speed).margin(1e-6));
  }
  Scene scene = empty_scene();
  scene.bodies = {chain_ground(level_points(20, 1)), unit_box({15, 0.5})};
  scene.bodies[0].shapes[0].material.tangent_speed = 2;
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 120);
  // Along the chain. Where the weight moves from edge to edge, friction is accurate to a thousandth.
  CHECK(engine->bodies()[1].velocity.x == Approx(-2).margin(2e-3));
}

TEST_CASE("rolling resistance c brakes a rolling disc by 2/3 c g", "[engine][shapes][analytic]") {
  // Torque c r m g against the rotation. With friction F and rolling without slip, m a = F and m r^2 / 2 (a / r) = -c r
  // m g - F r, so a = -2/3 c g.
  Scene scene = empty_scene();
  scene.bodies = {ground(1000), body_of(disc_shape(0.5), {0, 0.5})};
  scene.bodies[1].velocity = {6, 0};
  scene.bodies[1].angular_velocity = -12;
  scene.bodies[1].shapes[0].material.rolling_resistance = 0.15;
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 60);
  const double settle = 10.0 / 240;  // in the first substep the contact may carry less than the weight
  CHECK(engine->bodies()[1].velocity.x == Approx(6 - 2.0 / 3 * 0.15 * 10).margin(settle));
  run_ticks(*engine, 360);
  CHECK(std::fabs(engine->bodies()[1].velocity.x) < 1e-6);
  CHECK(std::fabs(engine->bodies()[1].angular_velocity) < 1e-6);
  CHECK(engine->bodies()[1].center.x == Approx(6 * 6 / (2 * 1.0)).margin(6 * settle));
}

TEST_CASE("rolling resistance does not keep a capsule in the floor", "[engine][shapes][regression]") {
  // It took back the turn that pushed the deeper end out: 38 mm of overlap stayed.
  Scene scene = empty_scene(Precision::f64);
  scene.settings.substeps = 1;
  scene.bodies = {ground(5), body_of(capsule_shape({-0.375, 0}, {0.375, 0}, 0.125), {0, 0.10625})};
  scene.bodies[1].angle = -0.1;
  scene.bodies[1].shapes[0].material.friction = 0;
  scene.bodies[1].shapes[0].material.rolling_resistance = 1;
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 300);
  const BodyReport capsule = engine->bodies()[1];
  const double lowest = capsule.center.y - 0.375 * std::fabs(engine::sin_cos(capsule.angle).sin) - 0.125;
  CHECK(lowest > -2.5e-3);
}

TEST_CASE("a press holds capsules and rounded boxes where they are, lines and sensors nowhere",
          "[engine][shapes][analytic]") {
  const auto is_held = [](const Shape& shape, Point at) {
    Scene scene = empty_scene();
    scene.bodies = {with_mass(body_of(shape, {0, 0}))};
    scene.inputs = {engine::InputKind::press, engine::InputKind::drag, engine::InputKind::release};
    scene.pointer.emplace();
    const auto engine = make_engine_or_fail(scene);
    engine::Input press;
    press.kind = engine::InputKind::press;
    press.values[0] = at.x;
    press.values[1] = at.y;
    Bytes bytes;
    engine::encode_inputs({press}, bytes);
    REQUIRE(engine->step({scene.settings.dt, bytes}, nullptr));
    const StateView& state = engine->state();
    return state.tables[*state.schema->find_table("pointers")].row_count == 1;
  };
  const Shape capsule = capsule_shape({-1, 0}, {1, 0}, 0.5);
  CHECK(is_held(capsule, {0, 0}));
  CHECK(is_held(capsule, {1.49, 0}));
  CHECK(is_held(capsule, {1.35, 0.35}));
  CHECK_FALSE(is_held(capsule, {1.36, 0.36}));
  CHECK_FALSE(is_held(capsule, {0, 0.51}));
  Shape box = box_shape(1, 1);
  box.radius = 0.5;
  CHECK(is_held(box, {0.3, -0.2}));
  CHECK(is_held(box, {1.35, 1.35}));
  CHECK_FALSE(is_held(box, {1.36, 1.36}));
  CHECK_FALSE(is_held(segment_shape({-1, 0}, {1, 0}), {0, 0}));
  box.sensor = true;
  CHECK_FALSE(is_held(box, {0.3, -0.2}));
}

TEST_CASE("solvers that read no contacts refuse what they cannot do", "[engine][shapes][analytic]") {
  const auto refusal = [](SolverKind solver, auto change) {
    Scene scene = empty_scene();
    scene.settings.solver = solver;
    scene.settings.substeps = 1;
    scene.bodies = {body_of(disc_shape(0.5), {0, 0})};
    if (solver == SolverKind::impulse) scene.bodies.push_back(ground());
    change(scene);
    const auto made = engine::make_engine(scene);
    return made ? std::string("accepted") : made.error().message;
  };
  using Catch::Matchers::Contains;
  CHECK(refusal(SolverKind::impulse, [](Scene&) {}) == "accepted");
  CHECK(refusal(SolverKind::free_flight, [](Scene&) {}) == "accepted");
  const auto capsule = [](Scene& s) { s.bodies[0].shapes[0] = capsule_shape({-1, 0}, {1, 0}, 1); };
  CHECK_THAT(refusal(SolverKind::impulse, capsule), Contains("circles and sharp polygons only"));
  CHECK(refusal(SolverKind::free_flight, capsule) == "accepted");
  CHECK_THAT(refusal(SolverKind::impulse, [](Scene& s) { s.bodies[0].shapes[0].filter.group = 1; }),
             Contains("filter"));
  for (const SolverKind solver : {SolverKind::impulse, SolverKind::free_flight}) {
    CHECK_THAT(refusal(solver, [](Scene& s) { s.bodies[0].shapes[0].sensor = true; }), Contains("sensor"));
    CHECK_THAT(refusal(solver, [](Scene& s) { s.settings.events = true; }), Contains("contacts"));
  }
}

TEST_CASE("a pile of every shape comes to rest inside its tub of a chain", "[engine][shapes][conservation]") {
  for (const char* text : {"shapes?precision=f32&substeps=4", "shapes?precision=f64&substeps=4", "shapes?precision=f32",
                           "shapes?precision=f64"}) {
    const auto scene = engine::make_builtin_scene(text);
    REQUIRE(scene.has_value());
    const auto engine = make_engine_or_fail(*scene);
    run_ticks(*engine, 2400);  // with automatic substeps a disc rolls slowly for 25 s
    CAPTURE(text);
    for (const BodyReport& body : engine->bodies()) {
      CAPTURE(body.name);
      CHECK(body.center.y > -0.2);  // the lowest point of the floor
      CHECK(std::hypot(body.velocity.x, body.velocity.y) < 0.01);
    }
  }
}

TEST_CASE("a box that is small against a disc lies still on it", "[engine][shapes][contacts]") {
  // The disc leaves the middle of the box's edge by 2.6 mm less than its ends, which is within the slop of 5 mm.
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const bool is_disc_first : {false, true})
      for (const double gravity : {10.0, 2000.0}) {
        CAPTURE(precision, is_disc_first, gravity);
        Scene scene = empty_scene(precision);
        scene.gravity = {0, -gravity};
        if (gravity > 10) scene.settings.dt = 1.0 / 240;
        scene.bodies = {body_of(box_shape(0.5, 0.5), {0.05, 0.5}),
                        body_of(disc_shape(48), {0, -48}, BodyType::static_body)};
        if (is_disc_first) std::swap(scene.bodies[0], scene.bodies[1]);
        const auto engine = make_engine_or_fail(scene);
        run_ticks(*engine, 300);
        const BodyReport& box = engine->bodies()[is_disc_first ? 1 : 0];
        CHECK(std::fabs(box.angular_velocity) < 0.01);
        CHECK(std::fabs(box.center.x - 0.05) < 0.01);
        CHECK(std::fabs(box.center.y - 0.5) < 0.01);
      }
}

TEST_CASE("a disc rolls over a small static box about one point", "[engine][shapes][contacts]") {
  Scene scene = empty_scene();
  scene.bodies = {body_of(box_shape(0.5, 0.5), {0, -0.5}, BodyType::static_body), body_of(disc_shape(48), {0, 48})};
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 10);
  REQUIRE(engine->contacts().size() == 1);
  CHECK(engine->contacts()[0].point_count == 1);
}

TEST_CASE("capsules, segments and chains with too few, too many or coinciding points are refused",
          "[engine][shapes][analytic]") {
  const auto refusal = [](Shape shape, std::size_t count = 1) {
    Scene scene = empty_scene();
    scene.bodies = {body_of(shape, {0, 0}, BodyType::static_body)};
    for (std::size_t i = 1; i < count; ++i) scene.bodies[0].shapes.push_back(shape);
    const Status status = engine::check_scene(scene, "s");
    return status ? std::string("accepted") : status.error().message;
  };
  using Catch::Matchers::Contains;
  CHECK(refusal(capsule_shape({0, 0}, {1, 0}, 0.5)) == "accepted");
  CHECK_THAT(refusal(capsule_shape({0, 0}, {1, 0}, 0)), Contains("radius"));
  CHECK_THAT(refusal(capsule_shape({1, 0}, {1, 0}, 0.5)), Contains("points 0 and 1 coincide"));
  CHECK_THAT(refusal(segment_shape({1, 0}, {1, 0})), Contains("points 0 and 1 coincide"));
  CHECK_THAT(refusal(chain_shape({{1, 0}})), Contains("found 1, expected at least 2"));
  CHECK_THAT(refusal(chain_shape({{0, 0}, {1, 0}, {1, 0}})), Contains("points 1 and 2 coincide"));
  Shape loop = chain_shape({{0, 0}, {1, 0}});
  loop.loop = true;
  CHECK_THAT(refusal(loop), Contains("found 2, expected at least 3 of a loop"));
  loop.vertices = {{0, 0}, {1, 0}, {1, 1}, {0, 0}};
  CHECK_THAT(refusal(loop), Contains("points 3 and 0 coincide"));
  CHECK_THAT(refusal(chain_shape(level_points(16383, 1)), 5), Contains("found 81915, expected at most 65536"));
}
