// The engine against closed forms: flight, collision, friction, weight. Tolerances come from the order and precision of
// the scheme, not from observation.
// SPDX-License-Identifier: MIT
//
// h is the substep, dt / substeps. Semi-implicit Euler falls g t (t + h) / 2, which is g h t / 2 too low. A sliding
// body brakes at the start of each substep, so it stops v0 h / 2 too early.
#include <cmath>
#include <memory>
#include <vector>

#include "engine/engine.h"
#include "engine/math/trig.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/scenes.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::BodyReport;
using engine::ContactReport;
using engine::Engine;
using engine::pi;

namespace {

struct PrecisionCase {
  Precision precision;
  double epsilon;  // half a unit in the last place of 1
};
constexpr PrecisionCase precision_cases[]{{Precision::f32, 0x1p-24}, {Precision::f64, 0x1p-53}};

std::unique_ptr<Engine> engine_of(const Scene& scene) {
  auto made = engine::make_engine(scene);
  if (!made) FAIL(made.error().message);
  return std::move(*made);
}

BodyReport body_at_end(const Scene& scene, int tick_count, std::size_t body) {
  const auto engine = engine_of(scene);
  run_ticks(*engine, tick_count);
  return engine->bodies().at(body);
}

// Upward force that bodies below `body` exert on it, N.
double force_under(const Engine& engine, std::uint32_t body) {
  double force = 0;
  for (const ContactReport& contact : engine.contacts()) {
    if (contact.body_a != body && contact.body_b != body) continue;
    const double up = contact.body_b == body ? contact.normal.y : -contact.normal.y;
    if (up <= 0) continue;
    for (int i = 0; i < contact.point_count; ++i) force += up * contact.normal_force[i];
  }
  return force;
}

// Gravity of 10 m/s^2 rotated by `degrees`: the ground then equals a slope down to the right.
Point gravity_on_slope(double degrees) {
  const engine::SinCos turn = engine::sin_cos(degrees * pi / 180);
  return {10 * turn.sin, -10 * turn.cos};
}

void set_friction(Scene& scene, double friction) {
  for (Body& body : scene.bodies)
    for (Shape& shape : body.shapes) shape.material.friction = friction;
}

void set_restitution(Scene& scene, double restitution) {
  for (Body& body : scene.bodies)
    for (Shape& shape : body.shapes) shape.material.restitution = restitution;
}

// Two discs of 1 kg and 3 kg. The first hits the second at 4 m/s, without gravity or friction.
Scene collision_scene(Precision precision, double restitution, SolverKind solver) {
  Scene scene = empty_scene(precision);
  scene.gravity = {0, 0};
  scene.settings.solver = solver;
  if (solver == SolverKind::impulse) scene.settings.substeps = 1;
  scene.bodies = {body_of(disc_shape(0.5), {-2, 0}), body_of(disc_shape(0.5), {0, 0})};
  scene.bodies[0].velocity = {4, 0};
  scene.bodies[0].mass = engine::ExplicitMass{1, {}, {}};
  scene.bodies[1].mass = engine::ExplicitMass{3, {}, {}};
  set_friction(scene, 0);
  set_restitution(scene, restitution);
  return scene;
}

}  // namespace

TEST_CASE("a falling body is too low by exactly g h t / 2", "[engine][flight][analytic]") {
  for (const PrecisionCase& c : precision_cases) {
    for (const SolverKind solver : {SolverKind::free_flight, SolverKind::tgs_soft}) {
      for (const int substeps : {1, 4}) {
        CAPTURE(c.precision, solver, substeps);
        Scene scene = flight_scene(c.precision, unit_box({0, 0}));
        scene.settings.solver = solver;
        scene.settings.substeps = substeps;
        const double t = 2;
        const double h = scene.settings.dt / substeps;
        const BodyReport body = body_at_end(scene, 120, 0);
        // Each of the 120 * substeps additions rounds a number of up to 20.
        const double rounding = 120.0 * substeps * 20 * c.epsilon;
        CHECK(std::fabs(body.center.y - (-10 * t * t / 2 - 10 * h * t / 2)) < rounding);
        CHECK(std::fabs(body.velocity.y + 10 * t) < rounding);
        CHECK(body.center.x == 0);
        CHECK(body.angle == 0);
      }
    }
  }
}

