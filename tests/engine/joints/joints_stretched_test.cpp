// Joints stretched by weight, by spin, by large mass ratios, or from the start.
// SPDX-License-Identifier: MIT
//
// A rigid constraint yields by C = F K / w^2 (docs/physics.md, "Joints"), w = 2 pi 0.25 / h. A body that is released
// swings to at most twice that.
#include <cmath>

#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/math/trig.h"
#include "tests/support/engine_runs.h"
#include "tests/support/joints.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::BodyReport;
using engine::Engine;
using engine::pi;

namespace {

// w^2 with four substeps.
constexpr double stiffness = (2 * pi * 0.25 * 4 / dt) * (2 * pi * 0.25 * 4 / dt);

double widest_gap(const Scene& scene, const std::vector<BodyReport>& bodies) {
  double widest = 0;
  const auto place = [](const BodyReport& body, Point at) {
    const double c = std::cos(body.angle);
    const double s = std::sin(body.angle);
    return Point{body.center.x + c * at.x - s * at.y, body.center.y + s * at.x + c * at.y};
  };
  for (const Joint& joint : scene.joints) {
    const Point a = place(bodies[joint.body_a], joint.anchor_a);
    const Point b = place(bodies[joint.body_b], joint.anchor_b);
    const double gap = std::hypot(b.x - a.x, b.y - a.y);
    if (!(gap <= widest)) widest = gap;  // also takes a NaN
  }
  return widest;
}

double kinetic_energy(const std::vector<BodyReport>& bodies) {
  double energy = 0;
  for (const BodyReport& b : bodies)
    energy += 0.5 * b.mass * (b.velocity.x * b.velocity.x + b.velocity.y * b.velocity.y) +
              0.5 * b.inertia * b.angular_velocity * b.angular_velocity;
  return energy;
}

Scene grid_of(const char* precision) {
  auto scene = engine::make_builtin_scene(std::string("joint_grid?columns=100&precision=") + precision);
  REQUIRE(scene.has_value());
  return *std::move(scene);
}

// The gap of one revolute joint that carries the whole weight. Swinging doubles the gap.
double grid_gap_limit() {
  const double mass = pi * 0.16;
  const double inertia = 0.5 * mass * 0.16;
  const double weight = 9993 * mass * 10;
  return 2 * weight * (1 / mass + 0.25 / inertia) / stiffness;
}

// A chain from a peg in direction `along`, of links with 1 m and 1 kg. The last link has its own mass.
Scene chain_of(Precision precision, int links, Point along, double end_mass) {
  Scene scene = empty_scene(precision);
  scene.bodies.push_back(peg({0, 0}));
  for (int i = 0; i < links; ++i) {
    const double mass = i + 1 == links ? end_mass : 1;
    Body link = bob({along.x * (i + 0.5), along.y * (i + 0.5)}, mass, mass / 12);
    link.angle = std::atan2(along.y, along.x);
    link.shapes[0].filter = {2, 0xfffffffd, 0};
    scene.bodies.push_back(link);
    Joint joint = joint_of(JointKind::revolute, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i + 1));
    joint.anchor_a = i == 0 ? Point{0, 0} : Point{0.5, 0};
    joint.anchor_b = {-0.5, 0};
    scene.joints.push_back(joint);
  }
  return scene;
}

}  // namespace

TEST_CASE("a net of ten thousand discs falls into its pins and holds", "[engine][joints][stretched]") {
  for (const char* precision : {"f32", "f64"}) {
    CAPTURE(precision);
    const Scene scene = grid_of(precision);
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 110);
    CHECK(widest_gap(scene, engine->bodies()) < grid_gap_limit());
  }
}

TEST_CASE("a net of ten thousand discs hangs for 500 ticks, and loses energy", "[engine][joints][stretched][.slow]") {
  for (const char* precision : {"f32", "f64"}) {
    CAPTURE(precision);
    const Scene scene = grid_of(precision);
    const auto engine = make_engine_or_fail(scene);
    double lowest = 0;
    for (const BodyReport& body : engine->bodies()) lowest -= 10 * body.mass * body.center.y;
    const auto energy = [&] {
      double sum = kinetic_energy(engine->bodies()) + lowest;
      for (const BodyReport& body : engine->bodies()) sum += 10 * body.mass * body.center.y;
      return sum;
    };
    double widest = 0;
    for (int tick = 0; tick < 500; ++tick) {
      run_ticks(*engine, 1);
      REQUIRE(energy() <= 0);
      if (tick >= 400) widest = std::max(widest, widest_gap(scene, engine->bodies()));
    }
    CHECK(widest < grid_gap_limit() / 2);
  }
}

TEST_CASE("a heavy mass whirls on a light arm and gains no energy", "[engine][joints][stretched]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const double spin : {10.0, 30.0, 60.0})
      for (const double mass : {10.0, 100.0, 1000.0}) {
        CAPTURE(static_cast<int>(precision), spin, mass);
        Scene scene = chain_of(precision, 2, {1, 0}, mass);
        scene.gravity = {0, 0};
        for (std::size_t i = 1; i < scene.bodies.size(); ++i) {
          scene.bodies[i].angular_velocity = spin;
          scene.bodies[i].velocity = {0, spin * scene.bodies[i].position.x};
        }
        const auto engine = make_engine_or_fail(scene);
        const double start = kinetic_energy(engine->bodies());
        double most = 0;
        double widest = 0;
        for (int tick = 0; tick < 300; ++tick) {
          run_ticks(*engine, 1);
          const double energy = kinetic_energy(engine->bodies());
          most = energy <= most ? most : energy;
          widest = std::max(widest, widest_gap(scene, engine->bodies()));
        }
        CHECK(most <= start * 1.0001);
        // The mass never exceeds its speed v: F = m v^2 / r, r at least 1.5 m.
        CHECK(widest <= 2 * (mass * 1.5 * spin * spin) * 2 / stiffness);
      }
}

