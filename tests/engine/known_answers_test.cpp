// Mechanics problems with known answers, solved by the whole engine: slopes, rolling, chains, pendulums.
// SPDX-License-Identifier: MIT
//
// analytic_test.cpp tests sliding to rest, toppling, forces and yield of a stack, free spin, and collisions of two
// discs. h is the substep. In a fall from rest, semi-implicit Euler gains g h t / 2: relative to a t^2 / 2, that is h /
// t.
#include <cmath>
#include <vector>

#include "engine/math/trig.h"
#include "tests/support/engine_runs.h"
#include "tests/support/joints.h"
#include "tool/study/closed_forms.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::BodyReport;
using engine::Engine;
using engine::pi;

namespace {

constexpr Precision both_precisions[]{Precision::f32, Precision::f64};

// ---- On a slope of 20 degrees ----

const engine::SinCos slope = engine::sin_cos(20 * pi / 180);
const double slope_tangent = slope.sin / slope.cos;

// Gravity is inclined and the ground is level: equals a slope that falls to the right.
Scene slope_scene(Body body, double friction, Precision precision = Precision::f64) {
  Scene scene = empty_scene(precision);
  scene.gravity = {10 * slope.sin, -10 * slope.cos};
  scene.bodies = {ground(), std::move(body)};
  for (Body& each : scene.bodies) each.shapes[0].material.friction = friction;
  return scene;
}

// Whether a box that starts at rest is faster after two seconds than after one.
bool slips(double friction) {
  const auto engine = make_engine_or_fail(slope_scene(unit_box({0, 0.5}), friction));
  run_ticks(*engine, 60);
  const double before = engine->bodies()[1].velocity.x;
  run_ticks(*engine, 60);
  return engine->bodies()[1].velocity.x > before + 1e-6;
}

// A disc of 0.5 m and 1 kg after two seconds on the slope. `inertia`: in units of m r^2.
BodyReport rolled(double friction, double inertia, Precision precision) {
  Body disc = body_of(disc_shape(0.5), {0, 0.5});
  disc.mass = engine::ExplicitMass{1, inertia * 0.25, {}};
  const auto engine = make_engine_or_fail(slope_scene(disc, friction, precision));
  run_ticks(*engine, 120);
  return engine->bodies()[1];
}

double slip_speed(const BodyReport& disc) {
  return disc.velocity.x + 0.5 * disc.angular_velocity;
}

// ---- Hanging ----

// Links of a chain of 12 m between pegs 10 m apart. They start in two straight lines to the lowest reachable point.
Scene hanging_chain() {
  constexpr int link_count = 20;
  constexpr double half_link = 0.3;
  const double c = 5.0 / 6;
  const double s = std::sqrt(1 - c * c);
  Scene scene = empty_scene();
  scene.settings.auto_substeps.emplace();
  scene.bodies.push_back(peg({0, 0}));
  for (int i = 0; i < link_count; ++i) {
    const bool falls = i < link_count / 2;
    const double along = half_link * (2 * i + 1);
    Body link = body_of(box_shape(half_link, 0.05), {c * along, -s * (falls ? along : 12 - along)});
    link.angle = (falls ? -1 : 1) * std::acos(c);
    link.mass = engine::ExplicitMass{1, {}, {}};
    link.linear_damping = 1;
    link.angular_damping = 1;
    scene.bodies.push_back(link);
  }
  scene.bodies.push_back(peg({10, 0}));
  for (int i = 0; i <= link_count; ++i) {
    Joint pin = joint_of(JointKind::revolute, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i) + 1);
    if (i > 0) pin.anchor_a = {half_link, 0};
    if (i < link_count) pin.anchor_b = {-half_link, 0};
    scene.joints.push_back(pin);
  }
  return scene;
}

// ---- Pendulum: 1 kg on a rod of 1 m, released at 60 degrees ----

Scene pendulum_scene(Precision precision, bool automatic) {
  Scene scene = empty_scene(precision);
  if (automatic) scene.settings.auto_substeps.emplace();
  scene.bodies = {peg({0, 0}), bob({std::sin(pi / 3), -0.5})};
  scene.joints = {joint_of(JointKind::distance, 0, 1)};
  return scene;
}

