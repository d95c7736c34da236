// Box2D 3 as a peer: motion with known answers, equal motion in both engines, refused scenes.
// SPDX-License-Identifier: MIT
#include "tool/box2d3/box2d3_peer.h"

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/engine.h"
#include "engine/math/trig.h"
#include "tests/support/box2d.h"
#include "tests/support/box2d3.h"
#include "tests/support/joints.h"
#include "tests/support/scenes.h"
#include "tool/crosscheck/crosscheck.h"
#include "tool/study/worlds.h"

using namespace ticktrue;
using namespace ticktrue::test;

namespace {

using engine::BodyReport;

// The bodies after the ticks.
std::vector<BodyReport> run_box2d3(const Scene& scene, std::uint64_t tick_count,
                                   const tool::Box2d3Options& options = {}) {
  tool::Box2d3Plan plan;
  plan.tick_count = tick_count;
  auto peer = tool::make_box2d3_peer(scene, options, plan);
  if (!peer) FAIL(peer.error().message + "\n" + peer.error().hint);
  for (std::uint64_t i = 0; i < tick_count; ++i) (*peer)->step();
  return (*peer)->bodies();
}

std::vector<BodyReport> run_own(const Scene& scene, std::uint64_t tick_count) {
  const auto own = engine::make_engine(scene);
  if (!own) FAIL(own.error().message);
  for (std::uint64_t i = 0; i < tick_count; ++i) REQUIRE((*own)->step({scene.settings.dt, {}}, nullptr));
  return (*own)->bodies();
}

// Both engines move each body to the same place with as many substeps, within `margin` m and rad.
void check_equal_motion(const Scene& scene, std::uint64_t tick_count, double margin) {
  tool::Box2d3Options options;
  options.substeps = scene.settings.substeps;
  const std::vector<BodyReport> peer = run_box2d3(scene, tick_count, options);
  const std::vector<BodyReport> own = run_own(scene, tick_count);
  REQUIRE(peer.size() == own.size());
  for (std::size_t i = 0; i < own.size(); ++i) {
    INFO("body " << i);
    CHECK(peer[i].id == own[i].id);
    CHECK(peer[i].center.x == Approx(own[i].center.x).margin(margin));
    CHECK(peer[i].center.y == Approx(own[i].center.y).margin(margin));
    CHECK(std::remainder(peer[i].angle - own[i].angle, 2 * engine::pi) == Approx(0).margin(margin));
  }
}

// The error message; empty without an error.
std::string refusal_of(const Scene& scene) {
  const auto peer = tool::make_box2d3_peer(scene, {}, {});
  if (peer) return {};
  CHECK(peer.error().code == ErrorCode::unsupported);
  return peer.error().message;
}

}  // namespace

TEST_CASE("a falling body has our masses, and falls alike in both versions of Box2D",
          "[verifier][crosscheck][box2d3][analytic]") {
  SKIP_UNLESS(has_box2d3(), "no node, or no box2d3-wasm (./dev setup box2d3)");
  Scene scene = empty_scene();
  scene.bodies.push_back(body_of(polygon_shape({{0, 0}, {3, 0}, {0, 3}}), {2, 50}));  // centre of mass at (1, 1)
  scene.bodies[0].mass = engine::ExplicitMass{7, 5.0, Point{0.5, 0.25}};
  scene.bodies[0].angular_velocity = 1;
  const std::vector<BodyReport> bodies = run_box2d3(scene, 60);
  REQUIRE(bodies.size() == 1);
  CHECK(bodies[0].mass == 7);
  CHECK(bodies[0].inertia == 5);
  CHECK(bodies[0].center.x == Approx(2.5).margin(1e-4));
  // g t^2 / 2 + g h t / 2, with h the substep of each engine.
  const double exact = 50.25 - 5;
  CHECK(bodies[0].center.y == Approx(exact - 10.0 / 240 / 2).margin(1e-4));
  CHECK(bodies[0].velocity.y == Approx(-10).margin(1e-4));
  CHECK(bodies[0].angle == Approx(1).margin(1e-3));
  if (!has_box2d()) return;
  auto older = tool::make_box2d_peer(scene);
  REQUIRE(older);
  for (int i = 0; i < 60; ++i) (*older)->step();
  CHECK((*older)->bodies()[0].center.y == Approx(exact - 10.0 / 60 / 2).margin(1e-4));
  CHECK((*older)->bodies()[0].angle == Approx(bodies[0].angle).margin(1e-3));
}

