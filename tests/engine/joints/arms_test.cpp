// Arms of jointed bodies hit something: they stop or bounce as one body, and get no energy from it.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/random.h"
#include "tests/support/engine_runs.h"
#include "tests/support/joint_gaps.h"
#include "tests/support/joints.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::BodyReport;
using engine::Engine;

namespace {

enum class JointChoice { iterative, direct, direct_64, automatic };

void choose_joints(Scene& scene, JointChoice joints) {
  if (joints == JointChoice::automatic) engine::choose_substeps(scene.settings);
  if (joints == JointChoice::direct || joints == JointChoice::direct_64)
    scene.settings.joints = engine::JointSolverKind::direct;
  if (joints == JointChoice::direct_64) scene.settings.substeps = 64;
}

void set_surfaces(Scene& scene, double friction, double restitution) {
  for (Body& body : scene.bodies)
    for (engine::Shape& shape : body.shapes) {
      shape.material.friction = friction;
      shape.material.restitution = restitution;
    }
}

Body arm_box(double half_length, Point position, double mass) {
  Body body = body_of(box_shape(half_length, 0.2 * half_length), position);
  body.mass = engine::ExplicitMass{mass, {}, {}};
  return body;
}

// `count` welded boxes of 1 m and 1 kg in a row about the origin, without gravity. They move up with `speed` towards a
// fixed disc of .1 m, whose centre is `x` beside the middle of the row.
Scene welded_rod(Precision precision, int count, double speed, double x, double restitution) {
  Scene scene = empty_scene(precision);
  scene.gravity = {0, 0};
  for (int i = 0; i < count; ++i) {
    scene.bodies.push_back(arm_box(0.5, {i - 0.5 * (count - 1), 0}, 1));
    scene.bodies.back().velocity = {0, speed};
    if (i == 0) continue;
    Joint weld = joint_of(JointKind::weld, static_cast<std::uint32_t>(i - 1), static_cast<std::uint32_t>(i));
    weld.anchor_a = {0.5, 0};
    weld.anchor_b = {-0.5, 0};
    scene.joints.push_back(weld);
  }
  scene.bodies.push_back(body_of(disc_shape(0.1), {x, 0.3}, BodyType::static_body));
  set_surfaces(scene, 0, restitution);
  return scene;
}

double arm_energy(const Engine& engine) {
  double sum = 0;
  for (const BodyReport& body : engine.bodies()) {
    const Point v = body.velocity;
    sum += body.mass * (v.x * v.x + v.y * v.y) / 2 + body.inertia * body.angular_velocity * body.angular_velocity / 2;
  }
  return sum;
}

}  // namespace

TEST_CASE("a rod of welded boxes hits as one body", "[engine][joints][arms]") {
  const Precision precision = GENERATE(Precision::f32, Precision::f64);
  const JointChoice joints = GENERATE(JointChoice::direct, JointChoice::automatic);
  const int count = GENERATE(2, 3, 6);
  const double share = GENERATE(0.2, 0.9);  // of the half length: where it hits
  const double restitution = GENERATE(0.0, 0.7);
  CAPTURE(precision, static_cast<int>(joints), count, share, restitution);
  const double speed = 2;
  const double x = share * count / 2;
  Scene scene = welded_rod(precision, count, speed, x, restitution);
  choose_joints(scene, joints);
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 12);
  // J (1 / m + x^2 / I) = (1 + e) v
  const double mass = count;
  const double inertia = mass * (count * count + 0.04) / 12;
  const double impulse = (1 + restitution) * speed / (1 / mass + x * x / inertia);
  const double spin = -impulse * x / inertia;
  double momentum = 0;
  for (const BodyReport& body : engine->bodies()) momentum += body.mass * body.velocity.y;
  CHECK_THAT(momentum, Catch::Matchers::WithinAbs(mass * speed - impulse, 0.02 * mass * speed));
  for (int i = 0; i < count; ++i)
    CHECK_THAT(engine->bodies()[i].angular_velocity, Catch::Matchers::WithinAbs(spin, 0.02 * std::fabs(spin) + 0.02));
}

