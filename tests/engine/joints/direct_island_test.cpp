// Jointed bodies with the direct solver, without the rest of the engine: gaps, energy, order, guards.
// SPDX-License-Identifier: MIT
//
// The step is velocity Verlet with half kicks: kick, positions, move, kick, projection. Springs are tested with one
// whole kick before the positions, as in semi-implicit Euler, because a spring's step includes everything that acts on
// its constraint.
#include "engine/joints/direct/direct_island.h"

#include <algorithm>
#include <cmath>

#include "engine/math/trig.h"
#include "tests/support/catch.h"

using namespace ticktrue;
using namespace ticktrue::engine;

namespace {

constexpr double earth_gravity = 9.81;

std::uint32_t add_rod(DirectIsland& island, Place center, double angle, double mass) {
  const SinCos turn = sin_cos(angle);
  DirectBody body;
  body.pose = {center, turn.cos, turn.sin};
  body.mass = mass;
  body.inertia = mass / 12;
  island.bodies.push_back(body);
  return static_cast<std::uint32_t>(island.bodies.size() - 1);
}

Place in_frame(const DirectIsland& island, std::uint32_t body, Place p) {
  if (body == no_direct_body) return p;
  const Pose& pose = island.bodies[body].pose;
  const Place d{p.x - pose.position.x, p.y - pose.position.y};
  return {pose.c * d.x + pose.s * d.y, pose.c * d.y - pose.s * d.x};
}

void join(DirectIsland& island, JointKind kind, std::uint32_t a, std::uint32_t b, Place at) {
  DirectJoint joint;
  JointShape shape;
  shape.kind = kind;
  shape.anchor_a = in_frame(island, a, at);
  shape.anchor_b = in_frame(island, b, at);
  const Pose p = a == no_direct_body ? Pose{} : island.bodies[a].pose;
  const Pose q = island.bodies[b].pose;
  shape.reference_c = p.c * q.c + p.s * q.s;
  shape.reference_s = p.c * q.s - p.s * q.c;
  joint.body_a = a;
  joint.body_b = b;
  island.joints.push_back(joint);
  island.shapes.push_back(shape);
}

// Makes the joint's degree of freedom driven. Call in the order of joints.
void drive_joint(DirectIsland& island, std::size_t joint, const DirectDrive& drive) {
  island.shapes[joint].is_driven = true;
  island.joints[joint].first_drive = static_cast<std::uint32_t>(island.drives.size());
  island.drives.push_back(drive);
}

// Rods of 1 m and 1 kg, `angle` from hanging down.
DirectIsland chain_of(std::uint32_t count, double angle, double end_mass = 1) {
  DirectIsland island;
  const Place along{std::sin(angle), -std::cos(angle)};
  Place at;
  std::uint32_t last = no_direct_body;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double mass = i + 1 == count ? end_mass : 1;
    const std::uint32_t rod = add_rod(island, {at.x + 0.5 * along.x, at.y + 0.5 * along.y}, angle - 0.5 * pi, mass);
    join(island, JointKind::revolute, last, rod, at);
    at = {at.x + along.x, at.y + along.y};
    last = rod;
  }
  order_island(island);
  return island;
}

// Eight rods on revolute joints around a body, all rotating as one.
DirectIsland hub_of(double spin) {
  DirectIsland island;
  add_rod(island, {0, 0}, 0, 1);
  for (int i = 0; i < 8; ++i) {
    const double angle = i * pi / 4;
    const Place out{std::cos(angle), std::sin(angle)};
    const std::uint32_t rod = add_rod(island, {0.7 * out.x, 0.7 * out.y}, angle, 1);
    join(island, JointKind::revolute, 0, rod, {0.2 * out.x, 0.2 * out.y});
  }
  for (DirectBody& body : island.bodies) {
    const Place p = body.pose.position;
    body.velocity = {-spin * p.y, spin * p.x, spin};
  }
  order_island(island);
  return island;
}

