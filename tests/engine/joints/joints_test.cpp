// Joints against closed forms: pendulums, chains, sliders, motors, ropes, beams, bounded forces, conservation.
// SPDX-License-Identifier: MIT
//
// h is the substep. Under a force F, a rigid constraint yields by C = F K / w^2, w = 2 pi 0.25 / h
// (docs/physics.md, "Joints"). K is its inverse effective mass. The limits below follow from this yield, and from the
// order of semi-implicit Euler.
#include "tests/support/joints.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "engine/math/trig.h"
#include "tests/support/engine_runs.h"
#include "tests/support/joint_gaps.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::BodyReport;
using engine::Engine;
using engine::IntegratorKind;
using engine::pi;

namespace {

double length_of(Point a, Point b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

// w^2 of rigid constraints.
double stiffness_rate(int substeps) {
  const double omega = 2 * pi * 0.25 * substeps / dt;
  return omega * omega;
}

// 60 degrees, equivalent length 1 m: a point on a rod, or a body (0.8 + 0.16 / 0.8 = 1) on a revolute joint.
Scene pendulum_scene(JointKind kind, int substeps, Precision precision) {
  const bool pinned = kind == JointKind::revolute;
  const double angle = pi / 3;
  const double arm = pinned ? 0.8 : 1;
  Scene scene = empty_scene(precision);
  scene.settings.substeps = substeps;
  scene.bodies = {peg({0, 0}), bob({arm * std::sin(angle), -arm * std::cos(angle)}, 1, 0.16)};
  scene.bodies[1].angle = pinned ? angle : 0;
  scene.joints = {joint_of(kind, 0, 1)};
  if (pinned) scene.joints[0].anchor_b = {0, arm};
  return scene;
}

double pendulum_energy(const BodyReport& bob, double arm) {
  const double v2 = bob.velocity.x * bob.velocity.x + bob.velocity.y * bob.velocity.y;
  return 0.5 * v2 + 0.5 * 0.16 * bob.angular_velocity * bob.angular_velocity + 10 * (bob.center.y + arm);
}

// Mean time between passages from right to left in the first 10 s.
double pendulum_period(const Scene& scene) {
  const auto engine = make_engine_or_fail(scene);
  double before = engine->bodies()[1].center.x;
  double first = 0, last = 0;
  int count = 0;
  for (int tick = 0; tick < 600; ++tick) {
    run_ticks(*engine, 1);
    const double x = engine->bodies()[1].center.x;
    if (before > 0 && x <= 0) {
      last = (tick + before / (before - x)) * dt;
      if (count++ == 0) first = last;
    }
    before = x;
  }
  return (last - first) / (count - 1);
}

Scene chain_scene(int links, int substeps) {
  Scene scene = empty_scene();
  scene.settings.substeps = substeps;
  scene.bodies.push_back(peg({0, 0}));
  for (int i = 0; i < links; ++i) {
    scene.bodies.push_back(body_of(box_shape(0.1, 0.5), {0, -0.5 - i}));
    scene.bodies.back().mass = engine::ExplicitMass{1, {}, {}};
    scene.joints.push_back(
        joint_of(JointKind::revolute, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i) + 1));
    scene.joints.back().anchor_a = i == 0 ? Point{0, 0} : Point{0, -0.5};
    scene.joints.back().anchor_b = {0, 0.5};
  }
  return scene;
}

// The distance of the end of a hanging chain below its ideal place.
double chain_sag(int links, int substeps) {
  const auto engine = make_engine_or_fail(chain_scene(links, substeps));
  run_ticks(*engine, 600);
  return (0.5 - links) - engine->bodies().back().center.y;
}

// A body of 2 kg on a horizontal rail, without gravity.
Scene rail_scene(Precision precision) {
  Scene scene = empty_scene(precision);
  scene.gravity = {0, 0};
  scene.bodies = {peg({0, 0}), bob({0, 0}, 2)};
  scene.joints = {joint_of(JointKind::prismatic, 0, 1)};
  return scene;
}

}  // namespace