TEST_CASE("friction of an impact acts on the whole rod", "[engine][joints][arms]") {
  const Precision precision = GENERATE(Precision::f32, Precision::f64);
  const double along = GENERATE(-1.0, 1.0);  // m/s: the rod slides along the disc
  CAPTURE(precision, along);
  constexpr int count = 3;
  constexpr double speed = 2, up = 0.1, friction = 0.2;
  Scene scene = welded_rod(precision, count, speed, 0.9, 0);
  set_surfaces(scene, friction, 0);
  for (int i = 0; i < count; ++i) scene.bodies[i].velocity.x = along;
  const double x = 0.9 - along * (0.1 / speed);  // on the rod, which has slid until it hits
  const double mass = count;
  const double inertia = mass * (count * count + 0.04) / 12;
  const auto momentum_of = [](const Engine& engine) {
    double sum = 0;
    for (const BodyReport& body : engine.bodies()) sum += body.mass * body.velocity.x;
    return sum;
  };
  SECTION("of a fixed disc") {
    choose_joints(scene, JointChoice::automatic);
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 4);
    // The contact slides throughout: J (1 / m + x (x - up mu sign) / I) = v
    const double impulse = speed / (1 / mass + x * (x - up * friction * along) / inertia);
    for (const BodyReport& body : engine->bodies())
      if (body.mass > 0)
        CHECK_THAT(body.angular_velocity,
                   Catch::Matchers::WithinAbs((up * friction * along - x) * impulse / inertia, 0.03));
    CHECK_THAT(momentum_of(*engine),
               Catch::Matchers::WithinAbs(mass * along - friction * along * impulse, 0.03 * mass));
  }
  SECTION("of a conveyor that keeps up with the rod") {
    scene.bodies.back().shapes[0].material.tangent_speed = along;  // counter-clockwise: to the right below the disc
    choose_joints(scene, JointChoice::direct);
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 4);
    // The contact sticks: T = m up w,  w (1 + m up^2 / I) = -x J / I,  J / m - x w = v
    const double spin_per_impulse = x / inertia / (1 + mass * up * up / inertia);
    const double spin = -spin_per_impulse * speed / (1 / mass + x * spin_per_impulse);
    CHECK_THAT(momentum_of(*engine), Catch::Matchers::WithinAbs(mass * along + mass * up * spin, 0.03 * mass));
  }
}

// `count` welded boxes of 1 m and 1 kg that turn about a hinge at one end, without gravity. A fixed disc is in their
// way.
Scene hinged_rod(Precision precision, int count, double turn, double restitution) {
  Scene scene = welded_rod(precision, count, 0, 0, restitution);
  scene.bodies.pop_back();
  for (int i = 0; i < count; ++i) {
    scene.bodies[i].position = {i + 0.5, 0};
    scene.bodies[i].velocity = {0, turn * (i + 0.5)};
    scene.bodies[i].angular_velocity = turn;
  }
  scene.bodies.push_back(body_of(disc_shape(0.1), {0.8, 0.5}, BodyType::static_body));
  set_surfaces(scene, 0.3, restitution);
  scene.bodies.push_back(peg({0, 0}));
  scene.bodies.back().shapes[0].filter.mask = 0;
  Joint hinge = joint_of(JointKind::revolute, static_cast<std::uint32_t>(count + 1), 0);
  hinge.anchor_a = {0, 0};
  hinge.anchor_b = {-0.5, 0};
  scene.joints.push_back(hinge);
  return scene;
}

