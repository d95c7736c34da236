// Resting impacts: a body that lands on a tower, or slides against it, neither moves the tower nor adds energy.
// SPDX-License-Identifier: MIT
//
// All runs use automatic substeps. Boxes are 1 m, so the slop is 5 mm.
#include <cmath>
#include <vector>

#include "base/random.h"
#include "engine/scene/input.h"
#include "tests/support/engine_runs.h"
#include "tests/support/joints.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::BodyReport;
using engine::Engine;

namespace {

constexpr double slop = 0.005;  // m
constexpr double gravity = 10;  // m/s^2
constexpr int budget = 160;     // fixed substeps
constexpr double drops[] = {0.1, 0.5, 1.0, 2.0, 5.0};

// Towers of unit boxes at these places. Body 0 is the ground.
Scene towers_scene(int count, const std::vector<double>& places, Precision precision = Precision::f32) {
  Scene scene = empty_scene(precision);
  scene.settings.auto_substeps.emplace();
  scene.bodies.push_back(ground(20));
  for (const double x : places)
    for (int i = 0; i < count; ++i) scene.bodies.push_back(unit_box({x, i + 0.5}));
  return scene;
}

// Energy of the bodies, minus the energy of the resting bodies `rest`, J.
double energy_above(const std::vector<BodyReport>& bodies, const std::vector<BodyReport>& rest) {
  double energy = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const BodyReport& body = bodies[i];
    energy += 0.5 * body.mass * (body.velocity.x * body.velocity.x + body.velocity.y * body.velocity.y);
    energy += 0.5 * body.inertia * body.angular_velocity * body.angular_velocity;
    energy += gravity * body.mass * (body.center.y - rest[i].center.y);
  }
  return energy;
}

struct LandingOutcome {
  double energy_max = 0;  // J, above the energy at rest
  double moved_max = 0;   // m, of all but the last body
  Point last;             // where the last body ends
};

LandingOutcome watch(Engine& engine, const std::vector<BodyReport>& rest, int tick_count) {
  LandingOutcome outcome;
  for (int tick = 0; tick < tick_count; ++tick) {
    run_ticks(engine, 1);
    const std::vector<BodyReport> bodies = engine.bodies();
    outcome.energy_max = std::fmax(outcome.energy_max, energy_above(bodies, rest));
    for (std::size_t i = 0; i + 1 < bodies.size(); ++i)
      outcome.moved_max = std::fmax(
          outcome.moved_max, std::hypot(bodies[i].center.x - rest[i].center.x, bodies[i].center.y - rest[i].center.y));
    outcome.last = bodies.back().center;
  }
  return outcome;
}

// After two seconds, `lands` falls onto the bodies of `scene` from `drop` m. `landed`: the place where its centre comes
// to rest.
LandingOutcome land(Scene scene, const Body& lands, double drop, Point landed) {
  scene.prototypes = {lands};
  scene.prototypes[0].name = "falling";
  scene.inputs = {engine::InputKind::spawn};
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 120);
  std::vector<BodyReport> rest = engine->bodies();
  engine::Input spawn;
  spawn.kind = engine::InputKind::spawn;
  spawn.values[0] = landed.x;
  spawn.values[1] = landed.y + drop;
  Bytes input;
  engine::encode_inputs({spawn}, input);
  REQUIRE(engine->step({scene.settings.dt, input}, nullptr));
  rest.push_back(engine->bodies().back());
  rest.back().center = landed;
  return watch(*engine, rest, 300);
}

// Checks that the bodies stay in place and gain no energy.
void check_landing(const Scene& scene, const Body& lands, double drop, Point landed) {
  CAPTURE(drop, landed.x);
  const LandingOutcome outcome = land(scene, lands, drop, landed);
  CHECK(outcome.last.y == Approx(landed.y).margin(0.01));
  const double mass = 4 * lands.shapes[0].half_size.x * lands.shapes[0].half_size.y;
  CHECK(outcome.energy_max < 1.01 * gravity * mass * drop);
  CHECK(outcome.moved_max < slop);
}

}  // namespace

TEST_CASE("a box lands on a resting tower and nothing but the box moves", "[engine][stack][resting_impacts]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const int count : {3, 5, 10, 20}) {
      CAPTURE(precision, count);
      for (const double drop : drops)
        check_landing(towers_scene(count, {0}, precision), unit_box({0, 0}), drop, {0, count + 0.5});
    }
}

TEST_CASE("a box lands beside the middle of a resting tower and nothing but the box moves",
          "[engine][stack][resting_impacts]") {
  for (const int count : {3, 5})
    for (const double drop : drops) check_landing(towers_scene(count, {0}), unit_box({0, 0}), drop, {0.3, count + 0.5});
  for (const double drop : drops) check_landing(towers_scene(10, {0}), unit_box({0, 0}), drop, {0.1, 10.5});
}

TEST_CASE("within a budget, a box lands on a resting tower and nothing but the box moves",
          "[engine][stack][resting_impacts][budget]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const int count : {3, 10, 20, 40})
      for (const double aside : {0.0, 0.3, 0.45})
        for (const double drop : drops) {
          if (count == 3 && aside > 0.3) continue;  // the box topples
          CAPTURE(precision, count, aside);
          Scene scene = towers_scene(count, {0}, precision);
          scene.settings.substep_budget = budget;
          check_landing(scene, unit_box({0, 0}), drop, {aside, count + 0.5});
        }
}