TEST_CASE("a pendulum on a joint keeps its period and its energy", "[engine][joints][analytic]") {
  for (const JointKind kind : {JointKind::revolute, JointKind::distance})
    for (const Precision precision : {Precision::f32, Precision::f64}) {
      CAPTURE(kind, precision);
      CHECK(std::fabs(pendulum_period(pendulum_scene(kind, 16, precision)) / pendulum_period_60 - 1) < 0.0002);
      CHECK(std::fabs(pendulum_period(pendulum_scene(kind, 4, precision)) / pendulum_period_60 - 1) < 0.0005);
      const auto engine = make_engine_or_fail(pendulum_scene(kind, 4, precision));
      const double arm = kind == JointKind::revolute ? 0.8 : 1;
      const double before = pendulum_energy(engine->bodies()[1], arm);
      run_ticks(*engine, 600);
      const double after = pendulum_energy(engine->bodies()[1], arm);
      CHECK(after / before > 0.94);
      CHECK(after / before < 1.01);
    }
}

TEST_CASE("a double pendulum of rods follows its equations of motion", "[engine][joints][analytic]") {
  // Two points of 1 kg, rods of 1 m, both released at 90 degrees: angles after 1 s. First order in h.
  const auto error = [](int substeps) {
    Scene scene = empty_scene();
    scene.settings.substeps = substeps;
    scene.bodies = {peg({0, 0}), bob({1, 0}), bob({2, 0})};
    scene.joints = {joint_of(JointKind::distance, 0, 1), joint_of(JointKind::distance, 1, 2)};
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 60);
    const auto bodies = engine->bodies();
    const double first = std::atan2(bodies[1].center.x, -bodies[1].center.y);
    const double second =
        std::atan2(bodies[2].center.x - bodies[1].center.x, -(bodies[2].center.y - bodies[1].center.y));
    return std::hypot(first + 0.6629799257481, second + 1.04638763323205);
  };
  const double coarse = error(32);
  const double fine = error(64);
  CHECK(coarse < 0.02);
  CHECK(fine < 0.6 * coarse);
}

TEST_CASE("a hanging chain gives way by the sum of F K / w^2, a quarter for twice the substeps",
          "[engine][joints][analytic]") {
  // Joint i of n carries n - i + 1 links of 10 N; K = 2 / kg between links, 1 / kg at the peg.
  const double load = 200 + 2 * 10 * (19 * 20 / 2);
  double coarser = 0;
  for (const int substeps : {4, 8, 16}) {
    const double sag = chain_sag(20, substeps);
    CAPTURE(substeps, sag);
    CHECK(sag == Approx(load / stiffness_rate(substeps)).epsilon(0.01));
    if (coarser > 0) CHECK(coarser / sag == Approx(4).epsilon(0.02));
    coarser = sag;
  }
}

TEST_CASE("a weight opens its joint by at most F K / w^2, under every integrator", "[engine][joints][integrators]") {
  for (const auto& integrator : engine::integrators) {
    if (!integrator.carries_constraints) continue;
    for (const JointKind kind :
         {JointKind::revolute, JointKind::weld, JointKind::distance, JointKind::prismatic, JointKind::wheel})
      for (const int substeps : {1, 4}) {
        Scene scene = empty_scene(Precision::f64);
        scene.settings.integrator = integrator.kind;
        scene.settings.substeps = substeps;
        scene.bodies = {peg({0, 0}), bob({0, kind == JointKind::distance ? -1.0 : 0.0})};
        scene.joints = {joint_of(kind, 0, 1)};
        CAPTURE(integrator.name, engine::joint_kinds[static_cast<std::size_t>(kind)].name, substeps);
        const auto engine = make_engine_or_fail(scene);
        run_ticks(*engine, 600);
        CHECK(joint_gaps(scene, engine->bodies())[0].gap < 1.01 * 10 / stiffness_rate(substeps));
      }
  }
}