TEST_CASE("in Box2D 3 a stack stands, its forces carry its weights, and lengths may be scaled",
          "[verifier][crosscheck][box2d3][analytic]") {
  SKIP_UNLESS(has_box2d3(), "no node, or no box2d3-wasm (./dev setup box2d3)");
  for (const double size : {1.0, 0.01}) {
    INFO("size " << size);
    Scene scene = stack_scene(5);
    for (Body& body : scene.bodies) {
      body.position.x *= size;
      body.position.y *= size;
      body.shapes[0].half_size.x *= size;
      body.shapes[0].half_size.y *= size;
      if (body.type == BodyType::dynamic_body) body.mass = engine::ExplicitMass{1, {}, {}};
    }
    scene.gravity.y *= size;  // the same motion, smaller
    tool::Box2d3Plan plan;
    plan.tick_count = 240;
    plan.contact_window = 1;
    auto peer = tool::make_box2d3_peer(scene, {}, plan);
    if (!peer) FAIL(peer.error().message);
    CHECK(((*peer)->length_scale() == 1) == (size == 1));
    for (int i = 0; i < 240; ++i) (*peer)->step();
    const auto bodies = (*peer)->bodies();
    REQUIRE(bodies.size() == 6);
    for (int i = 1; i <= 5; ++i)
      CHECK(bodies[static_cast<std::size_t>(i)].center.y == Approx((i - 0.5) * size).margin(0.01 * size));
    const auto contacts = (*peer)->contacts();
    CHECK(contacts.size() == 5);
    for (const engine::ContactReport& contact : contacts) {
      const std::uint32_t upper = contact.normal.y > 0 ? contact.body_b : contact.body_a;
      INFO("under body " << upper);
      CHECK(contact.point_count == 2);
      CHECK(contact.normal_force[0] + contact.normal_force[1] ==
            Approx((6 - static_cast<int>(upper)) * 10 * size).epsilon(0.02));
      CHECK(std::fabs(contact.separation[0]) < 0.01 * size);
    }
  }
}

TEST_CASE("kinematic bodies, belts, chains and rules for friction mean the same to Box2D 3",
          "[verifier][crosscheck][box2d3][equivalence]") {
  SKIP_UNLESS(has_box2d3(), "no node, or no box2d3-wasm (./dev setup box2d3)");
  Scene mill = empty_scene();
  Shape arm = box_shape(1, 0.1);
  arm.center = {1, 0};
  mill.bodies = {body_of(arm, {0, 5}, BodyType::kinematic_body)};
  mill.bodies[0].velocity = {0.5, 0};
  mill.bodies[0].angular_velocity = 1;
  check_equal_motion(mill, 1, 3e-4);  // later they differ: Box2D turns the body about its origin
  mill.bodies[0].shapes[0].center = {0, 0};
  check_equal_motion(mill, 60, 1e-3);

  for (const bool is_chain : {false, true}) {
    INFO((is_chain ? "chain" : "box"));
    Scene belt = empty_scene();
    belt.bodies = {
        is_chain ? body_of(chain_shape({{20, 0}, {3, 0}, {-3, 0}, {-20, 0}}), {0, 0}, BodyType::static_body) : ground(),
        unit_box({0, 0.5})};
    belt.bodies[0].shapes[0].material.tangent_speed = 1;
    belt.bodies[0].shapes[0].material.friction = 0.3;
    check_equal_motion(belt, 60, 0.02);
    CHECK(run_own(belt, 60)[1].center.x < -0.5);
  }

  for (const auto rule : {engine::MixRule::minimum, engine::MixRule::average, engine::MixRule::maximum}) {
    Scene slide = slide_scene(5, 0.5);
    slide.bodies[0].shapes[0].material.friction = 0.1;
    slide.settings.friction_mix = rule;
    check_equal_motion(slide, 60, 0.03);
  }
}

