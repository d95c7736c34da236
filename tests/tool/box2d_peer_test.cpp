// The Box2D peer: accepted and refused scenes, and equal motion of bodies and joints in both engines.
// SPDX-License-Identifier: MIT
#include "tool/box2d/box2d_peer.h"

#include <cmath>

#include "engine/math/trig.h"
#include "tests/support/box2d.h"
#include "tests/support/catch.h"
#include "tests/support/joints.h"
#include "tests/support/scenes.h"

using namespace ticktrue;
using namespace ticktrue::test;

namespace {

// The error message; empty without an error.
std::string refusal_of(const Scene& scene) {
  const auto peer = tool::make_box2d_peer(scene);
  if (peer) return {};
  CHECK(peer.error().code == ErrorCode::unsupported);
  return peer.error().message;
}

}  // namespace

TEST_CASE("the peer takes eight corners, refuses nine, and says why", "[verifier][crosscheck][analytic]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  Scene scene = stack_scene(0);
  scene.bodies.push_back(body_of(polygon_shape(regular_polygon(8, 1)), {0, 2}));
  CHECK(refusal_of(scene).empty());
  scene.bodies.push_back(body_of(polygon_shape(regular_polygon(9, 1)), {4, 2}));
  CHECK(refusal_of(scene) == "stack: /bodies/2/shapes/0/vertices: too many for Box2D: found 9, expected at most 8");
}

TEST_CASE("the peer refuses what its skin or its floats would distort", "[verifier][crosscheck][analytic]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  Scene thin = stack_scene(1);
  thin.bodies[1].shapes[0].half_size.y = 0.003;
  CHECK(refusal_of(thin).find("too thin for Box2D's skin") != std::string::npos);
  Scene far = stack_scene(1);
  far.bodies[1].position.x = 1e6;
  CHECK(refusal_of(far).find("too far out") != std::string::npos);
}

TEST_CASE("the peer falls as semi-implicit Euler does and has our masses", "[verifier][crosscheck][analytic]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  Scene scene = empty_scene();
  scene.bodies.push_back(body_of(polygon_shape({{0, 0}, {3, 0}, {0, 3}}), {2, 50}));  // centre of mass at (1, 1)
  scene.bodies[0].mass = engine::ExplicitMass{7, 5.0, Point{0.5, 0.25}};
  auto peer = tool::make_box2d_peer(scene);
  REQUIRE(peer);
  for (int i = 0; i < 60; ++i) (*peer)->step();
  const auto bodies = (*peer)->bodies();
  REQUIRE(bodies.size() == 1);
  CHECK(bodies[0].mass == 7);
  CHECK(bodies[0].inertia == 5);
  CHECK(bodies[0].center.x == Approx(2.5));
  CHECK(bodies[0].center.y == Approx(50.25 - 5 - 10.0 / 60 / 2).margin(1e-4));  // g t^2 / 2 + g h t / 2
  CHECK(bodies[0].velocity.y == Approx(-10).margin(1e-4));
}

TEST_CASE("the peer mixes materials by the rule of the scene", "[verifier][crosscheck][analytic]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  const auto slid = [](engine::MixRule rule) {
    Scene scene = slide_scene(10, 0.8);
    scene.bodies[0].shapes[0].material.friction = 0.2;
    scene.settings.friction_mix = rule;
    auto peer = tool::make_box2d_peer(scene);
    REQUIRE(peer);
    for (int i = 0; i < 400; ++i) (*peer)->step();
    return (*peer)->bodies()[1].center.x;
  };
  // v^2 / (2 mu g), plus the bias of half a step.
  CHECK(slid(engine::MixRule::minimum) == Approx(25).epsilon(0.01));
  CHECK(slid(engine::MixRule::geometric_mean) == Approx(12.5).epsilon(0.01));
  CHECK(slid(engine::MixRule::average) == Approx(10).epsilon(0.01));
  CHECK(slid(engine::MixRule::maximum) == Approx(6.25).epsilon(0.015));
}