TEST_CASE("a fast arm bounces off a disc as one body", "[engine][joints][arms][impacts]") {
  const Precision precision = GENERATE(Precision::f32, Precision::f64);
  const JointChoice joints = GENERATE(JointChoice::direct, JointChoice::direct_64, JointChoice::iterative);
  const int count = GENERATE(1, 2, 5);
  const double turn = GENERATE(4.0, 12.0);
  const double restitution = GENERATE(0.0, 0.8);
  const bool locates = GENERATE(false, true);
  CAPTURE(precision, static_cast<int>(joints), count, turn, restitution, locates);
  Scene scene = hinged_rod(precision, count, turn, restitution);
  choose_joints(scene, joints);
  scene.settings.locate_impacts = locates;
  const auto engine = make_engine_or_fail(scene);
  // Direct joints meet their positions in the substep of a bounce. An arm that stops has later impacts as well.
  const double gap_max = joints == JointChoice::iterative ? 0.03 : restitution > 0 ? 1e-5 : 1e-3;
  for (int tick = static_cast<int>(std::lround(0.6 / turn * 60)) + 2; tick > 0; --tick) {
    run_ticks(*engine, 1);
    for (const JointGap& gap : joint_gaps(scene, engine->bodies())) CHECK(gap.gap < gap_max);
  }
  // The hinge takes a part of the impulse, and the angular speed follows Newton's law. Iterative joints give.
  const double share = joints == JointChoice::iterative ? 0.08 : 0.005;
  for (int i = 0; i < count; ++i)
    CHECK_THAT(engine->bodies()[i].angular_velocity, Catch::Matchers::WithinAbs(-restitution * turn, share * turn));
}

TEST_CASE("a slow arm stops at a disc with any number of substeps", "[engine][joints][arms][impacts]") {
  const Precision precision = GENERATE(Precision::f32, Precision::f64);
  const bool is_direct = GENERATE(false, true);
  const int substeps = GENERATE(4, 16, 64);
  const int count = GENERATE(1, 2, 5);
  CAPTURE(precision, is_direct, substeps, count);
  Scene scene = hinged_rod(precision, count, 1, 0);
  if (is_direct) scene.settings.joints = engine::JointSolverKind::direct;
  scene.settings.substeps = substeps;
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 60);
  CHECK_THAT(engine->bodies()[0].angular_velocity, Catch::Matchers::WithinAbs(0, 0.005));
}

TEST_CASE("no arm passes through a disc", "[engine][joints][arms][impacts]") {
  const Precision precision = GENERATE(Precision::f32, Precision::f64);
  const JointChoice joints = GENERATE(JointChoice::direct, JointChoice::iterative);
  const int count = GENERATE(2, 3, 5);
  const double turn = GENERATE(20.0, 40.0, 55.0);
  CAPTURE(precision, static_cast<int>(joints), count, turn);
  Scene scene = hinged_rod(precision, count, turn, 0);
  choose_joints(scene, joints);
  const auto engine = make_engine_or_fail(scene);
  for (int tick = 0; tick < 30; ++tick) {
    run_ticks(*engine, 1);
    CHECK(engine->bodies()[0].angle < 0.7);  // it touches the disc at .38 rad
  }
}

// Its inner contacts hold almost still what the joints hold as well, so impulses there could grow without bound.
TEST_CASE("an arm that folds onto itself gets no energy", "[engine][joints][arms]") {
  const Precision precision = GENERATE(Precision::f32, Precision::f64);
  const int substeps = GENERATE(4, 16, 64);
  CAPTURE(precision, substeps);
  constexpr double half = 0.2622615, turn = 4.8371464;
  constexpr double masses[] = {1.4544584, 0.3055600, 0.4184860, 0.7966293, 0.2903450, 0.2060803, 0.6254485, 3.7610559};
  Scene scene = empty_scene(precision);
  scene.gravity = {0, 0};
  scene.settings.joints = engine::JointSolverKind::direct;
  scene.settings.substeps = substeps;
  scene.bodies.push_back(peg({0, 0}));
  scene.bodies[0].shapes[0].filter.mask = 0;
  for (std::uint32_t i = 0; i < std::size(masses); ++i) {
    const double x = (2 * i + 1) * half;
    scene.bodies.push_back(arm_box(half, {x, 0}, masses[i]));
    scene.bodies.back().velocity = {0, turn * x};
    scene.bodies.back().angular_velocity = turn;
    Joint joint = joint_of(i == 0 || i == 5 ? JointKind::revolute : JointKind::weld, i, i + 1);
    joint.anchor_a = i == 0 ? Point{0, 0} : Point{half, 0};
    joint.anchor_b = {-half, 0};
    scene.joints.push_back(joint);
  }
  scene.bodies.push_back(body_of(disc_shape(0.2 * half), {0.6234942, 0.3648766}, BodyType::static_body));
  set_surfaces(scene, 0.6, 0);
  const auto engine = make_engine_or_fail(scene);
  const double start = arm_energy(*engine);
  for (int tick = 0; tick < 60; ++tick) {
    run_ticks(*engine, 1);
    CHECK(arm_energy(*engine) < 1.01 * start);
  }
}

