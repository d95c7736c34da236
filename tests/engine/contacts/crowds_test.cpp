// Bodies put down in one place part slowly.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/joints.h"
#include "tests/support/scenes.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::BodyReport;
using engine::Engine;

namespace {

constexpr int five_seconds = 300;  // ticks

// Bodies of 1 m within `spread` m of (0, 2), in free space or above a ground.
Scene crowd_of(int count, const Shape& shape, double spread, bool has_ground, Precision precision) {
  Random random(7);
  Scene scene = empty_scene(precision);
  if (has_ground)
    scene.bodies.push_back(ground());
  else
    scene.gravity = {0, 0};
  for (int i = 0; i < count; ++i)
    scene.bodies.push_back(body_of(shape, {random.real(-spread, spread), 2 + random.real(-spread, spread)}));
  return scene;
}

double fastest(const Engine& engine) {
  double most = 0;
  for (const BodyReport& body : engine.bodies()) most = std::max(most, std::hypot(body.velocity.x, body.velocity.y));
  return most;
}

Point momentum_of(const Engine& engine) {
  Point sum{0, 0};
  for (const BodyReport& body : engine.bodies()) sum = {sum.x + body.velocity.x, sum.y + body.velocity.y};
  return sum;
}

double deepest_overlap(const Engine& engine) {
  double deepest = 0;
  for (const engine::ContactReport& contact : engine.contacts())
    for (int i = 0; i < contact.point_count; ++i) deepest = std::max(deepest, -contact.separation[i]);
  return deepest;
}

}  // namespace

TEST_CASE("10, 50 and 200 discs in one point part slowly, and soon", "[engine][contacts][crowds]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const bool has_ground : {false, true})
      for (const int count : {10, 50, 200}) {
        CAPTURE(precision, has_ground, count);
        const auto engine = make_engine_or_fail(crowd_of(count, disc_shape(0.5), 0, has_ground, precision));
        double most = 0;
        const int tick_count = has_ground && count > 50 ? 2 * five_seconds : five_seconds;
        for (int tick = 0; tick < tick_count; ++tick) {
          run_ticks(*engine, 1);
          most = std::max(most, fastest(*engine));
        }
        CHECK(most < (has_ground && count > 50 ? 12 : 10));  // what is pushed up 10 m falls again
        CHECK(deepest_overlap(*engine) < 0.01);
        if (!has_ground) {
          const Point sum = momentum_of(*engine);
          CHECK(std::hypot(sum.x, sum.y) < 1e-3 * count);
        }
      }
}

TEST_CASE("a crowd of 50 that is not in one point is apart after five seconds", "[engine][contacts][crowds]") {
  for (const bool is_automatic : {false, true})
    for (const Shape& shape : {disc_shape(0.5), box_shape(0.5, 0.5)}) {
      CAPTURE(is_automatic);
      Scene scene = crowd_of(50, shape, 1, false, Precision::f32);
      if (is_automatic) engine::choose_substeps(scene.settings);
      const auto engine = make_engine_or_fail(scene);
      double most = 0;
      for (int tick = 0; tick < five_seconds; ++tick) {
        run_ticks(*engine, 1);
        most = std::max(most, fastest(*engine));
      }
      CHECK(most < 10);
      CHECK(deepest_overlap(*engine) < 0.01);
    }
}

TEST_CASE("two discs in one point part by their ids alone", "[engine][contacts][crowds]") {
  // Each way from A to B is that from B to A, turned around; bodies elsewhere change nothing.
  Scene scene = crowd_of(2, disc_shape(0.5), 0, false, Precision::f64);
  const auto alone = make_engine_or_fail(scene);
  scene.bodies.push_back(body_of(disc_shape(0.25), {50, 2}));
  const auto beside = make_engine_or_fail(scene);
  run_ticks(*alone, 30);
  run_ticks(*beside, 30);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(alone->bodies()[i].center.x == beside->bodies()[i].center.x);
    CHECK(alone->bodies()[i].center.y == beside->bodies()[i].center.y);
  }
  const Point a = alone->bodies()[0].center, b = alone->bodies()[1].center;
  CHECK(std::hypot(b.x - a.x, b.y - a.y) > 0.2);
  CHECK(std::abs(a.x + b.x) < 1e-12);
}

TEST_CASE("discs of two sizes in one point part without a jump", "[engine][contacts][crowds]") {
  Scene scene = crowd_of(2, disc_shape(0.5), 0, false, Precision::f64);
  scene.bodies.push_back(body_of(disc_shape(0.125), {0, 2}));
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, five_seconds);
  CHECK(fastest(*engine) < 3);
  CHECK(deepest_overlap(*engine) < 0.01);
}

TEST_CASE("the contact of two discs in one point lies halfway between their surfaces", "[engine][contacts][crowds]") {
  Scene scene = crowd_of(1, disc_shape(0.5), 0, false, Precision::f64);
  scene.bodies.push_back(body_of(disc_shape(0.125), {0, 2}));
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 1);
  REQUIRE(engine->contacts().size() == 1);
  const engine::ContactReport contact = engine->contacts()[0];
  // In the tick the bodies move by at most 3 m/s.
  CHECK(std::abs(contact.point[0].x - 0.1875 * contact.normal.x) < 0.06);
  CHECK(std::abs(contact.point[0].y - 2 - 0.1875 * contact.normal.y) < 0.06);
  CHECK(std::abs(contact.normal.x) > 0.5);
}

TEST_CASE("two bodies inside each other are no crowd", "[engine][contacts][crowds]") {
  // The push of a pair is removed by the relax pass: what is left of it is small.
  Scene scene = crowd_of(2, disc_shape(0.5), 0, false, Precision::f64);
  scene.bodies[1].position.x += 0.2;
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, five_seconds);
  CHECK(fastest(*engine) < 3);
  CHECK(deepest_overlap(*engine) < 0.01);
}

TEST_CASE("a heavy disc rises from light ones that overlap on a floor", "[engine][contacts][crowds]") {
  // The light discs lie above each other between floor and heavy disc. A single push moves the heavy one less than
  // gravity does.
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const int count : {2, 3}) {
      CAPTURE(precision, count);
      Scene scene = empty_scene(precision);
      engine::choose_substeps(scene.settings);
      scene.bodies.push_back(ground());
      scene.bodies.push_back(body_of(disc_shape(2), {0, 2}));
      for (int i = 0; i < count; ++i) scene.bodies.push_back(body_of(disc_shape(0.0625), {0, 0.0625 - 0.00125 * i}));
      const auto engine = make_engine_or_fail(scene);
      run_ticks(*engine, five_seconds);
      CHECK(deepest_overlap(*engine) < 0.01);
    }
}