struct Swing {
  double period = 0;       // s, mean of the first 10 s
  double energy_10_s = 0;  // mean of the last period, relative to the start
  double energy_60_s = 0;
};

Swing swing_of(const Scene& scene) {
  constexpr int period_ticks = 128;  // 2.132 s
  const double dt = scene.settings.dt;
  const auto engine = make_engine_or_fail(scene);
  Swing swing;
  double before = engine->bodies()[1].center.x;
  double first = 0, last = 0;
  int passages = 0;
  for (int tick = 0; tick < 3600; ++tick) {
    run_ticks(*engine, 1);
    const BodyReport at = engine->bodies()[1];
    if (tick < 600 && before > 0 && at.center.x <= 0) {
      last = (tick + before / (before - at.center.x)) * dt;
      if (passages++ == 0) first = last;
    }
    before = at.center.x;
    const double v2 = at.velocity.x * at.velocity.x + at.velocity.y * at.velocity.y;
    const double share = (0.5 * v2 + 10 * (at.center.y + 1)) / 5 / period_ticks;
    if (tick < 600 && tick >= 600 - period_ticks) swing.energy_10_s += share;
    if (tick >= 3600 - period_ticks) swing.energy_60_s += share;
  }
  swing.period = (last - first) / (passages - 1);
  return swing;
}

// ---- Impacts located in time ----

// Every contact bounces with `restitution`, at the moment of impact, without friction.
void set_bounces(Scene& scene, double restitution) {
  scene.settings.locate_impacts = true;
  scene.settings.restitution_threshold = 0;
  for (Body& body : scene.bodies) body.shapes[0].material = {0, restitution};
}

// A disc above the ground, with `height` m to fall.
Scene bounce_scene(double height, double restitution, Precision precision) {
  Scene scene = empty_scene(precision);
  scene.bodies = {ground(), body_of(disc_shape(0.5), {0, height + 0.5})};
  set_bounces(scene, restitution);
  return scene;
}

// Heights of the disc's apexes after each bounce, sampled at ticks: up to g (dt / 2)^2 / 2 = 0.35 mm too low.
std::vector<double> apexes(const Scene& scene, int tick_count) {
  const auto engine = make_engine_or_fail(scene);
  std::vector<double> found;
  double highest = 0;
  bool rose = false;
  for (int tick = 0; tick < tick_count; ++tick) {
    run_ticks(*engine, 1);
    const BodyReport disc = engine->bodies()[1];
    const bool rises = disc.velocity.y > 0;
    if (rises && !rose) highest = 0;
    highest = std::fmax(highest, disc.center.y - 0.5);
    if (rose && !rises) found.push_back(highest);
    rose = rises;
  }
  return found;
}

// Five discs in a row, `gap` m apart. The first disc starts 1 m before the others, at 10 m/s.
Scene cradle_scene(double gap, Precision precision) {
  Scene scene = empty_scene(precision);
  scene.gravity = {0, 0};
  scene.bodies = {body_of(disc_shape(0.5), {-2, 0})};
  scene.bodies[0].velocity = {10, 0};
  for (int i = 0; i < 4; ++i) scene.bodies.push_back(body_of(disc_shape(0.5), {i * (1 + gap), 0}));
  for (Body& body : scene.bodies) body.mass = engine::ExplicitMass{1, {}, {}};
  set_bounces(scene, 1);
  return scene;
}

}  // namespace

TEST_CASE("friction holds a box on a slope above the tangent of its angle, and nowhere below",
          "[engine][friction][known_answers]") {
  for (const Precision precision : both_precisions) {
    CAPTURE(precision);
    const auto engine = make_engine_or_fail(slope_scene(unit_box({0, 0.5}), 1.05 * slope_tangent, precision));
    run_ticks(*engine, 600);
    CHECK(std::fabs(engine->bodies()[1].center.x) < 1e-3);
  }
  double lets_slip = 0.95 * slope_tangent;
  double holds = 1.05 * slope_tangent;
  REQUIRE(slips(lets_slip));
  REQUIRE_FALSE(slips(holds));
  while (holds - lets_slip > 1e-4) {
    const double middle = (holds + lets_slip) / 2;
    (slips(middle) ? lets_slip : holds) = middle;
  }
  CHECK(holds == Approx(slope_tangent).epsilon(0.005));
}