TEST_CASE("the error of a projectile halves with the step: order 1", "[engine][flight][analytic]") {
  const auto error = [](int substeps) {
    Scene scene = flight_scene(Precision::f64, body_of(disc_shape(0.5), {0, 0}));
    scene.bodies[0].velocity = {3, 7};
    scene.settings.substeps = substeps;
    const BodyReport body = body_at_end(scene, 120, 0);
    CHECK(body.center.x == Approx(6).epsilon(1e-12));
    return body.center.y - (14 - 20);
  };
  CHECK(std::log2(error(1) / error(2)) == Approx(1).margin(1e-6));
  CHECK(std::log2(error(8) / error(16)) == Approx(1).margin(1e-6));
}

TEST_CASE("gravity scale and a body's own frame do not change how its centre of mass flies",
          "[engine][flight][analytic]") {
  Body body = body_of(polygon_shape({{0, 0}, {3, 0}, {0, 3}}), {-1, -1});  // centre of mass at the origin
  body.gravity_scale = 0.5;
  body.angular_velocity = 3;
  const Scene scene = flight_scene(Precision::f64, body);
  const BodyReport report = body_at_end(scene, 60, 0);
  CHECK(std::fabs(report.center.x) < 1e-12);
  CHECK(report.center.y == Approx(-2.5 - 5.0 / 60 / 2).epsilon(1e-12));
}

TEST_CASE("a free body spins on with the same speed and angle = w t", "[engine][flight][analytic]") {
  for (const PrecisionCase& c : precision_cases) {
    for (const double spin : {10.0, 100.0, 1000.0}) {
      CAPTURE(c.precision, spin);
      Scene scene = flight_scene(c.precision, unit_box({0, 0}));
      scene.gravity = {0, 0};
      scene.bodies[0].angular_velocity = spin;
      const int tick_count = 600;
      const BodyReport body = body_at_end(scene, tick_count, 0);
      CHECK(std::fabs(body.angular_velocity - spin) <= 1e-12 * spin);
      // Each tick rounds the step angle w dt and the orientation by a few units.
      const double expected = spin * tick_count * scene.settings.dt;
      const double rounding = tick_count * (4 + spin * scene.settings.dt) * 2 * c.epsilon;
      CHECK(std::fabs(std::remainder(body.angle - expected, 2 * pi)) < rounding);
    }
  }
}

TEST_CASE("damping without forces slows down by exp(-c t) exactly", "[engine][flight][analytic]") {
  for (const PrecisionCase& c : precision_cases) {
    for (const double damping : {0.5, 5.0, 1000.0}) {
      CAPTURE(c.precision, damping);
      Scene scene = flight_scene(c.precision, unit_box({0, 0}));
      scene.gravity = {0, 0};
      scene.bodies[0].velocity = {10, -4};
      scene.bodies[0].angular_velocity = 3;
      scene.bodies[0].linear_damping = damping;
      scene.bodies[0].angular_damping = damping;
      const BodyReport body = body_at_end(scene, 60, 0);
      const double factor = std::exp(-damping);
      const double tolerance = 4 * 60 * c.epsilon * 10;
      CHECK(std::fabs(body.velocity.x - 10 * factor) <= tolerance);
      CHECK(std::fabs(body.velocity.y + 4 * factor) <= tolerance);
      CHECK(std::fabs(body.angular_velocity - 3 * factor) <= tolerance);
      CHECK(body.velocity.x >= 0);  // damping never reverses a velocity
    }
  }
}

TEST_CASE("a falling body with drag reaches its terminal speed g / c", "[engine][flight][analytic]") {
  Scene scene = flight_scene(Precision::f64, unit_box({0, 0}));
  scene.bodies[0].linear_damping = 2;
  CHECK(body_at_end(scene, 1200, 0).velocity.y == Approx(-5).epsilon(1e-9));
}

TEST_CASE("discs of 1 kg and 3 kg at 4 and 0 m/s leave at -2 and 2, or -0.5 and 1.5 with restitution 0.5",
          "[engine][collision][analytic]") {
  for (const PrecisionCase& c : precision_cases) {
    for (const double restitution : {1.0, 0.5, 0.0}) {
      CAPTURE(c.precision, restitution);
      const auto engine = engine_of(collision_scene(c.precision, restitution, SolverKind::tgs_soft));
      run_ticks(*engine, 60);
      const std::vector<BodyReport> bodies = engine->bodies();
      const double common = 4.0 * 1 / (1 + 3);
      // The relax pass removes the velocity that the soft contact adds. Rounding remains if no shapes overlap deeply.
      const double tolerance = c.precision == Precision::f64 ? 1e-6 : 1e-5;
      CHECK(bodies[0].velocity.x == Approx(common - restitution * 4 * 3 / 4).margin(tolerance));
      CHECK(bodies[1].velocity.x == Approx(common + restitution * 4 * 1 / 4).margin(tolerance));
      const double momentum = bodies[0].velocity.x + 3 * bodies[1].velocity.x;
      CHECK(std::fabs(momentum - 4) / 4 < (c.precision == Precision::f64 ? 1e-12 : 1e-6));
      CHECK(bodies[0].angular_velocity == 0);
      CHECK(bodies[0].velocity.y == 0);
    }
  }
}