TEST_CASE("a kinematic body throws a rod as one body", "[engine][joints][arms]") {
  const Precision precision = GENERATE(Precision::f32, Precision::f64);
  const double restitution = GENERATE(0.0, 0.5);
  CAPTURE(precision, restitution);
  constexpr int count = 3;
  constexpr double speed = 3, x = 0.6;
  Scene scene = welded_rod(precision, count, 0, x, restitution);
  scene.bodies.back().type = BodyType::kinematic_body;
  scene.bodies.back().position.y = 0.25;
  scene.bodies.back().velocity = {0, -speed};
  choose_joints(scene, JointChoice::automatic);
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 2);
  const double inertia = count * (count * count + 0.04) / 12;
  const double impulse = (1 + restitution) * speed / (1.0 / count + x * x / inertia);
  double momentum = 0;
  for (const BodyReport& body : engine->bodies()) momentum += body.mass * body.velocity.y;
  CHECK_THAT(momentum, Catch::Matchers::WithinAbs(-impulse, 0.03 * impulse));
}

TEST_CASE("arms get no energy from what they hit", "[engine][joints][arms]") {
  const JointChoice joints =
      GENERATE(JointChoice::direct, JointChoice::direct_64, JointChoice::automatic, JointChoice::iterative);
  const Precision precision = GENERATE(Precision::f32, Precision::f64);
  int rise_count = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    CAPTURE(static_cast<int>(joints), precision, seed);
    Scene scene = empty_scene(precision);
    scene.gravity = {0, 0};
    const auto count = static_cast<int>(2 + random.below(7));
    const bool is_free = random.below(2) == 0;
    const double turn = random.real(0.5, 4);
    const double half = std::exp(random.real(-1, 0.5)) / 2;
    Body hub = peg({0, 0});
    hub.shapes[0].filter.mask = 0;
    scene.bodies.push_back(hub);
    for (int i = 0; i < count; ++i) {
      const double x = (2 * i + 1) * half;
      scene.bodies.push_back(arm_box(half, {x, 0}, std::exp(random.real(-1.5, 1.5))));
      scene.bodies.back().velocity = {0, turn * x};
      scene.bodies.back().angular_velocity = turn;
      if (i == 0 && is_free) continue;
      const bool is_hinge = i == 0 || random.below(3) == 0;
      Joint joint = joint_of(is_hinge ? JointKind::revolute : JointKind::weld, static_cast<std::uint32_t>(i),
                             static_cast<std::uint32_t>(i + 1));
      joint.anchor_a = i == 0 ? Point{0, 0} : Point{half, 0};
      joint.anchor_b = {-half, 0};
      scene.joints.push_back(joint);
    }
    const double far = random.real(0.3, count) * 2 * half;
    scene.bodies.push_back(
        body_of(disc_shape(0.2 * half), {far, random.real(0.8, 1.6) * half + 0.2 * far}, BodyType::static_body));
    set_surfaces(scene, random.real(0, 0.6), random.below(2) == 0 ? 0 : 0.5);
    choose_joints(scene, joints);
    const auto engine = make_engine_or_fail(scene);
    const double start = arm_energy(*engine);
    double least = start;
    double most = 0;
    double rise = 0;
    for (int tick = 0; tick < 60; ++tick) {
      run_ticks(*engine, 1);
      least = std::min(least, arm_energy(*engine));
      most = std::max(most, arm_energy(*engine));
      rise = std::max(rise, arm_energy(*engine) - least);
    }
    CHECK(most < 1.005 * start);
    if (rise > 0.05 * start) ++rise_count;
    if (joints != JointChoice::iterative) CHECK(rise < (joints == JointChoice::automatic ? 0.01 : 0.05) * start);
  }
  CHECK(rise_count <= 1);  // iterative joints give, and give back what they took in an impact
}