TEST_CASE("discs and rings roll down a slope without slipping, at 2/3 and 1/2 of g sin",
          "[engine][friction][known_answers]") {
  for (const Precision precision : both_precisions) {
    CAPTURE(precision);
    const BodyReport disc = rolled(0.5, 0.5, precision);
    CHECK(disc.center.x == Approx(4.560269).epsilon(0.005));
    CHECK(std::fabs(slip_speed(disc)) < 1e-3);
    const BodyReport ring = rolled(0.5, 1, precision);
    CHECK(ring.center.x == Approx(0.5 * (10 * slope.sin / 2) * 4).epsilon(0.005));
    CHECK(std::fabs(slip_speed(ring)) < 1e-3);
  }
}

TEST_CASE("a disc slips down a slope if its friction is below a third of the tangent",
          "[engine][friction][known_answers]") {
  for (const Precision precision : both_precisions) {
    CAPTURE(precision);
    const BodyReport rolls = rolled(1.05 * slope_tangent / 3, 0.5, precision);
    CHECK(std::fabs(slip_speed(rolls)) < 1e-3);
    for (const double share : {0.95, 0.5}) {
      const double friction = share * slope_tangent / 3;
      const BodyReport disc = rolled(friction, 0.5, precision);
      const double speed_up = 10 * (slope.sin - friction * slope.cos);  // m/s^2
      const double spin_up = 2 * friction * 10 * slope.cos / 0.5;       // rad/s^2
      CHECK(disc.center.x == Approx(0.5 * speed_up * 4).epsilon(0.005));
      CHECK(disc.velocity.x == Approx(speed_up * 2).epsilon(0.005));
      CHECK(-disc.angular_velocity == Approx(spin_up * 2).epsilon(0.005));
    }
  }
}

TEST_CASE("a chain of twenty links between two pegs hangs as its equations say", "[engine][joints][known_answers]") {
  const double pull = tool::catenary_pull;
  const auto engine = make_engine_or_fail(hanging_chain());
  run_ticks(*engine, 1800);
  const std::vector<BodyReport> bodies = engine->bodies();
  const BodyReport& link = bodies[10];  // its right end is the lowest point
  CHECK(-(link.center.y + 0.3 * std::sin(link.angle)) == Approx(tool::catenary_sag).epsilon(0.001));
  CHECK(link.center.x + 0.3 * std::cos(link.angle) == Approx(5).epsilon(0.001));
  for (const std::size_t end : {std::size_t{0}, std::size_t{20}}) {
    CAPTURE(end);
    const double along = joint_value(*engine, end, "linear_force", 0);
    const double up = joint_value(*engine, end, "linear_force", 1);
    CHECK(std::fabs(along) == Approx(10 * pull).epsilon(0.01));
    CHECK(std::fabs(up) == Approx(100).epsilon(0.01));
  }
  CHECK(std::fabs(joint_value(*engine, 10, "linear_force", 0)) == Approx(10 * pull).epsilon(0.001));
}

TEST_CASE("a pendulum of 60 degrees has its period", "[engine][joints][known_answers]") {
  for (const Precision precision : both_precisions)
    for (const bool automatic : {false, true}) {
      CAPTURE(precision, automatic);
      CHECK(swing_of(pendulum_scene(precision, automatic)).period == Approx(pendulum_period_60).epsilon(0.0002));
    }
}

