// Automatic substeps of what turns and strikes on direct joints: whips keep their energy, and impacts open no joint.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/math/trig.h"
#include "tests/support/engine_runs.h"
#include "tests/support/joint_gaps.h"
#include "tests/support/joints.h"
#include "tool/study/measures.h"

using namespace ticktrue;
using namespace ticktrue::test;

namespace {

Scene automatic_scene(Precision precision) {
  Scene scene = empty_scene(precision);
  engine::choose_substeps(scene.settings);
  return scene;
}

/// A static disc, one of 1 kg and one of `mass` on rods of 1 m, which turn about the static one at 10 rad/s. The second
/// rod is bent by `bend` rad.
Scene rods(double mass, double bend, Precision precision) {
  Scene scene = automatic_scene(precision);
  scene.gravity = {0, 0};
  scene.bodies.push_back(peg({0, 0}));
  constexpr double speed = 10;
  const auto add = [&](double kilograms, Point at) {
    Body body = body_of(disc_shape(0.1), at);
    body.mass = engine::ExplicitMass{kilograms, {}, {}};
    body.velocity = {-speed * at.y, speed * at.x};
    body.shapes[0].filter.mask = 0;
    scene.bodies.push_back(body);
    const auto last = static_cast<std::uint32_t>(scene.bodies.size() - 1);
    Joint rod = joint_of(JointKind::distance, last - 1, last);
    rod.length = 1;
    scene.joints.push_back(rod);
  };
  add(1, {1, 0});
  add(mass, {1 + std::cos(bend), std::sin(bend)});
  return scene;
}

/// An arch of eight planks of 1 m between two pegs, on a circle. It falls through, and its planks whip.
Scene arch(double half_angle, Precision precision) {
  constexpr int count = 8;
  Scene scene = automatic_scene(precision);
  scene.gravity = {0, -10};
  scene.bodies.push_back(peg({0, 0}));
  Point end{};
  double before = 0;
  const auto pin = [&](std::uint32_t body, Point on_body, double angle) {
    Joint joint = joint_of(JointKind::revolute, body - 1, body);
    joint.anchor_a = body == 1 ? Point{} : Point{0.5, 0};
    joint.anchor_b = on_body;
    joint.reference_angle = angle - before;
    scene.joints.push_back(joint);
    before = angle;
  };
  for (int i = 0; i < count; ++i) {
    const double angle = half_angle * (1 - (2 * i + 1.0) / count);
    const Point along{std::cos(angle), std::sin(angle)};
    Body plank = body_of(box_shape(0.5, 0.1), {end.x + 0.5 * along.x, end.y + 0.5 * along.y});
    plank.angle = angle;
    plank.shapes[0].filter.mask = 0;
    // one heavier plank: the arch does not fall straight down
    plank.mass = engine::ExplicitMass{i == 2 ? 2.0 : 1.0, {}, {}};
    scene.bodies.push_back(plank);
    pin(static_cast<std::uint32_t>(scene.bodies.size() - 1), {-0.5, 0}, angle);
    end = {end.x + along.x, end.y + along.y};
  }
  scene.bodies.push_back(peg(end));
  pin(static_cast<std::uint32_t>(scene.bodies.size() - 1), {}, 0);
  return scene;
}

double widest_gap(const Scene& scene, const engine::Engine& engine) {
  double most = 0;
  for (const JointGap& joint : joint_gaps(scene, engine.bodies())) most = std::max(most, joint.gap);
  return most;
}

}  // namespace

TEST_CASE("two bent rods with discs keep their energy within 1 %", "[engine][islands][direct][conservation]") {
  // Discs do not turn themselves when their rods do.
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const double bend : {0.3, 1.0}) {
      CAPTURE(precision, bend);
      const auto engine = make_engine_or_fail(rods(10, bend, precision));
      const double start = tool::kinetic_energy(engine->bodies());
      run_ticks(*engine, 600);
      CHECK(std::abs(tool::kinetic_energy(engine->bodies()) / start - 1) < 0.01);
    }
}

TEST_CASE("an arch that falls through keeps its energy", "[engine][islands][direct][conservation]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const double half_angle : {0.5, 1.0}) {
      CAPTURE(precision, half_angle);
      const Scene scene = arch(half_angle, precision);
      const auto engine = make_engine_or_fail(scene);
      const double start = tool::energy_of(scene, engine->bodies());  // above the pegs
      run_ticks(*engine, 600);
      CHECK(std::abs(tool::energy_of(scene, engine->bodies()) / start - 1) < 0.03);
      CHECK(widest_gap(scene, *engine) < 0.001);
    }
}

TEST_CASE("jointed figures that hit the ground at 28 m/s keep their joints closed", "[engine][islands][direct]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    CAPTURE(precision);
    Result<Scene> scene = engine::make_builtin_scene("rain?rows=1&columns=2&group=2");
    REQUIRE(scene.has_value());
    scene->settings.precision = precision;
    scene->settings.substeps = 4;
    engine::choose_substeps(scene->settings);
    const auto engine = make_engine_or_fail(*scene);
    double gap = 0;
    for (int tick = 0; tick < 240; ++tick) {
      run_ticks(*engine, 1);
      gap = std::max(gap, widest_gap(*scene, *engine));
    }
    CHECK(gap < 0.005);
  }
}