double energy_of(const DirectIsland& island, double gravity) {
  double sum = 0;
  for (const DirectBody& body : island.bodies) {
    const Triple& v = body.velocity;
    sum += 0.5 * body.mass * (v[0] * v[0] + v[1] * v[1]) + 0.5 * body.inertia * v[2] * v[2] +
           body.mass * gravity * body.pose.position.y;
  }
  return sum;
}

double gap_of(const DirectIsland& island) {
  double most = 0;
  for (const DirectJoint& joint : island.joints)
    for (std::size_t row = 0; row < joint.equations.row_count; ++row)
      most = std::max(most, std::fabs(joint.equations.errors[row]));
  return most;
}

struct IslandRun {
  double gap = 0;
  double energy_least = 0;  // the change of the energy
  double energy_most = 0;
  int guarded = 0;
};

IslandRun run_island(DirectIsland& island, double seconds, int steps_per_second, int passes,
                     double gravity = earth_gravity, double first_kick = 0.5) {
  const double h = 1.0 / steps_per_second;
  IslandRun outcome;
  const auto kick = [&](double t) {
    for (DirectBody& body : island.bodies) body.velocity[1] -= t * gravity;
  };
  factor_island(island);
  project_velocities(island);
  const double start = energy_of(island, gravity);
  for (int i = 0; i < static_cast<int>(seconds * steps_per_second + 0.5); ++i) {
    begin_substep(island, h);
    kick(first_kick * h);
    start_impulses(island);
    outcome.guarded += meet_positions(island, h, 0, passes) != PositionOutcome::met ? 1 : 0;
    for (DirectBody& body : island.bodies) body.pose = moved(body, h);
    factor_island(island);
    end_push(island);
    kick((1 - first_kick) * h);
    project_velocities(island);
    outcome.gap = std::max(outcome.gap, gap_of(island));
    const double change = energy_of(island, gravity) - start;
    outcome.energy_least = std::min(outcome.energy_least, change);
    outcome.energy_most = std::max(outcome.energy_most, change);
  }
  return outcome;
}

Place end_of_chain(double angle, int steps_per_second) {
  DirectIsland island = chain_of(3, angle);
  run_island(island, 0.5, steps_per_second, 6);
  return island.bodies.back().pose.position;
}

// A body of 2 kg on a vertical rail, with a drive along the rail.
DirectIsland rail_with(const DirectDrive& drive) {
  DirectIsland island;
  add_rod(island, {0, 0}, 0, 2);
  join(island, JointKind::prismatic, no_direct_body, 0, {0, 0});
  island.shapes[0].axis = {0, 1};
  drive_joint(island, 0, drive);
  order_island(island);
  return island;
}

// A fan of light rods on a body 4,000 times as heavy. At the start no constraint is satisfied.
DirectIsland loose_fan(std::uint32_t seed) {
  DirectIsland island;
  add_rod(island, {0, 0}, 0, 4);
  std::uint32_t last = 0;
  for (std::uint32_t i = 0; i < 6; ++i) {
    const double angle = 0.7 * (i + seed);
    const Place at{0.3 * std::cos(angle), 0.3 * std::sin(angle)};
    const std::uint32_t rod = add_rod(island, {2 * at.x, 2 * at.y}, angle, 1e-3);
    join(island, i % 2 == 0 ? JointKind::revolute : JointKind::weld, i % 3 == 2 ? last : 0, rod, at);
    last = rod;
  }
  for (std::uint32_t i = 0; i < island.bodies.size(); ++i)
    island.bodies[i].velocity = {std::sin(3.0 * i + seed), std::cos(5.0 * i + seed), std::sin(7.0 * i + seed)};
  order_island(island);
  return island;
}

Place momentum_of(const DirectIsland& island) {
  Place sum;
  for (const DirectBody& body : island.bodies) {
    sum.x += body.mass * body.velocity[0];
    sum.y += body.mass * body.velocity[1];
  }
  return sum;
}

}  // namespace