TEST_CASE("two welded planks rest on the floor under integrators with a drift velocity",
          "[engine][joints][integrators]") {
  // The second plank stands out over the end of the first one. They rest 2.6 times as deep as under
  // semi_implicit_euler. They would rest 5.7 times as deep if contacts took no part in the pass for the drift velocity.
  // Direct joints would open by .2 mm if a second turn did not affect the move in full.
  const auto run_planks = [](IntegratorKind integrator, engine::JointSolverKind joints) {
    Scene scene = empty_scene(Precision::f64);
    scene.settings.integrator = integrator;
    scene.settings.joints = joints;
    scene.settings.substeps = 1;
    scene.bodies = {ground(20), body_of(box_shape(1, 0.1), {0, 0.1}), body_of(box_shape(1, 0.1), {1.9, 0.3})};
    scene.joints = {joint_of(JointKind::weld, 1, 2)};
    scene.joints[0].anchor_a = {0.95, 0.1};
    scene.joints[0].anchor_b = {-0.95, -0.1};
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 300);
    const BodyReport plank = engine->bodies()[1];
    const engine::SinCos turn = engine::sin_cos(plank.angle);
    return std::pair{std::fabs(turn.sin) + 0.1 * turn.cos - plank.center.y, joint_gaps(scene, engine->bodies())[0].gap};
  };
  using engine::JointSolverKind;
  const double deep = run_planks(IntegratorKind::semi_implicit_euler, JointSolverKind::iterative).first;
  for (const IntegratorKind integrator : {IntegratorKind::velocity_verlet, IntegratorKind::position_verlet}) {
    CAPTURE(info_of(engine::integrators, integrator).name);
    CHECK(run_planks(integrator, JointSolverKind::iterative).first < 3 * deep);
    CHECK(run_planks(integrator, JointSolverKind::direct).second < 1e-9);
  }
}

TEST_CASE("a torque against a drive opens no joint", "[engine][joints][analytic]") {
  // The point carries nothing but the reaction to the drive, while the body comes to rest.
  for (const JointKind kind : {JointKind::revolute, JointKind::weld})
    for (const bool has_limits : {true, false}) {
      if (kind == JointKind::weld && has_limits) continue;
      Scene scene = empty_scene(Precision::f64);
      scene.gravity = {};
      scene.settings.joints = engine::JointSolverKind::iterative;
      scene.bodies = {peg({0, 0}), body_of(disc_shape(0.0625), {0.25, 0})};
      scene.joints = {joint_of(kind, 0, 1)};
      scene.joints[0].anchor_a = {0.125, 0};
      scene.joints[0].anchor_b = {-0.125, 0};
      if (has_limits) scene.joints[0].limits = engine::Range{-0.25, 0};
      if (!has_limits) scene.joints[0].spring = engine::JointSpring{false, 10, 1, 0, 0};
      engine::Force torque;
      torque.kind = engine::ForceKind::constant;
      torque.body = 1;
      torque.torque = 0.1;
      scene.forces = {torque};
      const auto engine = make_engine_or_fail(scene);
      run_ticks(*engine, 240);
      CAPTURE(info_of(engine::joint_kinds, kind).name, has_limits);
      CHECK(joint_gaps(scene, engine->bodies())[0].gap < 1e-9);
    }
}

TEST_CASE("what slides out on a turning bar stays on it, as r = cosh(w t)", "[engine][joints][analytic]") {
  // The axis turns away from what slides along it. Without a lead for that, softness left .0385 m of gap.
  for (const JointKind kind : {JointKind::wheel, JointKind::prismatic}) {
    Scene scene = empty_scene(Precision::f64);
    scene.gravity = {};
    scene.settings.dt = 0.02;
    scene.settings.substeps = 8;
    scene.settings.joints = engine::JointSolverKind::iterative;
    scene.bodies = {body_of(disc_shape(0.1), {0, 0}, BodyType::kinematic_body), bob({1, 0})};
    scene.bodies[0].angular_velocity = 8;
    scene.bodies[1].velocity = {0, 8};
    scene.bodies[1].angular_velocity = 8;
    scene.joints = {joint_of(kind, 0, 1)};
    scene.joints[0].axis = {1, 0};
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 21);
    const Point at = engine->bodies()[1].center;
    CAPTURE(info_of(engine::joint_kinds, kind).name);
    CHECK(joint_gaps(scene, engine->bodies())[0].gap < 4e-3);
    CHECK(std::hypot(at.x, at.y) == Approx(std::cosh(8 * 0.42)).epsilon(1e-3));
  }
}