TEST_CASE("the impulse solver keeps momentum in a collision", "[engine][collision][conservation]") {
  const auto engine = engine_of(collision_scene(Precision::f64, 0.5, SolverKind::impulse));
  run_ticks(*engine, 60);
  const std::vector<BodyReport> bodies = engine->bodies();
  CHECK(bodies[0].velocity.x < 1);  // the bodies collided
  CHECK(std::fabs(bodies[0].velocity.x + 3 * bodies[1].velocity.x - 4) < 4e-12);
}

TEST_CASE("approaches slower than the restitution threshold do not bounce, faster ones do",
          "[engine][collision][analytic]") {
  Scene scene = collision_scene(Precision::f64, 1, SolverKind::tgs_soft);
  scene.settings.restitution_threshold = 5;
  auto engine = engine_of(scene);
  run_ticks(*engine, 60);
  CHECK(engine->bodies()[0].velocity.x == Approx(1).margin(1e-6));
  scene.settings.restitution_threshold = 3;
  engine = engine_of(scene);
  run_ticks(*engine, 60);
  CHECK(engine->bodies()[0].velocity.x == Approx(-2).margin(1e-6));
}

TEST_CASE("collisions without gravity keep momentum and never add energy", "[engine][collision][conservation]") {
  for (const PrecisionCase& c : precision_cases) {
    for (const double restitution : {0.0, 0.5, 1.0}) {
      CAPTURE(c.precision, restitution);
      Scene scene = empty_scene(c.precision);
      scene.gravity = {0, 0};
      for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
          scene.bodies.push_back(row % 2 == 0 ? unit_box({1.1 * column, 1.1 * row})
                                              : body_of(disc_shape(0.5), {1.1 * column + 0.05, 1.1 * row}));
      scene.bodies.push_back(body_of(disc_shape(0.5), {-4, 1.4}));
      scene.bodies.back().velocity = {12, 1};
      set_restitution(scene, restitution);
      const auto engine = engine_of(scene);
      const auto momentum_and_energy = [&] {
        std::vector<double> sums(4, 0);  // px, py, angular momentum about the origin, energy
        for (const BodyReport& body : engine->bodies()) {
          sums[0] += body.mass * body.velocity.x;
          sums[1] += body.mass * body.velocity.y;
          sums[2] += body.mass * (body.center.x * body.velocity.y - body.center.y * body.velocity.x) +
                     body.inertia * body.angular_velocity;
          sums[3] += 0.5 * body.mass * (body.velocity.x * body.velocity.x + body.velocity.y * body.velocity.y) +
                     0.5 * body.inertia * body.angular_velocity * body.angular_velocity;
        }
        return sums;
      };
      const std::vector<double> before = momentum_and_energy();
      run_ticks(*engine, 180);
      const std::vector<double> after = momentum_and_energy();
      const double relative = 1000 * 4 * c.epsilon;  // a few roundings per substep
      CHECK(std::fabs(after[0] - before[0]) < relative * before[0]);
      CHECK(std::fabs(after[1] - before[1]) < relative * before[0]);
      CHECK(after[3] <= before[3] * (1 + 1e-3));
      CHECK(after[3] > 0);
    }
  }
}