TEST_CASE("joints mean the same to Box2D 3", "[verifier][crosscheck][box2d3][equivalence]") {
  SKIP_UNLESS(has_box2d3(), "no node, or no box2d3-wasm (./dev setup box2d3)");
  // Two bodies, one of which is static and turned.
  const auto scene_of = [](Joint joint, Point at) {
    Scene scene = empty_scene();
    scene.settings.substeps = 16;
    scene.bodies = {peg({0, 10}), bob(at, 2, 0.3)};
    scene.bodies[0].angle = 0.4;
    joint.body_a = 0;
    joint.body_b = 1;
    scene.joints = {joint};
    return scene;
  };
  Joint pendulum = joint_of(JointKind::revolute, 0, 1);
  pendulum.anchor_b = {0, 1};
  check_equal_motion(scene_of(pendulum, {0, 9}), 40, 0.03);
  pendulum.reference_angle = -0.4;
  pendulum.motor = engine::JointMotor{2, 100};
  check_equal_motion(scene_of(pendulum, {0, 9}), 40, 0.03);
  pendulum.motor.reset();
  pendulum.limits = engine::Range{-0.2, 0.3};
  Scene pushed = scene_of(pendulum, {0, 9});
  pushed.bodies[1].velocity = {3, 0};
  pushed.bodies[1].angular_velocity = 3;
  check_equal_motion(pushed, 12, 0.03);

  Joint rail = joint_of(JointKind::prismatic, 0, 1);
  rail.axis = {1, 1};
  rail.reference_angle = 0.2;
  Scene on_rail = scene_of(rail, {0, 10});
  on_rail.bodies[1].angle = 0.6;
  check_equal_motion(on_rail, 30, 0.03);
  on_rail.joints[0].motor = engine::JointMotor{1, 100};
  check_equal_motion(on_rail, 30, 0.03);

  Joint weld = joint_of(JointKind::weld, 0, 1);
  weld.anchor_a = {1, 0};
  weld.reference_angle = 0.1;
  Scene welded = scene_of(weld, {std::cos(0.4), 10 + std::sin(0.4)});
  welded.bodies[1].angle = 0.5;
  check_equal_motion(welded, 30, 0.03);

  Joint rod = joint_of(JointKind::distance, 0, 1);
  rod.length = 2;
  check_equal_motion(scene_of(rod, {2, 10}), 30, 0.03);
  rod.spring = engine::JointSpring{false, 1, 0.5, 0, 0};
  check_equal_motion(scene_of(rod, {0, 8}), 30, 0.05);
  rod.spring.reset();
  rod.limits = engine::Range{0, 2};  // a rope: it falls freely until it is taut
  check_equal_motion(scene_of(rod, {0.5, 10}), 20, 0.05);

  Joint wheel = joint_of(JointKind::wheel, 0, 1);
  wheel.axis = {0, 1};
  wheel.spring = engine::JointSpring{false, 1, 0.7, 0, 0};
  wheel.motor = engine::JointMotor{3, 50};
  check_equal_motion(scene_of(wheel, {0, 10}), 30, 0.05);
}

