// Boxes fall on bridges of planks: automatic substeps add no energy.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/math/trig.h"
#include "tests/support/engine_runs.h"
#include "tests/support/joints.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::BodyReport;
using engine::Engine;

namespace {

constexpr double plank_length = 1;  // m; a plank has 1 kg

// Planks pinned end to end between two pegs at equal height. `turn`: rad from plank to plank, so that the bridge hangs
// as an arc, or is straight.
Scene bridge_of(int plank_count, double turn, Precision precision) {
  Scene scene = empty_scene(precision);
  engine::choose_substeps(scene.settings);
  Body banks = peg({0, 0});
  banks.shapes[0].filter.mask = 0;
  scene.bodies.push_back(banks);
  Point end{0, 0};
  for (int i = 0; i < plank_count; ++i) {
    const double angle = turn * (i - 0.5 * (plank_count - 1));
    const engine::SinCos q = engine::sin_cos(angle);
    Body plank = body_of(box_shape(plank_length / 2, 0.1), {end.x + q.cos / 2, end.y + q.sin / 2});
    plank.angle = angle;
    plank.mass = engine::ExplicitMass{1, {}, {}};
    scene.bodies.push_back(plank);
    Joint pin = joint_of(JointKind::revolute, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i + 1));
    pin.anchor_a = i == 0 ? Point{0, 0} : Point{plank_length / 2, 0};
    pin.anchor_b = {-plank_length / 2, 0};
    scene.joints.push_back(pin);
    end = {end.x + q.cos, end.y + q.sin};
  }
  Joint pin = joint_of(JointKind::revolute, static_cast<std::uint32_t>(plank_count), 0);
  pin.anchor_a = {plank_length / 2, 0};
  pin.anchor_b = end;
  scene.joints.push_back(pin);
  return scene;
}

double energy_of_bridge(const Engine& engine) {
  double sum = 0;
  for (const BodyReport& body : engine.bodies()) {
    if (body.type != BodyType::dynamic_body) continue;
    const Point v = body.velocity;
    sum += body.mass * ((v.x * v.x + v.y * v.y) / 2 + 10 * body.center.y);
    sum += body.inertia * body.angular_velocity * body.angular_velocity / 2;
  }
  return sum;
}

struct Outcome {
  double gained = 0;  // J, the largest energy above that of the start
  double rise = 0;    // J, the largest energy above an earlier one
};

// 5 s.
Outcome outcome_of(const Scene& scene) {
  const auto engine = make_engine_or_fail(scene);
  const double start = energy_of_bridge(*engine);
  double least = start;
  Outcome outcome;
  for (int tick = 0; tick < 300; ++tick) {
    run_ticks(*engine, 1);
    const double energy = energy_of_bridge(*engine);
    least = std::min(least, energy);
    outcome.gained = std::max(outcome.gained, energy - start);
    outcome.rise = std::max(outcome.rise, energy - least);
  }
  return outcome;
}

struct Fall {
  Scene scene;
  double energy;  // J, of the falling box over the bridge
};

// A tilted box falls on a bridge that is straight or hangs.
Fall falling_box(std::uint64_t seed, Precision precision) {
  Random random(seed);
  const int plank_count = static_cast<int>(4 + random.below(17));
  const double turn = random.unit() < 0.4 ? 0 : random.real(0.5, 1.5) / plank_count;
  Scene scene = bridge_of(plank_count, turn, precision);
  const double span = scene.joints.back().anchor_b.x;
  const double half = random.real(0.1, 1);
  const double mass = random.real(1, 12);
  const double height = random.real(0.5, 10);
  Body box = body_of(box_shape(half, half), {span / 2 + random.real(-0.25, 0.25) * span, height + 0.1 + 1.5 * half});
  box.angle = random.real(0, engine::pi / 2);
  box.mass = engine::ExplicitMass{mass, {}, {}};
  scene.bodies.push_back(box);
  return {scene, mass * 10 * height};
}

}  // namespace

TEST_CASE("what falls on a bridge gains nothing", "[engine][joints][direct][conservation][bridges]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
      const Fall fall = falling_box(seed, precision);
      CAPTURE(precision, seed, fall.energy);
      const Outcome outcome = outcome_of(fall.scene);
      CHECK(outcome.gained < 0.01 * fall.energy);
      CHECK(outcome.rise < 0.05 * fall.energy);
    }
}

TEST_CASE("a taut bridge that nothing touches is not lifted", "[engine][joints][direct][conservation][bridges]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const int plank_count : {8, 11, 20, 30}) {
      CAPTURE(precision, plank_count);
      CHECK(outcome_of(bridge_of(plank_count, 0, precision)).gained < 0.005);
    }
}

TEST_CASE("a bridge that swings free keeps its energy within 1 % for 10 s",
          "[engine][joints][direct][conservation][bridges]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const int plank_count : {6, 12, 20}) {
      CAPTURE(precision, plank_count);
      Scene scene = bridge_of(plank_count, 1.0 / plank_count, precision);
      for (Body& body : scene.bodies)
        for (Shape& shape : body.shapes) shape.filter.mask = 0;
      // Pushed to the side: 2 m/s at all planks.
      for (std::size_t i = 1; i < scene.bodies.size(); ++i) scene.bodies[i].velocity = {0, 2};
      const auto engine = make_engine_or_fail(scene);
      run_ticks(*engine, 1);  // velocities that the joints do not allow are gone
      const double start = energy_of_bridge(*engine);
      // Over the energy of motion at the start.
      const double motion = plank_count * 2.0;
      double most = 0;
      for (int tick = 0; tick < 600; ++tick) {
        run_ticks(*engine, 1);
        most = std::max(most, std::fabs(energy_of_bridge(*engine) - start));
      }
      CHECK(most < 0.01 * motion);
    }
}
