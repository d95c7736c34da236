// Towers, pyramids and card houses of every size and mass ratio stand.
// SPDX-License-Identifier: MIT
//
// All runs use automatic substeps, whose target error is 0.005 of the size of a box. The tests allow twice that error.
#include <cmath>
#include <string>
#include <vector>

#include "base/random.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "tests/support/engine_runs.h"
#include "tests/support/joints.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::BodyReport;
using engine::ContactReport;
using engine::Engine;

namespace {

constexpr int twenty_seconds = 1200;  // ticks

// Boxes of `size` m and 1 kg/m^2 on top of each other, each shifted sideways by up to `jitter` m. Body 0 is the ground.
Scene tower_scene(int count, double jitter = 0, std::uint64_t seed = 1, double size = 1,
                  Precision precision = Precision::f32) {
  Random random(seed);
  Scene scene = empty_scene(precision);
  scene.settings.auto_substeps.emplace();
  scene.bodies.push_back(body_of(box_shape(20 * size, size), {0, -size}, BodyType::static_body));
  for (int i = 0; i < count; ++i)
    scene.bodies.push_back(body_of(box_shape(size / 2, size / 2), {random.real(-jitter, jitter), (i + 0.5) * size}));
  return scene;
}

struct Moved {
  double lateral = 0;  // largest, m
  double down = 0;     // largest, m
};

// The distances of the bodies from their places in the scene.
Moved moved_in(const Engine& engine) {
  Moved moved;
  const std::vector<BodyReport> bodies = engine.bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Point start = engine.scene().bodies[i].position;
    moved.lateral = std::fmax(moved.lateral, std::fabs(bodies[i].center.x - start.x));
    moved.down = std::fmax(moved.down, std::fabs(bodies[i].center.y - start.y));
  }
  return moved;
}

Moved moved_after(const Scene& scene, int tick_count) {
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, tick_count);
  return moved_in(*engine);
}

void check_stands(const Scene& scene, double lateral_max) {
  const Moved moved = moved_after(scene, twenty_seconds);
  CHECK(moved.lateral < lateral_max);
  CHECK(moved.down < 0.01);
}

}  // namespace

TEST_CASE("towers of 10 to 80 boxes stand for 20 s, perfect or shifted by 1 cm", "[engine][stack][stacks]") {
  for (const int count : {10, 20, 40, 80})
    for (const double jitter : {0.0, 0.01}) {
      CAPTURE(count, jitter);
      check_stands(tower_scene(count, jitter), 0.05);
    }
}

TEST_CASE("a tower of 200 boxes stands for 20 s", "[engine][stack][stacks]") {
  check_stands(tower_scene(200, 0.01), 0.1);
}

TEST_CASE("towers of 200 boxes stand for 20 s with every seed", "[engine][stack][stacks][.slow]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
      CAPTURE(precision, seed);
      check_stands(tower_scene(200, 0.01, seed, 1, precision), 0.1);
    }
}

TEST_CASE("a pyramid of 210 boxes stands for 20 s", "[engine][stack][stacks]") {
  Scene scene = pyramid_scene(20, Precision::f32);
  scene.settings.auto_substeps.emplace();
  check_stands(scene, 0.05);
}

TEST_CASE("a card house of five floors stands for 20 s", "[engine][stack][stacks]") {
  // The centre of the top card starts at 1.643 m.
  auto made = engine::make_builtin_scene("card_house");
  REQUIRE(made);
  REQUIRE(made->bodies.size() == 41);
  made->settings.auto_substeps.emplace();
  const auto engine = make_engine_or_fail(*made);
  run_ticks(*engine, twenty_seconds);
  CHECK(engine->bodies().back().center.y > 1.60);
  CHECK(moved_in(*engine).lateral < 0.05);
}

TEST_CASE("a stack of ten behaves alike for boxes of 1 cm to 100 m", "[engine][stack][stacks]") {
  for (const double size : {0.01, 0.1, 1.0, 10.0, 100.0}) {
    CAPTURE(size);
    const Moved moved = moved_after(tower_scene(10, 0.01 * size, 1, size), twenty_seconds);
    CHECK(moved.lateral < 0.05 * size);
    CHECK(moved.down < 0.01 * size);
  }
}

TEST_CASE("a stack carries a hundredfold top box", "[engine][stack][stacks]") {
  Scene scene = tower_scene(10);
  scene.bodies.back().mass = engine::ExplicitMass{100, {}, {}};
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, twenty_seconds);
  const Moved moved = moved_in(*engine);
  CHECK(moved.lateral < 0.01);
  CHECK(moved.down < 0.01);
  for (const ContactReport& contact : engine->contacts()) {
    const double carried = 1000 + 10.0 * (10 - std::max(contact.body_a, contact.body_b));
    CHECK(contact.normal_force[0] + contact.normal_force[1] == Approx(carried).epsilon(0.01));
  }
}

TEST_CASE("a hanging chain carries a hundredfold end", "[engine][joints][stacks]") {
  auto made = engine::make_builtin_scene("chain?links=20&end_mass=100");
  REQUIRE(made);
  made->settings.auto_substeps.emplace();
  const auto engine = make_engine_or_fail(*made);
  run_ticks(*engine, twenty_seconds);
  CHECK(moved_in(*engine).down < 0.01);
  for (std::size_t i = 0; i < 20; ++i) {
    CAPTURE(i);
    const double carried = 1000 + 10.0 * (19 - static_cast<double>(i));
    CHECK(joint_value(*engine, i, "linear_force", 1) == Approx(carried).epsilon(0.01));
  }
}