TEST_CASE("the peer refuses capsules, rounded lines, rolling resistance and filters of 32 bits",
          "[verifier][crosscheck][analytic]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  const auto refusal = [](auto change) {
    Scene scene = stack_scene(1);
    change(scene.bodies[1].shapes[0]);
    return refusal_of(scene);
  };
  using Catch::Matchers::Contains;
  CHECK(refusal([](Shape&) {}).empty());
  CHECK_THAT(refusal([](Shape& s) { s = capsule_shape({-1, 0}, {1, 0}, 0.5); }), Contains("no capsules"));
  CHECK(refusal([](Shape& s) { s.radius = 0.1; }).empty());
  CHECK_THAT(refusal([](Shape& s) {
               s = segment_shape({-1, 0}, {1, 0}), s.radius = 0.1;
             }),
             Contains("rounds no lines"));
  CHECK_THAT(refusal([](Shape& s) { s.material.rolling_resistance = 0.1; }), Contains("rolling resistance"));
  CHECK_THAT(refusal([](Shape& s) { s.filter.category = 0x10000; }), Contains("16 bits"));
  CHECK_THAT(refusal([](Shape& s) { s.filter.mask = 0x1ffff; }), Contains("16 bits"));
  CHECK_THAT(refusal([](Shape& s) { s.filter.group = 40000; }), Contains("16 bits"));
  CHECK(refusal([](Shape& s) { s.filter = {0x8000, 0xffff, -5}; }).empty());
}

TEST_CASE("chains, segments, filters, sensors and conveyors mean the same to the peer",
          "[verifier][crosscheck][equivalence]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  const std::vector<Point> to_left{{8, 0}, {4, 0}, {0, 0}, {-8, 0}};
  const std::vector<Point> to_right(to_left.rbegin(), to_left.rend());
  const auto agree = [](const Shape& line, auto change) {
    Scene scene = empty_scene();
    scene.bodies = {body_of(line, {0, 0}, BodyType::static_body), unit_box({-1, 0.6})};
    change(scene);
    auto peer = tool::make_box2d_peer(scene);
    REQUIRE(peer);
    const auto own = engine::make_engine(scene);
    REQUIRE(own);
    for (int i = 0; i < 90; ++i) {
      (*peer)->step();
      REQUIRE((*own)->step({scene.settings.dt, {}}, nullptr));
    }
    const auto a = (*own)->bodies()[1], b = (*peer)->bodies()[1];
    // After a fall of 1.5 s the engines differ by g h t / 2 = 0.1 m. Box2D also pushes out bodies that are halfway
    // through a chain from behind.
    CHECK(a.center.y == Approx(b.center.y).margin(a.center.y > 0 ? 0.02 : 0.5));
    CHECK(a.center.x == Approx(b.center.x).margin(0.1));
    CHECK(a.velocity.x == Approx(b.velocity.x).margin(0.02));
    return a;
  };
  const auto nothing = [](Scene&) {};
  CHECK(agree(chain_shape(to_left), nothing).center.y > 0.4);
  CHECK(agree(chain_shape(to_right), nothing).center.y < -5);
  CHECK(agree(segment_shape({-8, 0}, {8, 0}), nothing).center.y > 0.4);
  CHECK(agree(segment_shape({8, 0}, {-8, 0}), nothing).center.y > 0.4);
  const auto sensor = [](Scene& s) { s.bodies[0].shapes[0].sensor = true; };
  CHECK(agree(chain_shape(to_left), sensor).center.y < -5);
  const auto filter = [](Scene& s) { s.bodies[1].shapes[0].filter = {2, 2, 0}; };
  CHECK(agree(chain_shape(to_left), filter).center.y < -5);
  const auto conveyor = [](Scene& s) { s.bodies[0].shapes[0].material.tangent_speed = 2; };
  CHECK(agree(chain_shape(to_left), conveyor).velocity.x == Approx(-2).margin(0.01));
}

TEST_CASE("the peer scales worlds of large bodies and gives their own units back", "[verifier][crosscheck][analytic]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  Scene scene = stack_scene(2);
  for (Body& body : scene.bodies) {
    body.position = {50 * body.position.x, 50 * body.position.y};
    body.shapes[0].half_size = {50 * body.shapes[0].half_size.x, 50 * body.shapes[0].half_size.y};
  }
  scene.gravity = {0, -500};
  auto peer = tool::make_box2d_peer(scene);
  REQUIRE(peer);
  CHECK((*peer)->length_scale() == 1.0 / 64);
  for (int i = 0; i < 120; ++i) (*peer)->step();
  CHECK((*peer)->bodies()[2].center.y == Approx(75).epsilon(0.03));
  double up = 0;
  for (const engine::ContactReport& contact : (*peer)->contacts())
    if (contact.body_a == 0 || contact.body_b == 0) up += contact.normal_force[0] + contact.normal_force[1];
  CHECK(up == Approx(2 * 2500 * 500.0).epsilon(0.001));
}