TEST_CASE("the peg of a hanging chain carries its weight", "[engine][joints][analytic]") {
  const auto engine = make_engine_or_fail(chain_scene(20, 4));
  run_ticks(*engine, 600);
  CHECK(joint_value(*engine, 0, "linear_force", 1) == Approx(200).epsilon(0.01));
  CHECK(std::fabs(joint_value(*engine, 0, "linear_force", 0)) < 1e-6);
  CHECK(joint_value(*engine, 19, "linear_force", 1) == Approx(10).epsilon(0.01));
}

TEST_CASE("a slider under a constant motor force has exactly its acceleration, and stops at its limit",
          "[engine][joints][analytic]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    Scene scene = rail_scene(precision);
    scene.joints[0].motor = engine::JointMotor{1000, 5};  // never reaches 1000 m/s: acts as a force of 5 N
    scene.joints[0].limits = engine::Range{-1, 3};
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 60);
    const double rounding = precision == Precision::f32 ? 1e-5 : 1e-12;
    const double h = dt / 4;
    CHECK(engine->bodies()[1].velocity.x == Approx(2.5).epsilon(rounding));
    CHECK(engine->bodies()[1].center.x == Approx(0.5 * 2.5 * 1 * (1 + h)).epsilon(rounding));
    CHECK(joint_value(*engine, 0, "motor_force") == Approx(5).epsilon(rounding));
    run_ticks(*engine, 240);
    // At rest against the limit, which yields by at most F K / w^2.
    CHECK(engine->bodies()[1].center.x > 3 - 1e-6);
    CHECK(engine->bodies()[1].center.x < 3 + 5 * 0.5 / stiffness_rate(4) * 1.01 + 1e-6);
    CHECK(std::fabs(engine->bodies()[1].velocity.x) < 1e-5);
    CHECK(joint_value(*engine, 0, "upper_force") == Approx(5).epsilon(1e-4));
    CHECK(joint_value(*engine, 0, "lower_force") == 0);
  }
}

TEST_CASE("a slider neither turns nor leaves its axis", "[engine][joints][analytic]") {
  Scene scene = rail_scene(Precision::f64);
  scene.joints[0].axis = {1, 1};
  scene.gravity = {0, -10};
  scene.bodies[1].angular_velocity = 5;
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 60);
  const BodyReport body = engine->bodies()[1];
  // The body slides down the slope of 45 degrees at g / sqrt(2). The angle constraint absorbs the first spin of 5
  // rad/s.
  CHECK(std::fabs(body.center.x - body.center.y) < 1e-3);
  CHECK(std::fabs(body.angle) < 1e-3);
  const double along = -(body.velocity.x + body.velocity.y) / std::sqrt(2.0);
  CHECK(along == Approx(10 / std::sqrt(2.0)).epsilon(0.001));
}

TEST_CASE("a revolute motor speeds up with its torque until it has its speed", "[engine][joints][analytic]") {
  Scene scene = empty_scene();
  scene.gravity = {0, 0};
  scene.bodies = {peg({0, 0}), bob({0, 0}, 1, 0.5)};
  scene.joints = {joint_of(JointKind::revolute, 0, 1)};
  scene.joints[0].motor = engine::JointMotor{3, 0.75};
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 60);
  CHECK(engine->bodies()[1].angular_velocity == Approx(1.5).epsilon(1e-9));
  run_ticks(*engine, 120);
  CHECK(engine->bodies()[1].angular_velocity == Approx(3).epsilon(1e-9));
  CHECK(std::fabs(joint_value(*engine, 0, "motor_force")) < 1e-9);
}