// Rigid boxes would not move at all. The impulse passes down through every box, so both contact points below take a
// share, and all velocities stay zero. Any movement of the tower is an error: it leans under the new load.
TEST_CASE("a box lands far beside the middle of a tall tower and nothing but the box moves",
          "[engine][stack][resting_impacts]") {
  for (const double target : {0.005, 0.0005})
    for (const int count : {10, 20, 40})
      for (const double aside : {0.3, 0.45})
        for (const double drop : drops) {
          CAPTURE(target, count, aside);
          Scene scene = towers_scene(count, {0});
          scene.settings.auto_substeps->target_error = target;
          check_landing(scene, unit_box({0, 0}), drop, {aside, count + 0.5});
        }
}

TEST_CASE("a plank lands on two resting towers and nothing but the plank moves", "[engine][stack][resting_impacts]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    CAPTURE(precision);
    for (const double drop : drops)
      check_landing(towers_scene(10, {0, 4}, precision), body_of(box_shape(2.5, 0.1), {0, 0}), drop, {2, 10.1});
  }
}

TEST_CASE("a box that slides against a resting tower adds no energy and pushes it no farther than friction lets it",
          "[engine][stack][resting_impacts]") {
  const double friction = 0.6;
  for (const int count : {3, 10})
    for (const double speed : {0.2, 1.0, 3.0}) {  // m/s at the impact on the tower
      CAPTURE(count, speed);
      Scene scene = towers_scene(count, {0});
      const double way = 1;
      Body slider = unit_box({-1 - way, 0.5});
      slider.velocity.x = std::sqrt(speed * speed + 2 * friction * gravity * way);
      scene.bodies.push_back(slider);
      for (Body& body : scene.bodies) body.shapes[0].material.friction = friction;
      const auto engine = make_engine_or_fail(scene);
      const std::vector<BodyReport> rest = engine->bodies();
      const LandingOutcome outcome = watch(*engine, rest, 300);
      CHECK(outcome.energy_max < 1.01 * 0.5 * slider.velocity.x * slider.velocity.x);
      // In the worst case the lowest box takes half the speed at once. Friction above and below it, and below the
      // slider, then stops both.
      const double braked = friction * gravity * (2.0 * count) / 2;
      CHECK(outcome.moved_max < slop + speed * speed / 4 / (2 * braked));
    }
}

TEST_CASE("boxes that land on a bridge of pinned planks get no energy from nowhere",
          "[engine][resting_impacts][joints]") {
  constexpr int plank_count = 6;
  for (const double half : {0.2, 0.5})
    for (const double drop : {0.5, 2.0}) {
      Scene scene = empty_scene(Precision::f32);
      scene.settings.auto_substeps.emplace();
      scene.bodies.push_back(body_of(box_shape(0.5, 0.5), {-0.5, 0}, BodyType::static_body));
      for (int i = 0; i < plank_count; ++i) scene.bodies.push_back(body_of(box_shape(0.5, 0.1), {0.5 + i, 0}));
      scene.bodies.push_back(body_of(box_shape(0.5, 0.5), {plank_count + 0.5, 0}, BodyType::static_body));
      for (std::uint32_t i = 0; i <= plank_count; ++i) {
        Joint& pin = scene.joints.emplace_back(joint_of(JointKind::revolute, i, i + 1));
        pin.anchor_a = {0.5, 0};
        pin.anchor_b = {-0.5, 0};
      }
      for (const double x : {1.7, 3.7}) scene.bodies.push_back(body_of(box_shape(half, half), {x, 0.1 + half + drop}));
      const auto engine = make_engine_or_fail(scene);
      const std::vector<BodyReport> start = engine->bodies();
      CAPTURE(half, drop);
      const double fall = gravity * 2 * 4 * half * half * drop;
      CHECK(watch(*engine, start, 300).energy_max < 0.01 * fall);
    }
}

TEST_CASE("boxes that begin deep inside the ground and each other make states that load again",
          "[engine][resting_impacts]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    Random random(5);
    for (int heap = 0; heap < 300; ++heap) {
      Scene scene = empty_scene(precision);
      scene.settings.auto_substeps.emplace();
      scene.bodies.push_back(body_of(box_shape(20, 1), {0, 0}, BodyType::static_body));
      const auto put = [&](double half_height, double y, double angle) {
        Body& body = scene.bodies.emplace_back(
            body_of(box_shape(0.5, half_height), {random.real(-0.01, 0.01), y + random.real(-0.01, 0.01)}));
        body.angle = angle;
      };
      put(0.5, 0.5, 0);
      put(0.5, 0, 0);
      put(0.5, 0, 2);
      put(3e-5, 0, 0);
      const auto engine = make_engine_or_fail(scene);
      const auto copy = make_engine_or_fail(scene);
      CAPTURE(heap);
      for (int tick = 0; tick < 3; ++tick) {
        run_ticks(*engine, 1);
        const Status loads = copy->load(image_of(*engine));
        REQUIRE((loads ? "" : loads.error().message) == "");
      }
    }
  }
}

TEST_CASE("a box that lands on one corner does not sink in with the next", "[engine][impacts][islands]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const double angle : {0.02, 0.05, 0.1, 0.2, 0.4})
      for (const double speed : {3.0, 8.0, 13.0}) {
        CAPTURE(precision, angle, speed);
        Scene scene = stack_scene(3, 0, precision);
        engine::choose_substeps(scene.settings);
        Body box = body_of(box_shape(0.6, 0.4), {0.1, 4.5});
        box.angle = angle;
        box.velocity = {0, -speed};
        scene.bodies.push_back(box);
        const auto engine = make_engine_or_fail(scene);
        double deepest = 0;
        for (int tick = 0; tick < 60; ++tick) {
          run_ticks(*engine, 1);
          for (const engine::ContactReport& contact : engine->contacts())
            for (int i = 0; i < contact.point_count; ++i) deepest = std::max(deepest, -contact.separation[i]);
        }
        CHECK(deepest < 0.02);
      }
}
