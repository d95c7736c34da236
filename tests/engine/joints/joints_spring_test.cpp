// Springs of joints: amplitude, damping, stiffness above the limit of a substep, deflection.
// SPDX-License-Identifier: MIT
//
// Limits from engine/joints/joint_spring.h. A swing from rest at x0 has the amplitude x0 / cos(theta / 2). theta is the
// angle per substep: cos(theta) = 1 / (1 + y^2 / 2 + 5 y^4 / 24), y = w h.
#include <cmath>

#include "engine/math/trig.h"
#include "tests/support/engine_runs.h"
#include "tests/support/joints.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::Engine;

namespace {

constexpr double h = dt / 4;

// 1 kg on a spring of 1 m, stretched by `stretch`.
Scene spring_scene(Precision precision, double stiffness, double damping, double stretch) {
  Scene scene = empty_scene(precision);
  scene.gravity = {0, 0};
  scene.bodies = {peg({0, 0}), bob({1 + stretch, 0})};
  scene.joints = {joint_of(JointKind::distance, 0, 1)};
  scene.joints[0].spring = absolute_spring(stiffness, damping);
  return scene;
}

double largest_stretch(Engine& engine, int tick_count) {
  double largest = 0;
  for (int tick = 0; tick < tick_count; ++tick) {
    run_ticks(engine, 1);
    largest = std::fmax(largest, std::fabs(engine.bodies()[1].center.x - 1));
  }
  return largest;
}

double amplitude_from_rest(double stiffness) {
  const double y2 = stiffness * h * h;
  const double cosine = 1 / (1 + y2 / 2 + 5 * y2 * y2 / 24);
  return 0.1 / std::sqrt((1 + cosine) / 2);
}

}  // namespace

TEST_CASE("an undamped spring keeps its amplitude, however stiff", "[engine][joints][conservation]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (double stiffness = 1e2; stiffness < 2e6; stiffness *= 10) {
      CAPTURE(precision, stiffness);
      const auto engine = make_engine_or_fail(spring_scene(precision, stiffness, 0, 0.1));
      const double expected = amplitude_from_rest(stiffness);
      CHECK(expected < 0.1 * std::sqrt(2.0));
      CHECK(largest_stretch(*engine, 600) == Approx(expected).epsilon(0.01));
      run_ticks(*engine, 2400);
      CHECK(largest_stretch(*engine, 600) == Approx(expected).epsilon(0.01));
    }
}

TEST_CASE("an undamped spring has its period to fourth order in w h", "[engine][joints][analytic]") {
  // The error of the angle per substep is 61 y^5 / 720; y = w h.
  for (const double stiffness : {1e2, 1e3}) {
    const auto engine = make_engine_or_fail(spring_scene(Precision::f64, stiffness, 0, 0.1));
    const double omega = std::sqrt(stiffness);
    const double y = omega * h;
    const double drift = 61 * std::pow(y, 4) / 720 * omega;  // rad/s
    const int tick_count = 600;
    run_ticks(*engine, tick_count);
    // Positions of a swing from rest lead by half a substep.
    const double time = tick_count * dt;
    const double expected = amplitude_from_rest(stiffness) * std::cos(omega * (time + h / 2));
    const double x = engine->bodies()[1].center.x - 1;
    CHECK(std::fabs(x - expected) < 0.1 * (1.5 * drift * time + 1e-6));
  }
}

TEST_CASE("springs far too stiff for the substep stay bounded", "[engine][joints][analytic]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (double stiffness = 1e7; stiffness < 1e16; stiffness *= 100) {
      CAPTURE(precision, stiffness);
      Scene scene = spring_scene(precision, stiffness, 0, 0.1);
      scene.bodies[1].velocity = {1, 0};
      const auto engine = make_engine_or_fail(scene);
      // The swing takes a quarter period per substep: at most sqrt(2) (x0 + h v).
      CHECK(largest_stretch(*engine, 3600) < std::sqrt(2.0) * (0.1 + h) * 1.01);
      CHECK_FALSE(find_non_finite(engine->state()).has_value());
    }
}

TEST_CASE("a damped spring decays as its equation says", "[engine][joints][analytic]") {
  const double omega = 10;
  for (const double ratio : {0.02, 0.1}) {
    const auto engine = make_engine_or_fail(spring_scene(Precision::f64, 100, 2 * ratio * omega, 0.1));
    const double damped = omega * std::sqrt(1 - ratio * ratio);
    double worst = 0;
    for (int tick = 1; tick <= 300; ++tick) {
      run_ticks(*engine, 1);
      const double t = tick * dt;
      const double exact =
          0.1 * std::exp(-ratio * omega * t) * (std::cos(damped * t) + ratio * omega / damped * std::sin(damped * t));
      worst = std::fmax(worst, std::fabs(engine->bodies()[1].center.x - 1 - exact));
    }
    // Half a substep of phase: w h / 2 of the amplitude.
    CHECK(worst < 0.1 * omega * h / 2 * 1.1);
  }
}