TEST_CASE("a revolute joint turns to its limits and no further", "[engine][joints][analytic]") {
  Scene scene = empty_scene();
  scene.bodies = {peg({0, 0}), bob({0.5, 0})};
  scene.joints = {joint_of(JointKind::revolute, 0, 1)};
  scene.joints[0].anchor_b = {-0.5, 0};
  scene.joints[0].limits = engine::Range{-0.5, 0.25};
  const auto engine = make_engine_or_fail(scene);
  for (int tick = 0; tick < 300; ++tick) {
    run_ticks(*engine, 1);
    CHECK(engine->bodies()[1].angle > -0.51);
  }
  CHECK(engine->bodies()[1].angle == Approx(-0.5).margin(0.01));
}

TEST_CASE("a rope is slack until it is stretched, and catches what falls", "[engine][joints][analytic]") {
  Scene scene = empty_scene();
  scene.bodies = {peg({0, 0}), bob({0, -1}, 2)};
  Scene free_fall = scene;
  scene.joints = {joint_of(JointKind::distance, 0, 1)};
  scene.joints[0].spring = absolute_spring(0);
  scene.joints[0].limits = engine::Range{0, 2};
  const auto engine = make_engine_or_fail(scene);
  const auto falling = make_engine_or_fail(free_fall);
  for (int tick = 0; tick < 24; ++tick) {  // 1 m takes 0.447 s = 26.8 ticks
    run_ticks(*engine, 1);
    run_ticks(*falling, 1);
    CHECK(engine->bodies()[1].center == falling->bodies()[1].center);
  }
  const double give = 20 * 0.5 / stiffness_rate(4);
  for (int tick = 0; tick < 300; ++tick) {
    run_ticks(*engine, 1);
    CHECK(engine->bodies()[1].center.y > -2 - 2 * give);
  }
  CHECK(engine->bodies()[1].center.y < -2 + 1e-9);
  CHECK(joint_value(*engine, 0, "upper_force") == Approx(20).epsilon(1e-4));
}

TEST_CASE("a beam of welded boxes bends by K (F, T) / w^2 at each weld", "[engine][joints][analytic]") {
  const int count = 6;
  const auto tip_sag = [](int substeps) {
    Scene scene = empty_scene();
    scene.settings.substeps = substeps;
    scene.bodies.push_back(peg({-0.5, 0}));
    for (int i = 0; i < count; ++i) {
      scene.bodies.push_back(body_of(box_shape(0.5, 0.1), {static_cast<double>(i), 0}));
      scene.joints.push_back(
          joint_of(JointKind::weld, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i) + 1));
      scene.joints.back().anchor_a = {i == 0 ? 0 : 0.5, 0};
      scene.joints.back().anchor_b = {-0.5, 0};
    }
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 1200);
    return -engine->bodies().back().center.y;
  };
  // 0.2 kg each. Weld i carries the n boxes after it: F = n W, T = n^2 W / 2 about the weld. K couples gap and angle
  // only at the peg, where one body moves.
  const double mass = 0.2, inertia = mass * (1 + 0.04) / 12, weight = 10 * mass;
  double sag = 0;
  for (int i = 0; i < count; ++i) {
    const int n = count - i;
    const double force = n * weight, torque = n * n * weight / 2;
    const double bodies = i == 0 ? 1 : 2;
    const double coupling = i == 0 ? -0.5 / inertia : 0;
    const double gap = (bodies / mass + bodies * 0.25 / inertia) * force + coupling * torque;
    const double bend = bodies / inertia * torque + coupling * force;
    sag += (gap + bend * (n - 0.5)) / stiffness_rate(1);
  }
  for (const int substeps : {4, 8, 16}) {
    CAPTURE(substeps);
    CHECK(tip_sag(substeps) == Approx(sag / (substeps * substeps)).epsilon(0.02));
  }
}