TEST_CASE("a pendulum keeps 94 % of its energy with four substeps, 99 % with automatic ones",
          "[engine][joints][known_answers]") {
  for (const Precision precision : both_precisions)
    for (const bool automatic : {false, true}) {
      CAPTURE(precision, automatic);
      const Swing swing = swing_of(pendulum_scene(precision, automatic));
      const double least = automatic ? 0.99 : 0.94;
      CHECK(swing.energy_10_s > least);
      CHECK(swing.energy_60_s > least);
      CHECK(swing.energy_10_s < 1.01);
      CHECK(swing.energy_60_s < 1.01);
    }
}

TEST_CASE("a mass on an undamped spring keeps 99 % of its amplitude for a minute", "[engine][joints][known_answers]") {
  for (const Precision precision : both_precisions)
    for (double stiffness = 1e2; stiffness < 2e6; stiffness *= 10) {
      CAPTURE(precision, stiffness);
      Scene scene = empty_scene(precision);
      scene.gravity = {0, 0};
      scene.bodies = {peg({0, 0}), bob({1.1, 0})};
      scene.joints = {joint_of(JointKind::distance, 0, 1)};
      scene.joints[0].spring = absolute_spring(stiffness);
      const auto engine = make_engine_or_fail(scene);
      const auto largest_stretch = [&](int tick_count) {
        double largest = 0;
        for (int tick = 0; tick < tick_count; ++tick) {
          run_ticks(*engine, 1);
          largest = std::fmax(largest, std::fabs(engine->bodies()[1].center.x - 1));
        }
        return largest;
      };
      const double at_first = largest_stretch(600);
      CHECK(at_first > 0.099);
      run_ticks(*engine, 2400);
      const double at_last = largest_stretch(600);
      CHECK(at_last > 0.99 * at_first);
      CHECK(at_last < 1.01 * at_first);
    }
}

TEST_CASE("a disc that bounces with 0.8 rises to 0.64 of its height each time", "[engine][impacts][known_answers]") {
  for (const Precision precision : both_precisions) {
    CAPTURE(precision);
    const std::vector<double> found = apexes(bounce_scene(1, 0.8, precision), 180);
    REQUIRE(found.size() >= 3);
    CHECK(found[0] == Approx(0.64).epsilon(0.01));
    CHECK(found[1] == Approx(0.4096).epsilon(0.01));
    CHECK(found[2] == Approx(0.262144).epsilon(0.01));
  }
}

TEST_CASE("a disc that bounces with 1 from 10 m neither gains nor loses 1 % of its height in a minute",
          "[engine][impacts][known_answers]") {
  for (const Precision precision : both_precisions) {
    CAPTURE(precision);
    // One fall and rise takes 2 sqrt(20 / 10) s.
    const std::vector<double> found = apexes(bounce_scene(10, 1, precision), 3600);
    CHECK(found.size() >= 20);
    for (const double apex : found) {
      CHECK(apex > 9.9);
      CHECK(apex < 10.0005);
    }
  }
}

TEST_CASE("the last disc of a row takes all of the first one's speed", "[engine][impacts][known_answers]") {
  for (const Precision precision : both_precisions) {
    CAPTURE(precision);
    // In f32, 100 rounding errors of the largest speed.
    const double rounding = precision == Precision::f32 ? 100 * 0x1p-24 : 1e-9;
    for (const double gap : {0.001, 0.0}) {
      CAPTURE(gap);
      const auto engine = make_engine_or_fail(cradle_scene(gap, precision));
      run_ticks(*engine, 60);
      const std::vector<BodyReport> discs = engine->bodies();
      double momentum = 0, energy = 0;
      for (const BodyReport& disc : discs) {
        momentum += disc.velocity.x;
        energy += 0.5 * disc.velocity.x * disc.velocity.x;
      }
      CHECK(std::fabs(momentum / 10 - 1) < rounding);
      CHECK(std::fabs(energy / 50 - 1) < (precision == Precision::f32 ? 2 * rounding : 1e-6));
      if (gap == 0) continue;  // all discs touch at once: which discs leave is a convention
      for (std::size_t i = 0; i < 4; ++i) CHECK(std::fabs(discs[i].velocity.x) < 10 * (rounding + 1e-6));
      CHECK(discs[4].velocity.x == Approx(10).epsilon(rounding + 1e-6));
    }
  }
}
