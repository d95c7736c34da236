// Large mass ratios and fast rotations with automatic substeps: no error exceeds a hundredth of a body's size.
// SPDX-License-Identifier: MIT
#include <cmath>

#include "tests/support/engine_runs.h"
#include "tests/support/joints.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::BodyReport;
using engine::Engine;

namespace {

constexpr int loaded_ticks = 300;

// The largest distance of a body from its start after the load has come to rest, m.
double moved(Engine& engine) {
  const std::vector<BodyReport> start = engine.bodies();
  for (int i = 0; i < loaded_ticks; ++i) REQUIRE(engine.step({engine.scene().settings.dt, {}}, nullptr));
  const std::vector<BodyReport> now = engine.bodies();
  double most = 0;
  for (std::size_t row = 0; row < now.size(); ++row)
    most =
        std::fmax(most, std::hypot(now[row].center.x - start[row].center.x, now[row].center.y - start[row].center.y));
  return most;
}

// Links of 1 m and 1 kg from a peg at the origin, the last of `end_mass`.
Scene chain_of(int links, Point direction, double end_mass, Precision precision) {
  Scene scene = empty_scene(precision);
  scene.settings.auto_substeps.emplace();
  scene.bodies.push_back(peg({0, 0}));
  for (int i = 0; i < links; ++i) {
    Body link = body_of(box_shape(0.5, 0.1), {(i + 0.5) * direction.x, (i + 0.5) * direction.y});
    link.angle = std::atan2(direction.y, direction.x);
    const double mass = i + 1 == links ? end_mass : 1;
    link.mass = engine::ExplicitMass{mass, mass / 12, {}};
    scene.bodies.push_back(link);
    const auto row = static_cast<std::uint32_t>(i);
    Joint pin = joint_of(JointKind::revolute, row, row + 1);
    if (i > 0) pin.anchor_a = {0.5, 0};
    pin.anchor_b = {-0.5, 0};
    scene.joints.push_back(pin);
  }
  return scene;
}

}  // namespace

TEST_CASE("boxes of 1 kg carry and links of 1 kg hold a million times their mass", "[engine][islands][analytic]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const double ratio : {1e2, 1e4, 1e6})
      for (const int count : {2, 10}) {
        CAPTURE(precision, ratio, count);
        Scene stack = stack_scene(count, 0, precision);
        stack.settings.auto_substeps.emplace();
        stack.bodies.back().mass = engine::ExplicitMass{ratio, {}, {}};
        CHECK(moved(*make_engine_or_fail(stack)) < 0.01);
        CHECK(moved(*make_engine_or_fail(chain_of(count, {0, -1}, ratio, precision))) < 0.01);
      }
}

TEST_CASE("a wide load sinks by no more than a hundredth of the small boxes below it", "[engine][islands][analytic]") {
  Scene scene = empty_scene();
  scene.settings.auto_substeps.emplace();
  scene.bodies.push_back(ground());
  for (const double x : {-9.5, 9.5}) scene.bodies.push_back(unit_box({x, 0.5}));
  scene.bodies.push_back(body_of(box_shape(10, 10), {0, 11}));
  CHECK(moved(*make_engine_or_fail(scene)) < 0.01);
}

TEST_CASE("a weight that whirls on a light arm stays at its distance", "[engine][islands][joints][analytic]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const double spin : {10.0, 30.0}) {
      Scene scene = chain_of(2, {1, 0}, 100, precision);
      scene.gravity = {0, 0};
      for (Body& body : scene.bodies) {
        if (body.type != BodyType::dynamic_body) continue;
        body.angular_velocity = spin;
        body.velocity = {0, spin * body.position.x};
      }
      const auto engine = make_engine_or_fail(scene);
      double off = 0;
      for (int i = 0; i < loaded_ticks; ++i) {
        REQUIRE(engine->step({scene.settings.dt, {}}, nullptr));
        const Point at = engine->bodies()[2].center;
        off = std::fmax(off, std::fabs(std::hypot(at.x, at.y) - 1.5));
      }
      CAPTURE(precision, spin);
      CHECK(off < 0.01);
    }
}

TEST_CASE("a welded beam bends by no more than is allowed", "[engine][islands][joints][analytic]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const int planks : {2, 4, 6})
      for (const double target : {0.05, 0.01, 0.005}) {
        Scene beam = chain_of(planks, {1, 0}, 1, precision);
        beam.settings.auto_substeps->target_error = target;
        for (Body& body : beam.bodies) body.angular_damping = 1;
        for (Joint& joint : beam.joints) joint.kind = JointKind::weld;
        const auto engine = make_engine_or_fail(beam);
        CAPTURE(precision, planks, target);
        CHECK(moved(*engine) < target * 1);  // of a plank's length
      }
}