TEST_CASE("a wheel hangs m g / k below its mount, and turns freely", "[engine][joints][analytic]") {
  Scene scene = empty_scene();
  scene.bodies = {peg({0, 0}), bob({0, 0}, 2)};
  scene.bodies[1].angular_velocity = 3;
  scene.joints = {joint_of(JointKind::wheel, 0, 1)};
  scene.joints[0].axis = {0, 1};
  scene.joints[0].spring = engine::JointSpring{false, 2, 0.7, 0, 0};
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 600);
  const double omega = 2 * pi * 2;
  CHECK(engine->bodies()[1].center.y == Approx(-10 / (omega * omega)).epsilon(0.001));
  CHECK(std::fabs(engine->bodies()[1].center.x) < 1e-9);
  CHECK(engine->bodies()[1].angular_velocity == Approx(3).epsilon(1e-9));
}

TEST_CASE("a motor joint holds its offset and pulls with no more than its force", "[engine][joints][analytic]") {
  Scene scene = empty_scene();
  scene.gravity = {0, 0};
  scene.bodies = {peg({0, 0}), bob({0, 0}, 2, 0.5)};
  scene.joints = {joint_of(JointKind::motor, 0, 1)};
  scene.joints[0].offset = {3, 0};
  scene.joints[0].angle_offset = 1;
  scene.joints[0].force_max = 4;
  scene.joints[0].torque_max = 0.25;
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 30);
  CHECK(engine->bodies()[1].velocity.x == Approx(1).epsilon(0.001));           // 4 N / 2 kg for 0.5 s
  CHECK(engine->bodies()[1].angular_velocity == Approx(0.25).epsilon(0.001));  // 0.25 N m / 0.5 kg m^2 for 0.5 s
  Scene strong = scene;
  strong.joints[0].force_max = 1e5;
  strong.joints[0].torque_max = 1e5;
  const auto held = make_engine_or_fail(strong);
  run_ticks(*held, 300);
  CHECK(held->bodies()[1].center.x == Approx(3).epsilon(1e-6));
  CHECK(held->bodies()[1].angle == Approx(1).epsilon(1e-6));
}

TEST_CASE("a friction joint brakes with exactly its force and torque, then holds", "[engine][joints][analytic]") {
  Scene scene = empty_scene();
  scene.gravity = {0, 0};
  scene.bodies = {peg({0, 0}), bob({1, 0}, 2, 0.5)};
  scene.bodies[1].velocity = {3, 4};
  scene.bodies[1].angular_velocity = 2;
  scene.joints = {joint_of(JointKind::friction, 0, 1)};
  scene.joints[0].force_max = 5;
  scene.joints[0].torque_max = 0.5;
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 60);
  const BodyReport body = engine->bodies()[1];
  CHECK(std::hypot(body.velocity.x, body.velocity.y) == Approx(5 - 2.5).epsilon(1e-9));
  CHECK(body.velocity.x / body.velocity.y == Approx(0.75).epsilon(1e-9));
  CHECK(body.angular_velocity == Approx(1).epsilon(1e-9));
  run_ticks(*engine, 120);
  CHECK(std::fabs(engine->bodies()[1].velocity.x) < 1e-12);
  CHECK(std::fabs(engine->bodies()[1].angular_velocity) < 1e-12);
}

TEST_CASE("a friction joint holds a weight below its force and lets a heavier one slip", "[engine][joints][analytic]") {
  for (const double force_max : {21.0, 15.0}) {
    Scene scene = empty_scene();
    scene.bodies = {peg({0, 0}), bob({1, 0}, 2)};
    scene.joints = {joint_of(JointKind::friction, 0, 1)};
    scene.joints[0].force_max = force_max;
    scene.joints[0].torque_max = 100;
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 60);
    const double slip = force_max > 20 ? 0 : (20 - force_max) / 2;
    CHECK(-engine->bodies()[1].velocity.y == Approx(slip).margin(1e-9));
  }
}