TEST_CASE("direct joints between bodies alone keep momentum to rounding", "[engine][joints][direct]") {
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    DirectIsland island = loose_fan(seed);
    REQUIRE(island.is_free);
    const Place before = momentum_of(island);
    run_island(island, 1, 60, 4, 0);
    const Place after = momentum_of(island);
    CAPTURE(seed);
    CHECK(std::fabs(after.x - before.x) < 60 * 1e-15);
    CHECK(std::fabs(after.y - before.y) < 60 * 1e-15);
  }
  CHECK_FALSE(chain_of(3, 0.1).is_free);
}

TEST_CASE("a hanging chain holds a hundred times its mass", "[engine][joints][direct]") {
  DirectIsland island = chain_of(100, 0, 100);
  const IslandRun outcome = run_island(island, 1, 240, 2);
  REQUIRE(outcome.gap < 1e-9);
  REQUIRE(outcome.guarded == 0);
  REQUIRE(std::fabs(island.bodies.back().pose.position.y + 99.5) < 1e-7);
}

TEST_CASE("a swinging chain keeps its energy", "[engine][joints][direct]") {
  DirectIsland island = chain_of(20, pi / 3);
  const double fall = 20 * earth_gravity * 10 * 0.5;  // J, energy from the start down to hanging
  const IslandRun outcome = run_island(island, 10, 240, 4);
  REQUIRE(outcome.gap < 1e-7);
  REQUIRE(outcome.energy_least > -0.01 * fall);
  REQUIRE(outcome.energy_most < 0.01 * fall);
  REQUIRE(outcome.guarded == 0);
}

TEST_CASE("a floating hub with rods neither gains nor loses", "[engine][joints][direct]") {
  for (const double spin : {5.0, 20.0, 50.0}) {
    DirectIsland island = hub_of(spin);
    const double energy = energy_of(island, 0);
    const IslandRun outcome = run_island(island, 5, 240, 4, 0);
    INFO(spin << " rad/s");
    REQUIRE(outcome.gap < 1e-6);
    REQUIRE(outcome.energy_most < 1e-3 * energy);
    REQUIRE(outcome.energy_least > -1e-3 * energy);
  }
}

TEST_CASE("what spins too fast for the substep loses energy and gains none", "[engine][joints][direct]") {
  for (const double spin : {200.0, 400.0}) {
    DirectIsland island = hub_of(spin);
    const double energy = energy_of(island, 0);
    const IslandRun outcome = run_island(island, 8, 240, 4, 0);
    INFO(spin << " rad/s");
    REQUIRE(outcome.guarded > 0);
    REQUIRE(outcome.energy_most < 1e-3 * energy);
    REQUIRE(gap_of(island) < 1e-4);  // the gap that the guards tolerated has closed
  }
}

TEST_CASE("half kicks with the direct solver are of order 2", "[engine][joints][direct]") {
  const Place exact = end_of_chain(1, 15360);
  const auto error = [&exact](int steps_per_second) {
    const Place p = end_of_chain(1, steps_per_second);
    return std::hypot(p.x - exact.x, p.y - exact.y);
  };
  const double coarse = error(240);
  const double fine = error(480);
  REQUIRE(std::log2(coarse / fine) == Approx(2).margin(0.15));
}

TEST_CASE("a gap closes softly and leaves no speed", "[engine][joints][direct]") {
  DirectIsland island = chain_of(5, 0);
  for (DirectBody& body : island.bodies) body.pose.position.x += 0.3;
  const IslandRun outcome = run_island(island, 3, 240, 2, 0);
  REQUIRE(gap_of(island) < 1e-6);
  REQUIRE(outcome.energy_most < 0.5 * 5 * 0.1 * 0.1);
}