TEST_CASE("a bouncing disc rises to restitution squared of its height, as closely as a tick lets it",
          "[engine][collision][analytic]") {
  // The bounce uses the speed at the start of the tick of impact, which lacks up to g dt. With impact speed v, each
  // bounce therefore loses up to 2 g dt / v of the height. The position is off by at most v h.
  for (const PrecisionCase& c : precision_cases) {
    for (const double dt : {1.0 / 240, 1.0 / 960}) {
      CAPTURE(c.precision, dt);
      Scene scene = empty_scene(c.precision);
      scene.settings.dt = dt;
      scene.settings.restitution_threshold = 0.1;
      scene.bodies = {ground(), body_of(disc_shape(0.5), {0, 1.5})};
      set_restitution(scene, 0.8);
      const auto engine = engine_of(scene);
      std::vector<double> apexes;
      double velocity = 0;  // of the previous tick
      for (int tick = 0; tick * dt < 3 && apexes.size() < 3; ++tick) {
        run_ticks(*engine, 1);
        const BodyReport disc = engine->bodies()[1];
        if (velocity > 0 && disc.velocity.y <= 0) apexes.push_back(disc.center.y - 0.5);
        velocity = disc.velocity.y;
      }
      REQUIRE(apexes.size() == 3);
      double expected = 1;
      double lost = 0;
      double speed = std::sqrt(2 * 10.0);
      for (const double apex : apexes) {
        expected *= 0.64;
        lost += 2 * 10 * dt / speed;
        const double late = speed * dt / 4;
        CHECK(apex < expected + late);
        CHECK(apex > expected * (1 - lost) - late);
        speed *= 0.8;
      }
    }
  }
}

TEST_CASE("a box at 10 m/s on friction 0.5 stops after 10 m, short by v0 h / 2", "[engine][friction][analytic]") {
  for (const PrecisionCase& c : precision_cases) {
    for (const int substeps : {4, 8}) {
      CAPTURE(c.precision, substeps);
      Scene scene = slide_scene(10, 0.5, c.precision);
      scene.settings.substeps = substeps;
      const auto engine = engine_of(scene);
      run_ticks(*engine, 150);
      const BodyReport box = engine->bodies()[1];
      const double bias = 10 * (scene.settings.dt / substeps) / 2;
      CHECK(std::fabs(box.center.x - 10) < 0.0025 * 10);
      CHECK(10 - box.center.x == Approx(bias).epsilon(0.1));
      CHECK(std::fabs(box.velocity.x) < 1e-3);
      CHECK(std::fabs(box.angle) < 1e-3);
    }
  }
}

TEST_CASE("without friction a sliding box keeps its speed", "[engine][friction][conservation]") {
  for (const PrecisionCase& c : precision_cases) {
    CAPTURE(c.precision);
    const Scene scene = slide_scene(10, 0, c.precision);
    CHECK(body_at_end(scene, 300, 1).velocity.x == Approx(10).epsilon(c.precision == Precision::f64 ? 1e-9 : 1e-5));
  }
}

TEST_CASE("a box on a slope of 20 degrees holds above friction tan 20 and slips below it",
          "[engine][friction][analytic]") {
  const engine::SinCos slope = engine::sin_cos(20 * pi / 180);
  for (const PrecisionCase& c : precision_cases) {
    CAPTURE(c.precision);
    Scene scene = slide_scene(0, 1.05 * slope.sin / slope.cos, c.precision);
    scene.gravity = gravity_on_slope(20);
    CHECK(std::fabs(body_at_end(scene, 600, 1).center.x) < 1e-3);

    set_friction(scene, 0.95 * slope.sin / slope.cos);
    const auto engine = engine_of(scene);
    run_ticks(*engine, 60);
    const double speed = engine->bodies()[1].velocity.x;
    run_ticks(*engine, 60);
    const BodyReport box = engine->bodies()[1];
    const double acceleration = 10 * 0.05 * slope.sin;  // g (sin - mu cos)
    CHECK(box.velocity.x - speed == Approx(acceleration).epsilon(c.precision == Precision::f64 ? 1e-6 : 1e-3));
    // In the first substep there is no normal force and no friction. The box gains at most g sin h there, and keeps it.
    const double h = scene.settings.dt / scene.settings.substeps;
    CHECK(box.center.x > acceleration * 4 / 2);
    CHECK(box.center.x < acceleration * 4 / 2 + 10 * slope.sin * h * 2);
  }
}

TEST_CASE("a disc rolls down a slope with two thirds of g sin, without slipping", "[engine][friction][analytic]") {
  Scene scene = empty_scene();
  scene.gravity = gravity_on_slope(20);
  scene.bodies = {ground(), body_of(disc_shape(0.5), {0, 0.5})};
  set_friction(scene, 0.5);
  const BodyReport disc = body_at_end(scene, 120, 1);
  CHECK(disc.center.x == Approx(4.560269).epsilon(0.005));
  CHECK(disc.velocity.x == Approx(2 * 2.280134).epsilon(0.005));
  // During a tick, the anchor of a contact rotates with its body. It therefore seems to rise by at most r (1 - cos w
  // dt).
  const double spin = disc.angular_velocity;
  const double lift = 0.5 * (1 - engine::sin_cos(spin * scene.settings.dt).cos);
  CHECK(std::fabs(disc.center.y - 0.5) < lift);
  CHECK(std::fabs(disc.velocity.x + 0.5 * spin) < lift * std::fabs(spin));
}