TEST_CASE("a target joint pulls its anchor to the point with no more than its force", "[engine][joints][analytic]") {
  Scene scene = empty_scene();
  scene.bodies = {bob({0, 0}, 2)};
  scene.joints = {joint_of(JointKind::target, 0, 0)};
  scene.joints[0].offset = {1, 2};
  scene.joints[0].anchor_b = {0, 0.1};
  scene.joints[0].force_max = 1e4;
  scene.joints[0].spring = absolute_spring(400, 40);
  scene.bodies[0].angular_damping = 2;  // without damping the body swings about the anchor for a long time
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 600);
  const BodyReport body = engine->bodies()[0];
  CHECK(body.center.x + 0.1 * -std::sin(body.angle) == Approx(1).margin(1e-4));
  CHECK(body.center.y + 0.1 * std::cos(body.angle) == Approx(2 - 20.0 / 400).epsilon(0.001));
  scene.gravity = {0, 0};
  scene.joints[0].force_max = 1;
  scene.joints[0].anchor_b = {0, 0};
  scene.joints[0].offset = {0, 100};
  const auto weak = make_engine_or_fail(scene);
  run_ticks(*weak, 60);
  CHECK(weak->bodies()[0].velocity.y == Approx(0.5).epsilon(1e-9));
}

TEST_CASE("two joined bodies alone keep their momentum and angular momentum", "[engine][joints][conservation]") {
  for (const auto& info : engine::joint_kinds) {
    if (!info.traits.conserves_momentum) continue;  // joins its bodies to the world
    if (info.kind == JointKind::gear) continue;     // gear_test.cpp
    CAPTURE(info.name);
    Scene scene = empty_scene();
    scene.gravity = {0, 0};
    scene.bodies = {bob({0, 0}, 1, 0.3), bob({1, 0.5}, 3, 0.7)};
    scene.bodies[0].velocity = {1, 2};
    scene.bodies[1].velocity = {-2, 1};
    scene.bodies[0].angular_velocity = 3;
    scene.bodies[1].angular_velocity = -1;
    Joint joint = joint_of(info.kind, 0, 1);
    if (info.kind != JointKind::motor && info.kind != JointKind::friction) {
      joint.anchor_a = {0.5, 0.2};
      joint.anchor_b = {-0.5, -0.3};
    }
    joint.limits = engine::Range{-0.1, 0.4};
    joint.motor = engine::JointMotor{2, 1};
    if (info.kind != JointKind::weld) joint.spring = absolute_spring(50, 0.5);
    if (info.kind == JointKind::distance) joint.limits = engine::Range{0.5, 2};
    joint.offset = {1, 1};
    joint.force_max = 20;
    joint.torque_max = 5;
    drop_unused_fields(joint);
    scene.joints = {joint};
    const auto engine = make_engine_or_fail(scene);
    const auto momenta = [&] {
      std::array<double, 3> sum{};
      for (const BodyReport& b : engine->bodies()) {
        sum[0] += b.mass * b.velocity.x;
        sum[1] += b.mass * b.velocity.y;
        sum[2] += b.inertia * b.angular_velocity + b.mass * (b.center.x * b.velocity.y - b.center.y * b.velocity.x);
      }
      return sum;
    };
    const auto before = momenta();
    run_ticks(*engine, 600);
    const auto after = momenta();
    for (std::size_t i = 0; i < 3; ++i) CHECK(after[i] == Approx(before[i]).epsilon(1e-9).margin(1e-9));
  }
}

TEST_CASE("a rod between bodies that turn with it keeps its length", "[engine][joints][analytic]") {
  // Two boxes and the rod between their ends turn as one. In a substep, an arm of 1 m along the rod loses (h W)^2 / 2
  // of its length in that direction: two arms lose (h W)^2. The joint must know this, or the rod is off by more than
  // that.
  const double spin = 5;
  const int substeps = 4;
  Scene scene = empty_scene(Precision::f64);
  scene.gravity = {0, 0};
  scene.settings.substeps = substeps;
  scene.settings.joints = engine::JointSolverKind::iterative;
  for (const double side : {-1.0, 1.0}) {
    scene.bodies.push_back(body_of(box_shape(1, 0.2), {2 * side, 0}));
    scene.bodies.back().velocity = {0, 2 * side * spin};
    scene.bodies.back().angular_velocity = spin;
  }
  scene.joints = {joint_of(JointKind::distance, 0, 1)};
  scene.joints[0].anchor_a = {1, 0};
  scene.joints[0].anchor_b = {-1, 0};
  scene.joints[0].length = 2;
  const auto engine = make_engine_or_fail(scene);
  const auto anchor = [&](std::size_t body, double x) {
    const BodyReport& at = engine->bodies()[body];
    return Point{at.center.x + x * std::cos(at.angle), at.center.y + x * std::sin(at.angle)};
  };
  const double turn = spin * dt / substeps;
  double most = 0;
  for (int tick = 0; tick < 120; ++tick) {
    run_ticks(*engine, 1);
    most = std::max(most, std::fabs(length_of(anchor(0, 1), anchor(1, -1)) - 2));
  }
  CHECK(most < turn * turn);
}

