// Small fast bodies on chains: a vertex of a level chain has no effect, and walls and floors of small edges stop
// bodies.
// SPDX-License-Identifier: MIT
#include <cmath>
#include <vector>

#include "engine/engine.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/scenes.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::BodyReport;

namespace {

Body still_chain(std::vector<Point> points, bool loop = false) {
  Shape chain = chain_shape(std::move(points));
  chain.loop = loop;
  chain.material.friction = 0;
  return body_of(chain, {0, 0}, BodyType::static_body);
}

/// From x = `end` to 0, at height 0.
std::vector<Point> level_chain(double end, double edge_length) {
  std::vector<Point> points;
  for (int i = static_cast<int>(std::ceil(end / edge_length)); i >= 0; --i) points.push_back({i * edge_length, 0});
  return points;
}

/// A regular box, pentagon, capsule, disc and rounded box, `size` high.
std::vector<Shape> sliders(double size) {
  const double half = 0.5 * size;
  std::vector<Shape> shapes{
      box_shape(half, half), box_shape(1.5 * half, half), disc_shape(half),
      capsule_shape({-0.5 * half, 0}, {0.5 * half, 0}, half),
      polygon_shape({{-half, -half}, {half, -half}, {1.2 * half, 0}, {0, half}, {-1.2 * half, 0}})};
  shapes.push_back(box_shape(0.8 * half, 0.8 * half));
  shapes.back().radius = 0.2 * half;
  for (Shape& shape : shapes) shape.material.friction = 0;
  return shapes;
}

double speed_kept(Body line, const Shape& shape, double height, double speed, int ticks, Precision precision) {
  Body body = body_of(shape, {1, height});
  body.velocity = {speed, 0};
  Scene scene = empty_scene(precision);
  scene.bodies = {std::move(line), std::move(body)};
  const auto engine = make_engine_or_fail(scene);
  const double start = engine->bodies()[1].center.x;
  run_ticks(*engine, ticks);
  const BodyReport report = engine->bodies()[1];
  const double way = (report.center.x - start) / (speed * ticks / 60);
  return std::fabs(report.velocity.x / speed - 1) > std::fabs(way - 1) ? report.velocity.x / speed : way;
}

}  // namespace

TEST_CASE("small fast bodies slide over the joints of a level chain as if there were none",
          "[engine][shapes][chains]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const double size : {0.01, 0.1, 1.0})
      for (const double speed : {0.5, 5.0, 20.0, 50.0})
        for (const double edge_length : {0.2, 0.37, 2.0})
          for (const Shape& shape : sliders(size)) {
            CAPTURE(precision, size, speed, edge_length, shape.kind, shape.radius, shape.half_size.x);
            const double seconds = speed < 10 ? 10 : 200 / speed;
            const Body line = still_chain(level_chain(3 + speed * seconds, edge_length));
            const double kept = speed_kept(line, shape, 0.5 * size, speed, static_cast<int>(60 * seconds), precision);
            CHECK(std::fabs(kept - 1) < 1e-3);
          }
}

TEST_CASE("small fast bodies slide over the joints of a loop's flat top", "[engine][shapes][chains]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const double size : {0.02, 0.1, 1.0})
      for (const double speed : {5.0, 20.0})
        for (const Shape& shape : sliders(size)) {
          CAPTURE(precision, size, speed, shape.kind, shape.radius, shape.half_size.x);
          std::vector<Point> points = level_chain(104, 0.37);
          points.push_back({0, -2});
          points.push_back({points[0].x, -2});
          const double seconds = 100 / speed;
          const double kept = speed_kept(still_chain(points, true), shape, 0.5 * size, speed,
                                         static_cast<int>(60 * seconds), precision);
          CHECK(std::fabs(kept - 1) < 1e-3);
        }
}

TEST_CASE("small fast bodies shot at a floor and walls of short edges stay in", "[engine][shapes][chains]") {
  // A room of 6 m by 4 m, clockwise. Contacts are elastic, so bodies return to every corner.
  std::vector<Point> room;
  const auto line_to = [&](Point from, Point to) {
    for (int i = 0; i < 20; ++i) room.push_back({from.x + (to.x - from.x) * i / 20, from.y + (to.y - from.y) * i / 20});
  };
  line_to({6, 0}, {0, 0});
  line_to({0, 0}, {0, 4});
  line_to({0, 4}, {6, 4});
  line_to({6, 4}, {6, 0});
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const double size : {0.01, 0.1})
      for (const Shape& shape : sliders(size)) {
        Scene scene = empty_scene(precision);
        scene.bodies = {still_chain(room, true)};
        for (int i = 0; i < 40; ++i) {
          Body body = body_of(shape, {1 + 0.1 * i, 2});
          const double turn = 0.157 * i;
          body.velocity = {50 * std::cos(turn), 50 * std::sin(turn)};
          body.shapes[0].material.restitution = i % 2 == 0 ? 0 : 0.9;
          body.shapes[0].filter.group = -1;
          scene.bodies.push_back(body);
        }
        CAPTURE(precision, size, shape.kind, shape.radius, shape.half_size.x);
        const auto engine = make_engine_or_fail(scene);
        run_ticks(*engine, 240);
        int outside = 0;
        for (std::size_t i = 1; i < engine->bodies().size(); ++i) {
          const Point at = engine->bodies()[i].center;
          outside += at.x < 0 || at.x > 6 || at.y < 0 || at.y > 4;
        }
        CHECK(outside == 0);
      }
}

TEST_CASE("over convex hills of a chain bodies without friction keep their energy", "[engine][shapes][chains]") {
  // Slopes of 1:20. At each of the three corners the velocity turns by at most 0.1 rad, there or on landing. The energy
  // along the normal may be lost, sin^2(0.1) = 1 % of the total. A body that lands on one end first loses a little
  // more.
  const std::vector<Point> hill{{60, 0}, {12, 0}, {9, 0.15}, {6, 0.0}, {0, 0}};
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const double size : {0.02, 0.1, 0.5})
      for (const double speed : {5.0, 20.0})
        for (const Shape& shape : sliders(size)) {
          CAPTURE(precision, size, speed, shape.kind, shape.radius, shape.half_size.x);
          Body body = body_of(shape, {3, 0.5 * size});
          body.velocity = {speed, 0};
          Scene scene = empty_scene(precision);
          scene.bodies = {still_chain(hill), body};
          const auto engine = make_engine_or_fail(scene);
          const double start_height = engine->bodies()[1].center.y;
          run_ticks(*engine, static_cast<int>(60 * 30 / speed));
          const BodyReport report = engine->bodies()[1];
          const double energy = 0.5 * (report.velocity.x * report.velocity.x + report.velocity.y * report.velocity.y) +
                                10 * (report.center.y - start_height) +
                                0.5 * report.inertia / report.mass * report.angular_velocity * report.angular_velocity;
          const double share = energy / (0.5 * speed * speed);
          CHECK(share < 1.001);
          CHECK(share > 0.96);
        }
}