TEST_CASE("a box twice as high as wide topples above 26.565 degrees, not below", "[engine][friction][analytic]") {
  const auto tilt = [](double degrees) {
    Scene scene = empty_scene();
    scene.gravity = gravity_on_slope(degrees);
    scene.bodies = {ground(), body_of(box_shape(0.5, 1), {0, 1})};
    set_friction(scene, 2);
    return std::fabs(body_at_end(scene, 360, 1).angle) * 180 / pi;
  };
  CHECK(tilt(26.0) < 1);
  CHECK(tilt(27.1) > 45);
}

TEST_CASE("the force under each box of a stack of ten is the weight upon it", "[engine][stack][analytic]") {
  for (const PrecisionCase& c : precision_cases) {
    CAPTURE(c.precision);
    const auto engine = engine_of(stack_scene(10, 0, c.precision));
    run_ticks(*engine, 600);
    for (std::uint32_t i = 1; i <= 10; ++i) {
      CAPTURE(i);
      CHECK(force_under(*engine, i) == Approx(10.0 * (11 - i)).epsilon(0.001));
    }
  }
}

TEST_CASE("soft contacts sink in by weight / (w^2 * effective mass), less with the square of the substeps",
          "[engine][stack][analytic]") {
  for (const int substeps : {4, 8, 16}) {
    CAPTURE(substeps);
    Scene scene = stack_scene(10);
    scene.settings.substeps = substeps;
    const auto engine = engine_of(scene);
    run_ticks(*engine, 600);
    const double omega = 2 * pi * 0.125 * substeps / scene.settings.dt;
    for (const ContactReport& contact : engine->contacts()) {
      if (contact.body_a == 0 || contact.body_b == 0) continue;  // contacts with the ground are stiffer
      const double weight = 10.0 * (11 - std::max(contact.body_a, contact.body_b));
      const double sag = -(contact.separation[0] + contact.separation[1]) / 2;
      CHECK(sag == Approx(weight / (omega * omega * 0.4)).epsilon(0.01));  // two points of 0.2 kg each
    }
  }
}

TEST_CASE("a stack of ten stands for 20 s under tgs_soft and falls under the thesis' impulse solver",
          "[engine][stack][analytic]") {
  for (const PrecisionCase& c : precision_cases) {
    CAPTURE(c.precision);
    Scene scene = stack_scene(10, 0, c.precision);
    const BodyReport standing = body_at_end(scene, 1200, 10);
    CHECK(standing.center.y == Approx(9.5).epsilon(0.01));
    CHECK(std::fabs(standing.center.x) < 0.01);
    CHECK(std::fabs(standing.angle) < 0.01);
    CHECK(std::hypot(standing.velocity.x, standing.velocity.y) < 0.01);

    scene.settings.solver = SolverKind::impulse;
    scene.settings.substeps = 1;
    CHECK(body_at_end(scene, 1200, 10).center.y < 8);
  }
}

TEST_CASE("a box carries one ten times as heavy, with exact forces", "[engine][stack][analytic]") {
  Scene scene = stack_scene(2);
  scene.bodies[2].mass = engine::ExplicitMass{10, {}, {}};
  const auto engine = engine_of(scene);
  run_ticks(*engine, 600);
  CHECK(force_under(*engine, 2) == Approx(100).epsilon(0.001));
  CHECK(force_under(*engine, 1) == Approx(110).epsilon(0.001));
  CHECK(engine->bodies()[2].center.y == Approx(1.5).epsilon(0.02));
}

TEST_CASE("a pyramid carries its whole weight on the ground", "[engine][stack][analytic]") {
  const auto engine = engine_of(pyramid_scene(8, Precision::f32));
  run_ticks(*engine, 600);
  double force = 0;
  for (const ContactReport& contact : engine->contacts())
    if (contact.body_a == 0 || contact.body_b == 0) force += contact.normal_force[0] + contact.normal_force[1];
  CHECK(force == Approx(360).epsilon(0.001));
}