TEST_CASE("a damper without stiffness slows as e^(-c t / m)", "[engine][joints][analytic]") {
  Scene scene = spring_scene(Precision::f64, 0, 3, 0);
  scene.bodies[1].velocity = {2, 0};
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 60);
  CHECK(engine->bodies()[1].velocity.x == Approx(2 * std::exp(-3.0)).epsilon(1e-9));
}

TEST_CASE("a spring damped at least critically comes to rest without turning back", "[engine][joints][analytic]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (double stiffness = 1e2; stiffness < 2e6; stiffness *= 100)
      for (const double ratio : {1.0, 10.0, 1e3, 1e6}) {
        CAPTURE(precision, stiffness, ratio);
        const double damping = 2 * ratio * std::sqrt(stiffness);
        const auto engine = make_engine_or_fail(spring_scene(precision, stiffness, damping, 0.1));
        const double rounding = precision == Precision::f32 ? 1e-6 : 1e-12;
        double before = 0.1;
        for (int tick = 0; tick < 600; ++tick) {
          run_ticks(*engine, 1);
          const double stretch = engine->bodies()[1].center.x - 1;
          if (stretch > before + rounding || stretch < -rounding) FAIL("turned back at tick " << tick);
          before = stretch;
        }
        // The slow root: x = 0.1 e^(-q t), q = w (r - sqrt(r^2 - 1)).
        const double slow = std::sqrt(stiffness) / (ratio + std::sqrt(ratio * ratio - 1));
        if (ratio > 1) CHECK(before == Approx(0.1 * std::exp(-slow * 10)).epsilon(0.01).margin(10 * rounding));
      }
}

TEST_CASE("a weight on a spring hangs m g / k below its rest, however stiff", "[engine][joints][analytic]") {
  for (double stiffness = 1e2; stiffness < 2e6; stiffness *= 10) {
    CAPTURE(stiffness);
    Scene scene = spring_scene(Precision::f64, stiffness, std::sqrt(stiffness), 0);
    scene.gravity = {10, 0};
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 600);
    CHECK((engine->bodies()[1].center.x - 1) * stiffness / 10 == Approx(1).epsilon(1e-6));
  }
}

TEST_CASE("a spring under other constraints carries their load too", "[engine][joints][analytic]") {
  // A platform on a spring, with a stack on it. The spring carries all weights at any stiffness.
  for (const double stiffness : {1e3, 1e5}) {
    CAPTURE(stiffness);
    Scene scene = empty_scene();
    scene.bodies = {peg({0, -5}), unit_box({0, 0}), unit_box({0, 1}), unit_box({0, 2})};
    scene.joints = {joint_of(JointKind::prismatic, 0, 1)};
    scene.joints[0].axis = {0, 1};
    scene.joints[0].anchor_a = {0, 5};
    scene.joints[0].spring = absolute_spring(stiffness, 2 * std::sqrt(stiffness));
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 900);
    CHECK(-engine->bodies()[1].center.y * stiffness == Approx(30).epsilon(0.01));
    CHECK(joint_value(*engine, 0, "spring_force") == Approx(30).epsilon(0.01));
  }
}

TEST_CASE("a slider swings at its hertz however far off its centre the anchor is", "[engine][joints][analytic]") {
  // With a fixed angle, a body of 2 kg swings as a point: x0 cos(w t), positions half a substep ahead.
  for (const double arm : {0.0, 0.5, 2.0}) {
    CAPTURE(arm);
    Scene scene = empty_scene();
    scene.gravity = {0, 0};
    scene.bodies = {peg({0, 0}), bob({0.1, arm}, 2, 0.05)};
    scene.joints = {joint_of(JointKind::prismatic, 0, 1)};
    scene.joints[0].anchor_b = {0, -arm};
    scene.joints[0].spring = engine::JointSpring{false, 1, 0, 0, 0};
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 90);
    const double phase = 2 * engine::pi * (90 * dt + h / 2);
    // The rigid constraint of the angle yields by torque / (I w^2), with its own w.
    const double rigid = 2 * engine::pi * 0.25 / h;
    const double torque = 2 * 0.1 * 4 * engine::pi * engine::pi * arm;
    const double give = torque / (0.05 * rigid * rigid);
    CHECK(std::fabs(engine->bodies()[1].angle) <= give + 1e-6);
    CHECK(engine->bodies()[1].center.x == Approx(0.1 * std::cos(phase)).margin(0.001 + 1.5 * arm * give));
  }
}