TEST_CASE("a chain holds any weight as far as its stiffness goes", "[engine][joints][stretched]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const int links : {10, 20})
      for (const double end_mass : {1e2, 1e4, 1e6}) {
        CAPTURE(static_cast<int>(precision), links, end_mass);
        const Scene scene = chain_of(precision, links, {0, -1}, end_mass);
        const auto engine = make_engine_or_fail(scene);
        run_ticks(*engine, 600);
        CHECK(widest_gap(scene, engine->bodies()) <= 2 * 10 * (end_mass + links) * 2 / stiffness);
      }
}

TEST_CASE("a heavy weight swings on a light chain and gains no energy", "[engine][joints][stretched]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const double end_mass : {1e3, 1e4}) {
      CAPTURE(static_cast<int>(precision), end_mass);
      const Scene scene = chain_of(precision, 10, {1, 0}, end_mass);
      const auto engine = make_engine_or_fail(scene);
      double most = 0;
      for (int tick = 0; tick < 600; ++tick) {
        run_ticks(*engine, 1);
        double energy = kinetic_energy(engine->bodies());
        for (const BodyReport& body : engine->bodies()) energy += 10 * body.mass * body.center.y;
        most = energy <= most ? most : energy;
      }
      CHECK(most <= 1e-4 * 10 * 10 * end_mass);  // of the energy of a fall over the length of the chain
    }
}

TEST_CASE("a chain made apart at every joint draws together", "[engine][joints][stretched]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    CAPTURE(static_cast<int>(precision));
    Scene scene = empty_scene(precision);
    scene.bodies.push_back(peg({0, 0}));
    for (std::uint32_t i = 0; i < 40; ++i) {
      scene.bodies.push_back(bob({1.4 * (i + 1), 0}, 1, 1.0 / 60));
      scene.bodies.back().shapes[0].filter = {2, 0xfffffffd, 0};
      Joint joint = joint_of(JointKind::revolute, i, i + 1);
      joint.anchor_a = i == 0 ? Point{} : Point{0.2, 0};
      joint.anchor_b = {-0.2, 0};
      scene.joints.push_back(joint);
    }
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 1200);
    // The chain swings from level: at most three times its weight at the peg, K with arms of 0.2 m.
    CHECK(widest_gap(scene, engine->bodies()) < 2 * (3 * 40 * 10) * (2 + 2 * 0.04 * 60) / stiffness);
  }
}

// An iteration over the joints moves the light body and barely moves the rods. With one iteration per substep, six rods
// welded to a light body of their own mass reached 1e8 m/s after half a second.
TEST_CASE("rods on a light hub gain no energy", "[engine][joints][stretched]") {
  for (const double light_mass : {1.0, 0.01, 0.0001})
    for (const int count : {3, 6, 12})
      for (const JointKind kind : {JointKind::weld, JointKind::revolute}) {
        CAPTURE(light_mass, count, static_cast<int>(kind));
        Scene scene = empty_scene(Precision::f32);
        scene.bodies.push_back(peg({0, 0}));
        scene.bodies.push_back(bob({0, 0}, light_mass, 0.005 * light_mass));
        scene.joints.push_back(joint_of(JointKind::revolute, 0, 1));
        for (int i = 0; i < count; ++i) {
          const double angle = 2 * engine::pi * i / count;
          const Point along{std::cos(angle), std::sin(angle)};
          Body rod = body_of(box_shape(0.5, 0.05), {0.6 * along.x, 0.6 * along.y});
          rod.angle = angle;
          rod.mass = engine::ExplicitMass{1, 1.0 / 12, {}};
          scene.bodies.push_back(rod);
          Joint joint = joint_of(kind, 1, static_cast<std::uint32_t>(2 + i));
          joint.anchor_a = {0.1 * along.x, 0.1 * along.y};
          joint.anchor_b = {-0.5, 0};
          if (kind == JointKind::weld) joint.reference_angle = angle;
          scene.joints.push_back(joint);
        }
        for (Body& body : scene.bodies) body.shapes[0].filter.group = -1;
        const auto made = engine::make_engine(scene);
        REQUIRE(made.has_value());
        const auto energy = [&] {
          double sum = 0;
          for (const engine::BodyReport& body : (*made)->bodies())
            sum += 0.5 * body.mass * (body.velocity.x * body.velocity.x + body.velocity.y * body.velocity.y) +
                   0.5 * body.inertia * body.angular_velocity * body.angular_velocity + 10 * body.mass * body.center.y;
          return sum;
        };
        const double most = energy() + 0.05 * count * 10 * 0.6;  // a share of the energy of their fall
        bool holds = true;
        for (int tick = 0; tick < 600; ++tick) {
          REQUIRE((*made)->step({scene.settings.dt, {}}, nullptr));
          holds &= energy() < most;
        }
        CHECK(holds);
      }
}