TEST_CASE("Box2D 3 refuses what it lacks by name", "[verifier][crosscheck][box2d3][analytic]") {
  SKIP_UNLESS(has_box2d3(), "no node, or no box2d3-wasm (./dev setup box2d3)");
  using Catch::Matchers::Contains;
  Scene scene = stack_scene(0);
  scene.bodies.push_back(body_of(polygon_shape(regular_polygon(8, 1)), {0, 2}));
  CHECK(refusal_of(scene).empty());
  scene.bodies.push_back(body_of(polygon_shape(regular_polygon(9, 1)), {4, 2}));
  CHECK(refusal_of(scene) == "stack: /bodies/2/shapes/0/vertices: too many for Box2D 3: found 9, expected at most 8");
  Scene welded = stack_scene(1);
  welded.bodies[1].shapes[0] = polygon_shape({{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {0.499, 0.501}, {-0.5, 0.5}});
  CHECK_THAT(refusal_of(welded), Contains("stack: /bodies/1/shapes/0/vertices: Box2D 3 welds or drops some"));

  const auto shape_refusal = [](auto change) {
    Scene changed = stack_scene(1);
    change(changed.bodies[1].shapes[0]);
    return refusal_of(changed);
  };
  CHECK(shape_refusal([](Shape& s) { s = capsule_shape({-1, 0}, {1, 0}, 0.5); }).empty());
  CHECK(shape_refusal([](Shape& s) { s.radius = 0.1; }).empty());
  CHECK(shape_refusal([](Shape& s) { s.filter = {0x80000000, 0xffffffff, -70000}; }).empty());
  CHECK_THAT(shape_refusal([](Shape& s) {
               s = segment_shape({-1, 0}, {1, 0}), s.radius = 0.1;
             }),
             Contains("rounds no lines"));
  Scene far = stack_scene(1);
  far.bodies[1].position.x = 1e6;
  CHECK_THAT(refusal_of(far), Contains("too far out"));
  Scene windy = stack_scene(1);
  windy.forces.emplace_back();
  CHECK_THAT(refusal_of(windy), Contains("stack: /forces: Box2D 3 has no force elements"));

  const auto joint_refusal = [](JointKind kind, auto change) {
    Scene changed = stack_scene(2);
    changed.joints = {joint_of(kind, 1, 2)};
    change(changed.joints[0]);
    return refusal_of(changed);
  };
  const auto as_is = [](Joint&) {};
  CHECK(joint_refusal(JointKind::revolute, as_is).empty());
  CHECK(joint_refusal(JointKind::pulley, as_is) == "stack: /joints/0: Box2D 3 has no pulley joints");
  CHECK(joint_refusal(JointKind::gear, as_is) == "stack: /joints/0: Box2D 3 has no gear joints");
  CHECK(joint_refusal(JointKind::friction, as_is) == "stack: /joints/0: Box2D 3 has no friction joints");
  CHECK(joint_refusal(JointKind::target, as_is) == "stack: /joints/0: Box2D 3 has no mouse joints");
  CHECK_THAT(joint_refusal(JointKind::motor, as_is), Contains("no motor joints"));
  CHECK_THAT(joint_refusal(JointKind::weld, [](Joint& j) { j.spring = absolute_spring(100); }),
             Contains("in hertz only"));
  CHECK_THAT(joint_refusal(JointKind::wheel, [](Joint& j) { j.spring = engine::JointSpring{}; }),
             Contains("damper alone"));
  CHECK_THAT(joint_refusal(JointKind::revolute,
                           [](Joint& j) {
                             j.limits = engine::Range{-4, 1};
                           }),
             Contains("178 degrees"));
  CHECK_THAT(joint_refusal(JointKind::distance,
                           [](Joint& j) {
                             j.motor = engine::JointMotor{1, 1};
                           }),
             Contains("motors in rods"));
}

TEST_CASE("the cross-check judges a stack and refuses a pulley in Box2D 3", "[verifier][crosscheck][box2d3]") {
  SKIP_UNLESS(has_box2d3(), "no node, or no box2d3-wasm (./dev setup box2d3)");
  tool::CrosscheckOptions options;
  options.peer = tool::PeerKind::box2d3;
  options.seed_count = 2;
  options.seconds = 3;
  const auto report = tool::crosscheck(stack_scene(4), options);
  if (!report) FAIL(report.error().message);
  CHECK(report->box2d_version.find("3 (") == 0);
  CHECK(report->box2d_stood == 2);
  REQUIRE(report->solvers.size() == 1);
  CHECK(report->solvers[0].stood == 2);
  CHECK(report->solvers[0].failed == 0);
  CHECK(report->solvers[0].passed >= 8);
  Scene pulled = stack_scene(2);
  pulled.joints = {joint_of(JointKind::pulley, 1, 2)};
  pulled.joints[0].ground_anchor_a = {-1, 10};
  pulled.joints[0].ground_anchor_b = {1, 10};
  pulled.joints[0].length = 20;
  const auto refused = tool::crosscheck(pulled, options);
  if (!refused) FAIL(refused.error().message);
  REQUIRE(refused->rows.size() == 1);
  CHECK(refused->rows[0].verdict == tool::Agreement::not_applicable);
  CHECK(refused->rows[0].reason.find("Box2D 3 has no pulley joints") != std::string::npos);
}

TEST_CASE("an installed Box2D 3 and npm's move a swinging chain and a stack alike", "[verifier][crosscheck][box2d3]") {
  namespace fs = std::filesystem;
  const fs::path program = fs::path(TICKTRUE_TOOL).parent_path() / "ticktrue_box2d3";
  const fs::path folder = fs::path(TICKTRUE_SOURCE_DIR) / "build" / "box2d3";
  SKIP_UNLESS(fs::exists(program), "no Box2D 3 was found when the build was configured");
  SKIP_UNLESS(fs::exists(folder / "node_modules"), "no box2d3-wasm (./dev setup box2d3)");
  for (const Scene& scene : {worlds::chain(Precision::f32, 4, {1, 0}, 1), stack_scene(3)}) {
    std::vector<BodyReport> native, wasm;
    {
      const Variable named(tool::box2d3_variable, program.string());
      native = run_box2d3(scene, 30);
    }
    {
      const Variable named(tool::box2d3_variable, folder.string());
      wasm = run_box2d3(scene, 30);
    }
    REQUIRE(native.size() == wasm.size());
    // Two commits of Box2D 3, half a second: the same motion to a millimetre.
    for (std::size_t i = 0; i < native.size(); ++i) {
      INFO(scene.name << ", body " << i);
      CHECK(native[i].center.x == Approx(wasm[i].center.x).margin(1e-3));
      CHECK(native[i].center.y == Approx(wasm[i].center.y).margin(1e-3));
    }
  }
}