TEST_CASE("the peer removes what leaves the bounds and tells when Box2D cuts a movement",
          "[verifier][crosscheck][analytic]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  Scene scene = empty_scene();
  scene.bodies = {unit_box({0, 0}), unit_box({10, 0})};
  scene.bodies[1].velocity.x = 130;  // more than 2 m per step
  scene.bounds = engine::Bounds{{-5, -5}, {100, 5}};
  auto peer = tool::make_box2d_peer(scene);
  REQUIRE(peer);
  (*peer)->step();
  CHECK((*peer)->clamped_tick() == 1);
  for (int i = 0; i < 60; ++i) (*peer)->step();
  CHECK((*peer)->bodies().empty());
}

namespace {

/// Both engines after some seconds, with 64 substeps in the engine and 64 steps per tick in Box2D.
struct Both {
  std::vector<engine::BodyReport> ours;
  std::vector<engine::BodyReport> box2d;
};
Both run_both(Scene scene, double seconds) {
  constexpr int step_count = 64;
  scene.settings.substeps = step_count;
  tool::Box2dOptions options;
  options.steps_per_tick = step_count;
  auto peer = tool::make_box2d_peer(scene, options);
  INFO((peer ? "" : peer.error().message));
  REQUIRE(peer);
  const auto own = engine::make_engine(scene);
  INFO((own ? "" : own.error().message));
  REQUIRE(own);
  for (int i = 0; i < static_cast<int>(std::lround(seconds / scene.settings.dt)); ++i) {
    (*peer)->step();
    REQUIRE((*own)->step({scene.settings.dt, {}}, nullptr));
  }
  return {(*own)->bodies(), (*peer)->bodies()};
}

void check_same(const Both& both, double margin) {
  REQUIRE(both.ours.size() == both.box2d.size());
  for (std::size_t i = 0; i < both.ours.size(); ++i) {
    CAPTURE(i);
    CHECK(both.ours[i].center.x == Approx(both.box2d[i].center.x).margin(margin));
    CHECK(both.ours[i].center.y == Approx(both.box2d[i].center.y).margin(margin));
    CHECK(std::remainder(both.ours[i].angle - both.box2d[i].angle, 2 * engine::pi) == Approx(0).margin(2 * margin));
  }
}

/// A block at the origin and a bar of 1 m beside it. The centre of the bar is 0.5 m away.
Scene bar_scene(JointKind kind) {
  Scene scene = empty_scene();
  scene.bodies = {peg({0, 0}), body_of(box_shape(0.5, 0.1), {0.5, 0})};
  scene.bodies[1].mass = engine::ExplicitMass{2, 0.5, {}};
  scene.joints = {joint_of(kind, 0, 1)};
  scene.joints[0].anchor_b = {-0.5, 0};
  return scene;
}

}  // namespace

TEST_CASE("a pendulum of the peer swings as ours does, on a pin and on a rod", "[verifier][crosscheck][equivalence]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  check_same(run_both(bar_scene(JointKind::revolute), 2), 0.01);
  Scene rod = bar_scene(JointKind::distance);
  rod.joints[0].anchor_b = {};
  rod.joints[0].length = 0.5;
  check_same(run_both(rod, 2), 0.01);
}

TEST_CASE("motors and limits of the peer are ours", "[verifier][crosscheck][equivalence]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  Scene turning = bar_scene(JointKind::revolute);
  turning.gravity = {0, 0};
  turning.joints[0].motor = engine::JointMotor{2, 1};
  const Both driven = run_both(turning, 1);
  check_same(driven, 0.005);
  CHECK(driven.box2d[1].angular_velocity == Approx(1).epsilon(0.02));  // torque / (I + m l^2) = 1 / (0.5 + 0.5)
  turning.joints[0].limits = engine::Range{-0.25, 0.25};
  const Both stopped = run_both(turning, 4);
  check_same(stopped, 0.005);
  CHECK(stopped.box2d[1].angle == Approx(0.25).margin(0.01));
  turning.joints[0].reference_angle = 2 * engine::pi;  // the same angle after a full turn
  check_same(run_both(turning, 4), 0.005);

  Scene sliding = bar_scene(JointKind::prismatic);
  sliding.joints[0].anchor_a = {0, 0};
  sliding.joints[0].axis = {3, 4};
  sliding.joints[0].motor = engine::JointMotor{1, 100};
  check_same(run_both(sliding, 1), 0.005);
  sliding.joints[0].limits = engine::Range{0, 0.5};
  check_same(run_both(sliding, 3), 0.005);

  Scene rope = bar_scene(JointKind::distance);
  rope.joints[0].anchor_b = {};
  rope.joints[0].limits = engine::Range{0, 1};
  rope.bodies[1].angular_damping = 1;
  rope.bodies[1].linear_damping = 2;
  check_same(run_both(rope, 8), 0.01);
}