TEST_CASE("a motor that presses a slider against its limit gives way by at most F / (m w^2)",
          "[engine][joints][analytic]") {
  constexpr double force = 50;
  constexpr double mass = 0.12;
  const double omega = 2 * engine::pi * 0.25 / h;
  for (const double arm : {0.0, 0.4}) {
    CAPTURE(arm);
    Scene scene = empty_scene();
    scene.gravity = {0, 0};
    scene.bodies = {peg({0, 0}), bob({0, arm}, mass, 0.0075)};
    scene.joints = {joint_of(JointKind::prismatic, 0, 1)};
    scene.joints[0].anchor_b = {0, -arm};
    scene.joints[0].limits = engine::Range{-1, 0.5};
    scene.joints[0].motor = engine::JointMotor{0.5, force};
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 600);
    CHECK(std::fabs(engine->bodies()[1].center.x - 0.5) <= 1.02 * force / (mass * omega * omega));
  }
}

TEST_CASE("two bodies on a slider with arms keep their momentum and angular momentum",
          "[engine][joints][conservation]") {
  // The bodies rotate, and the anchors are off both centres. The axis is solved together with the reactions of the
  // rigid constraints.
  Scene scene = empty_scene();
  scene.gravity = {0, 0};
  scene.bodies = {bob({0, 0}, 3, 0.2), bob({1.2, 0.7}, 1, 0.1)};
  scene.bodies[0].angular_velocity = scene.bodies[1].angular_velocity = 0.5;
  scene.bodies[1].velocity = {-0.35, 0.6};  // rotates with A about A's centre
  scene.joints = {joint_of(JointKind::prismatic, 0, 1)};
  scene.joints[0].anchor_a = {0.2, 0.3};
  scene.joints[0].anchor_b = {-0.7, -0.4};
  scene.joints[0].spring = engine::JointSpring{false, 2, 0, 0, 0};
  const auto engine = make_engine_or_fail(scene);
  const auto momentum = [&] {
    double x = 0, y = 0, spin = 0;
    for (const engine::BodyReport& body : engine->bodies()) {
      x += body.mass * body.velocity.x;
      y += body.mass * body.velocity.y;
      spin += body.inertia * body.angular_velocity +
              body.mass * (body.center.x * body.velocity.y - body.center.y * body.velocity.x);
    }
    return std::array<double, 3>{x, y, spin};
  };
  const auto before = momentum();
  run_ticks(*engine, 600);
  const auto after = momentum();
  for (std::size_t i = 0; i < 3; ++i) CHECK(after[i] == Approx(before[i]).margin(1e-9));
  CHECK(std::fabs(engine->bodies()[0].angle - engine->bodies()[1].angle) < 0.01);
}

TEST_CASE("a body off its centre on a point spring sags by m g / k in every direction", "[engine][joints][analytic]") {
  for (const double turn : {0.0, 1.0, 2.5}) {
    Scene scene = empty_scene();
    scene.bodies = {bob({0, 0}, 2, 0.1)};
    scene.bodies[0].angle = turn;
    scene.bodies[0].angular_damping = 2;  // without damping the body swings about the anchor for a long time
    scene.joints = {joint_of(JointKind::target, 0, 0)};
    scene.joints[0].anchor_b = {0.3, 0.4};
    scene.joints[0].offset = {0, 0};
    scene.joints[0].spring = absolute_spring(500, 10);
    scene.joints[0].force_max = 1e6;
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 6000);
    const auto body = engine->bodies()[0];
    const double x = body.center.x + 0.3 * std::cos(body.angle) - 0.4 * std::sin(body.angle);
    const double y = body.center.y + 0.3 * std::sin(body.angle) + 0.4 * std::cos(body.angle);
    CHECK(y == Approx(-20.0 / 500).epsilon(0.01));
    CHECK(std::fabs(x) < 0.001);
  }
}

TEST_CASE("two bodies on a spring swing about their centre of mass", "[engine][joints][conservation]") {
  Scene scene = empty_scene();
  scene.gravity = {0, 0};
  scene.bodies = {bob({-0.6, 0}, 1), bob({0.6, 0}, 3)};
  scene.joints = {joint_of(JointKind::distance, 0, 1)};
  scene.joints[0].spring = absolute_spring(300);
  const auto engine = make_engine_or_fail(scene);
  double largest = 0;
  for (int tick = 0; tick < 3600; ++tick) {
    run_ticks(*engine, 1);
    const auto bodies = engine->bodies();
    CHECK(bodies[0].center.x + 3 * bodies[1].center.x == Approx(1.2).epsilon(1e-9));
    if (tick >= 3000) largest = std::fmax(largest, std::fabs(bodies[1].center.x - bodies[0].center.x - 1));
  }
  CHECK(largest == Approx(0.2).epsilon(0.01));
}