TEST_CASE("anchors that coincide give a direction, not a NaN", "[engine][joints][analytic]") {
  for (const double length : {0.0, 1.0}) {
    for (int form = 0; form < 3; ++form) {
      if (length == 0 && form != 1) continue;  // only springs may have length 0
      Scene scene = empty_scene();
      scene.bodies = {peg({0, 0}), bob({0, 0})};
      scene.joints = {joint_of(JointKind::distance, 0, 1)};
      scene.joints[0].length = length;
      if (form == 1) scene.joints[0].spring = absolute_spring(100, 1);
      if (form == 2) scene.joints[0].limits = engine::Range{0, 1};
      const auto engine = make_engine_or_fail(scene);
      run_ticks(*engine, 120);
      CHECK_FALSE(find_non_finite(engine->state()).has_value());
      if (form == 0) CHECK(length_of(engine->bodies()[1].center, {0, 0}) == Approx(length).margin(0.001));
    }
  }
}

TEST_CASE("a kinematic body moves what is joined to it", "[engine][joints][analytic]") {
  for (const auto& info : engine::joint_kinds) {
    if (info.kind == JointKind::gear) continue;  // gear_test.cpp
    CAPTURE(info.name);
    Scene scene = empty_scene();
    scene.gravity = {0, 0};
    scene.bodies = {body_of(disc_shape(0.1), {0, 0}, BodyType::kinematic_body), bob({1, 0})};
    scene.bodies[0].velocity = {0, 1};
    Joint joint = joint_of(info.kind, 0, 1);
    joint.anchor_a = info.kind == JointKind::distance ? Point{0, 0} : Point{1, 0};
    joint.offset = info.kind == JointKind::target ? Point{1, 2} : Point{1, 0};
    if (info.kind == JointKind::pulley) {  // the rope moves from A's side to B's side
      joint.anchor_a = {0, 0};
      joint.ground_anchor_a = {0, 3};
      joint.ground_anchor_b = {1, -1};
      joint.length = 4;
    }
    joint.force_max = 1e6;
    joint.torque_max = 1e6;
    drop_unused_fields(joint);
    scene.joints.push_back(joint);
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 120);
    const auto bodies = engine->bodies();
    CHECK_FALSE(find_non_finite(engine->state()).has_value());
    CHECK(bodies[0].center.x == 0);
    CHECK(bodies[0].center.y == Approx(2));
    // A rod of 1 m and the axis of a wheel joint allow some motion. All other joints carry the body along.
    if (info.kind != JointKind::distance) CHECK(bodies[1].center.y == Approx(2).epsilon(0.01));
  }
}

TEST_CASE("joined bodies touch only where the joint says so", "[engine][joints][analytic]") {
  for (const bool touch : {false, true}) {
    Scene scene = empty_scene();
    scene.bodies = {body_of(box_shape(1, 1), {0, 0}, BodyType::static_body), unit_box({0, 1.2})};
    scene.joints = {joint_of(JointKind::distance, 1, 0)};
    scene.joints[0].spring = absolute_spring(0);
    scene.joints[0].collide_connected = touch;
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 120);
    CHECK(engine->contacts().empty() != touch);
    CHECK((engine->bodies()[1].center.y > 1.4) == touch);
  }
}