TEST_CASE("springs of the peer are ours: hertz by the joint's own mass, and absolute ones",
          "[verifier][crosscheck][equivalence]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  const engine::JointSpring soft{false, 2, 0.3, 0, 0};
  for (const JointKind kind : {JointKind::distance, JointKind::wheel, JointKind::weld}) {
    CAPTURE(static_cast<int>(kind));
    for (const auto& spring : {soft, engine::JointSpring{true, 0, 0, 150, 4}}) {
      Scene scene = bar_scene(kind);
      if (kind == JointKind::distance) scene.joints[0].anchor_a = {0, 0.5};
      if (kind == JointKind::distance) scene.joints[0].length = 0.5;
      if (kind == JointKind::wheel)
        scene.joints[0].axis = {0, 1}, scene.joints[0].anchor_b = {}, scene.joints[0].anchor_a = {0.5, 0};
      scene.joints[0].spring = spring;
      scene.bodies[1].angular_damping = kind == JointKind::distance ? 3 : 0;
      scene.bodies[1].linear_damping = kind == JointKind::distance ? 3 : 0;
      check_same(run_both(scene, kind == JointKind::distance ? 12 : 3), 0.01);
    }
  }
  Scene pulled = bar_scene(JointKind::target);
  pulled.joints[0].anchor_b = {};
  pulled.joints[0].anchor_a = {};
  pulled.joints[0].offset = {2, 1};
  pulled.joints[0].force_max = 60;
  pulled.joints[0].spring = engine::JointSpring{false, 2, 0.7, 0, 0};
  check_same(run_both(pulled, 4), 0.01);
}

TEST_CASE("motor and friction joints of the peer are ours", "[verifier][crosscheck][equivalence]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  Scene held = bar_scene(JointKind::motor);
  held.joints[0].anchor_b = {};
  held.joints[0].offset = {1, 0.5};
  held.joints[0].angle_offset = 0.5;
  held.joints[0].force_max = 60;
  held.joints[0].torque_max = 5;
  held.joints[0].spring = engine::JointSpring{false, 60, engine::pi / 0.2, 0, 0};
  check_same(run_both(held, 3), 0.02);
  Scene braked = bar_scene(JointKind::friction);
  braked.joints[0].anchor_b = {};
  braked.joints[0].force_max = 12;
  braked.joints[0].torque_max = 0.5;
  braked.bodies[1].angular_velocity = 2;
  check_same(run_both(braked, 1), 0.01);
}

TEST_CASE("pulleys of the peer are ours: Atwood machines, swings, a bar at its end",
          "[verifier][crosscheck][equivalence]") {
  if (!has_box2d()) return;
  for (const double ratio : {1.0, 2.0}) {
    CAPTURE(ratio);
    Scene scene = bar_scene(JointKind::pulley);
    scene.bodies[0] = body_of(box_shape(0.2, 0.2), {-2, 0});
    scene.bodies[0].mass = engine::ExplicitMass{3, 0.2, {}};
    scene.joints[0].anchor_a = {0, 0.2};
    scene.joints[0].anchor_b = {};
    scene.joints[0].ground_anchor_a = {-2, 4.2};
    scene.joints[0].ground_anchor_b = {0.5, 4};
    scene.joints[0].ratio = ratio;
    scene.joints[0].length = 4 + 4 * ratio;
    const Both atwood = run_both(scene, 1);
    check_same(atwood, 0.005);
    const double a = 10 * ratio * (ratio * 3 - 2) / (2 + ratio * ratio * 3);
    CHECK(atwood.box2d[0].velocity.y == Approx(-a).epsilon(0.01));
    scene.bodies[0].velocity = {1, 0};
    scene.bodies[1].velocity = {-2, 0};
    check_same(run_both(scene, 1), 0.01);
    scene.joints[0].anchor_b = {-0.5, 0};
    scene.joints[0].ground_anchor_b = {0, 4};
    check_same(run_both(scene, 0.5), 0.01);
  }
  Scene none = bar_scene(JointKind::pulley);  // B's side has no direction
  none.joints[0].anchor_b = {};
  none.joints[0].ground_anchor_a = {0, 10};
  none.joints[0].ground_anchor_b = {0.5, 0};
  none.joints[0].length = 10;                   // in both engines, a side of 5 cm is short
  const Both falling = run_both(none, 0.0833);  // 3.5 cm
  check_same(falling, 0.005);
  CHECK(falling.ours[1].velocity.y == Approx(-10 * 5 / 60.0).epsilon(0.01));
}