TEST_CASE("welded nets that hold themselves several times over stay as they are", "[engine][joints][direct]") {
  DirectIsland island;
  for (std::uint32_t i = 0; i < 9; ++i) {
    const double x = i % 3;
    const double y = -static_cast<double>(i / 3);
    add_rod(island, {x, y}, 0, 1);
    if (i % 3 > 0) join(island, JointKind::weld, i - 1, i, {x - 0.5, y});
    if (i >= 3) join(island, JointKind::weld, i - 3, i, {x, y + 0.5});
  }
  for (DirectBody& body : island.bodies) {
    const Place p = body.pose.position;
    body.velocity = {-20 * (p.y + 1), 20 * (p.x - 1), 20};
  }
  order_island(island);
  const double energy = energy_of(island, 0);
  const IslandRun outcome = run_island(island, 3, 240, 4, 0);
  REQUIRE(outcome.gap < 1e-6);
  REQUIRE(outcome.energy_least > -1e-3 * energy);
  REQUIRE(outcome.energy_most < 1e-3 * energy);
}

TEST_CASE("a spring carries its load at rest", "[engine][joints][direct]") {
  // 400 N/m, damped at 40 N s/m, for 2 kg: the exact step of engine/joints/joint_spring.h in closed form.
  const double h = 1.0 / 240;
  const double a = 0.5 * 40 / 2;
  const double w2 = 400 / 2.0;
  const double s = std::exp(-h * a);
  const double beyond = h * h * (w2 - a * a) * 0.5;
  const double full = (1 - s) * (1 - s) + 2 * s * beyond / (1 + beyond);
  DirectDrive drive;
  drive.has_spring = true;
  drive.loss = (1 - s) * (1 + s);
  drive.pull = full / h;
  drive.give = 1 - full / (h * h * w2);
  DirectIsland island = rail_with(drive);
  run_island(island, 5, 240, 2, earth_gravity, 1);
  REQUIRE(island.bodies[0].pose.position.y == Approx(-2 * earth_gravity / 400).epsilon(1e-6));
  REQUIRE(std::fabs(island.bodies[0].velocity[1]) < 1e-9);
}

TEST_CASE("a motor reaches its speed, or pushes with all its force", "[engine][joints][direct]") {
  DirectDrive drive;
  drive.has_motor = true;
  drive.motor_speed = 1;
  const auto speed_after = [&drive](double force) {
    drive.motor_impulse_max = force / 240;
    DirectIsland island = rail_with(drive);
    run_island(island, 0.5, 240, 2, earth_gravity, 1);
    return island.bodies[0].velocity[1];
  };
  REQUIRE(speed_after(100) == Approx(1).epsilon(1e-9));
  REQUIRE(speed_after(10) == Approx(0.5 * (10 / 2.0 - earth_gravity)).epsilon(1e-9));
}

TEST_CASE("limits hold a pendulum and let it go", "[engine][joints][direct]") {
  DirectIsland island = chain_of(2, 0);
  DirectDrive limits;
  limits.has_limits = true;
  limits.lower = -0.25;
  limits.upper = 0.25;
  for (std::size_t i = 0; i < island.joints.size(); ++i) drive_joint(island, i, limits);
  order_island(island);
  island.bodies[0].velocity = {1, 0, 2};
  island.bodies[1].velocity = {3, 0, 2};
  double widest = 0;
  bool was_held = false;
  bool was_free = false;
  for (int i = 0; i < 240; ++i) {
    run_island(island, 1.0 / 240, 240, 3);
    for (const DirectJoint& joint : island.joints) {
      widest = std::max(widest, std::fabs(joint.equations.errors[2]));
      const bool is_held = is_at_limit(island.drives[joint.first_drive]);
      was_free = was_free || (was_held && !is_held);
      was_held = was_held || is_held;
    }
  }
  REQUIRE(was_held);
  REQUIRE(was_free);
  REQUIRE(widest == Approx(0.25).margin(1e-6));
}