TEST_CASE("gears of the peer are ours: pairs of discs, racks, and a removed body",
          "[verifier][crosscheck][equivalence]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  for (const double ratio : {1.0, -2.0, 0.5})
    for (const bool is_rack : {false, true})
      for (const bool is_first : {false, true}) {
        CAPTURE(ratio, is_rack, is_first);
        Scene scene = bar_scene(JointKind::revolute);  // a pendulum drives the gears
        scene.bodies.push_back(body_of(box_shape(0.2, 0.2), {3, 0}));
        scene.bodies[2].mass = engine::ExplicitMass{1, 0.3, {}};
        Joint other = joint_of(is_rack ? JointKind::prismatic : JointKind::revolute, 0, 2);
        other.anchor_a = {3, 0};
        if (is_rack) other.axis = {1, 0};
        scene.joints.push_back(other);
        Joint gear;
        gear.kind = JointKind::gear;
        gear.joint_a = is_first ? 0 : 1;
        gear.joint_b = is_first ? 1 : 0;
        gear.ratio = ratio;
        scene.joints.push_back(gear);
        const Both both = run_both(scene, 1.5);
        check_same(both, 0.02);
        CHECK(std::fabs(is_rack ? both.ours[2].center.x - 3 : both.ours[2].angle) > 0.05);
      }
  // The bar swings out of the bounds and takes its pin and the gear along. The other disc turns on.
  Scene leaving = bar_scene(JointKind::revolute);
  leaving.bodies.push_back(body_of(box_shape(0.2, 0.2), {3, 0}));
  leaving.joints.push_back(joint_of(JointKind::revolute, 0, 2));
  leaving.joints[1].anchor_a = {3, 0};
  Joint gear;
  gear.kind = JointKind::gear;
  gear.joint_b = 1;
  leaving.joints.push_back(gear);
  leaving.bounds = engine::Bounds{{-5, -0.3}, {5, 5}};
  const Both left = run_both(leaving, 1);
  REQUIRE(left.ours.size() == 2);
  REQUIRE(left.box2d.size() == 2);
  CHECK(left.box2d[1].angular_velocity == Approx(left.ours[1].angular_velocity).epsilon(0.05));
  CHECK(std::fabs(left.ours[1].angular_velocity) > 1);
}

TEST_CASE("the peer refuses gears whose joints share a moving body", "[verifier][crosscheck][analytic]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  Scene scene = bar_scene(JointKind::revolute);
  scene.bodies.push_back(body_of(box_shape(0.2, 0.2), {1, 0}));
  scene.joints.push_back(joint_of(JointKind::revolute, 1, 2));
  scene.joints[1].anchor_a = {0.5, 0};
  Joint gear;
  gear.kind = JointKind::gear;
  gear.joint_b = 1;
  scene.joints.push_back(gear);
  const auto peer = tool::make_box2d_peer(scene, {});
  REQUIRE_FALSE(peer.has_value());
  CHECK(peer.error().message.find("/joints/2: Box2D 2.4.1 has no gears whose joints share a moving body") !=
        std::string::npos);
}

TEST_CASE("the peer refuses joints that Box2D 2.4.1 does not have, and forces", "[verifier][crosscheck][analytic]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  using Catch::Matchers::Contains;
  const auto refusal = [](JointKind kind, auto change) {
    Scene scene = bar_scene(kind);
    change(scene.joints[0]);
    return refusal_of(scene);
  };
  const auto spring = [](Joint& j) { j.spring = engine::JointSpring{false, 2, 0.5, 0, 0}; };
  CHECK_THAT(refusal(JointKind::revolute, spring), Contains("/joints/0") && Contains("no springs"));
  CHECK_THAT(refusal(JointKind::prismatic, spring), Contains("no springs"));
  CHECK_THAT(refusal(JointKind::motor, spring), Contains("swing"));
  CHECK_THAT(refusal(JointKind::weld, [](Joint& j) { j.linear_spring = absolute_spring(9); }), Contains("no springs"));
  CHECK_THAT(refusal(JointKind::distance, [](Joint& j) { j.motor = engine::JointMotor{1, 1}; }), Contains("no motors"));
  CHECK_THAT(refusal(JointKind::wheel, [](Joint& j) { j.spring = absolute_spring(0, 1); }), Contains("damper"));
  CHECK_THAT(refusal(JointKind::target, [](Joint&) {}), Contains("mouse"));
  Scene windy = bar_scene(JointKind::revolute);
  windy.forces.emplace_back();
  CHECK_THAT(refusal_of(windy), Contains("no force elements"));
}
