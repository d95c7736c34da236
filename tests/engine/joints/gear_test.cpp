// Gears against closed forms: pairs, trains and racks, free frames, many turns; removal, islands, refused scenes.
// SPDX-License-Identifier: MIT
//
// c_a + r c_b = constant. Forces l on c_a and r l on c_b hold it. Under a torque T on the first of two pinned discs,
// I_a w_a' = T + l, I_b w_b' = r l and w_a + r w_b = 0 give w_a' = T / (I_a + I_b / r^2).
#include <cmath>
#include <tuple>

#include "base/state/state_view.h"
#include "engine/math/trig.h"
#include "engine/scene/scene_binary.h"
#include "engine/scene/scene_json.h"
#include "tests/support/engine_runs.h"
#include "tests/support/joints.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::BodyReport;
using engine::Force;
using engine::ForceKind;
using engine::IntegratorKind;
using engine::JointSolverKind;

namespace {

Joint gear_of(std::uint32_t joint_a, std::uint32_t joint_b, double ratio) {
  Joint gear;
  gear.kind = JointKind::gear;
  gear.joint_a = joint_a;
  gear.joint_b = joint_b;
  gear.ratio = ratio;
  return gear;
}

Force torque_on(std::uint32_t body, double torque) {
  Force force;
  force.kind = ForceKind::constant;
  force.body = body;
  force.torque = torque;
  return force;
}

/// A row of pegs with discs of these inertias, which touch nothing. Body 2 i + 1 is disc i, joint i its pin.
Scene pinned_discs(const std::vector<double>& inertias, Precision precision = Precision::f64) {
  Scene scene = empty_scene(precision);
  scene.gravity = {0, 0};
  for (std::size_t i = 0; i < inertias.size(); ++i) {
    const Point place{2.0 * static_cast<double>(i), 0};
    scene.bodies.push_back(peg(place));
    scene.bodies.push_back(bob(place, 1, inertias[i]));
    const auto body = static_cast<std::uint32_t>(2 * i);
    scene.joints.push_back(joint_of(JointKind::revolute, body, body + 1));
  }
  return scene;
}

/// A column of the first row of the table "gears".
double gear_coordinate(const engine::Engine& engine, std::size_t row, std::size_t column) {
  const StateView& view = engine.state();
  const auto table = view.schema->find_table("gears");
  REQUIRE(table.has_value());
  REQUIRE(row < view.tables[*table].row_count);
  const TableSchema& schema = view.schema->tables[*table];
  const Column& c = schema.columns[column];
  const std::uint8_t* at = view.tables[*table].data + row * schema.row_size + c.offset;
  if (c.type == ScalarType::f64) {
    double value;
    std::memcpy(&value, at, 8);
    return value;
  }
  float value;
  std::memcpy(&value, at, 4);
  return static_cast<double>(value);
}

std::size_t gear_count(const engine::Engine& engine) {
  const auto table = engine.state().schema->find_table("gears");
  return table ? engine.state().tables[*table].row_count : 0;
}

struct Momenta {
  double x = 0;
  double y = 0;
  double angular = 0;
  double energy = 0;
};

Momenta momenta_of(const engine::Engine& engine) {
  Momenta sum;
  for (const BodyReport& b : engine.bodies()) {
    sum.x += b.mass * b.velocity.x;
    sum.y += b.mass * b.velocity.y;
    sum.angular += b.inertia * b.angular_velocity + b.mass * (b.center.x * b.velocity.y - b.center.y * b.velocity.x);
    sum.energy += 0.5 * b.mass * (b.velocity.x * b.velocity.x + b.velocity.y * b.velocity.y) +
                  0.5 * b.inertia * b.angular_velocity * b.angular_velocity;
  }
  return sum;
}

/// Two discs on a free bar, at whose centre they do not lie, spinning against each other and with the bar.
Scene discs_on_a_free_bar(Precision precision, double ratio) {
  Scene scene = empty_scene(precision);
  scene.gravity = {0, 0};
  scene.bodies = {bob({0, 0}, 2, 1.5), bob({-1, 0.3}, 1, 0.4), bob({1.5, 0}, 0.5, 0.1)};
  scene.joints = {joint_of(JointKind::revolute, 0, 1), joint_of(JointKind::revolute, 0, 2), gear_of(0, 1, ratio)};
  scene.joints[0].anchor_a = {-1, 0.3};
  scene.joints[1].anchor_a = {1.5, 0};
  const double spin = 0.7;  // of the bar, rad/s
  for (Body& body : scene.bodies) {
    body.velocity = {1 - spin * body.position.y, -0.5 + spin * body.position.x};
    body.angular_velocity = spin;
  }
  scene.bodies[1].angular_velocity += 3;
  scene.bodies[2].angular_velocity -= 3 / ratio;
  return scene;
}

std::string gear_refusal(const std::function<void(Scene&)>& change) {
  Scene scene = pinned_discs({1, 1});
  scene.joints.push_back(gear_of(0, 1, 1));
  change(scene);
  const Status status = engine::check_scene(scene, "s");
  return status ? "" : status.error().message;
}

engine::Input input_to(engine::InputKind kind, std::uint32_t body) {
  engine::Input input;
  input.kind = kind;
  input.body = body;
  return input;
}

void step_with(engine::Engine& engine, const std::vector<engine::Input>& inputs) {
  Bytes bytes;
  engine::encode_inputs(inputs, bytes);
  const TickInput input{dt, bytes};
  REQUIRE(engine.accept(input).has_value());
  REQUIRE(engine.step(input, nullptr));
}

}  // namespace

TEST_CASE("a torque turns a pair of gears as their inertias and ratio say", "[engine][joints][gear][analytic]") {
  for (const auto& precision : engine::precisions)
    for (const auto& integrator : engine::integrators)
      for (const auto& [solver, joints] : {std::pair{SolverKind::tgs_soft, JointSolverKind::iterative},
                                           std::pair{SolverKind::tgs_soft, JointSolverKind::direct},
                                           std::pair{SolverKind::pgs, JointSolverKind::iterative}})
        for (const double ratio : {1.0, -2.0, 0.5}) {
          // pgs has no relax pass: under other schemes its velocities keep half a tick of the torque.
          if (solver == SolverKind::pgs && integrator.kind != IntegratorKind::semi_implicit_euler) continue;
          if (!integrator.carries_constraints) continue;
          CAPTURE(precision.name, integrator.name, static_cast<int>(solver), static_cast<int>(joints), ratio);
          Scene scene = pinned_discs({0.5, 2}, precision.kind);
          scene.settings.solver = solver;
          scene.settings.joints = joints;
          scene.settings.integrator = integrator.kind;
          if (solver == SolverKind::pgs) scene.settings.substeps = 1;
          scene.joints.push_back(gear_of(0, 1, ratio));
          scene.forces = {torque_on(1, 6)};
          const auto engine = make_engine_or_fail(scene);
          run_ticks(*engine, 120);
          const double acceleration = 6 / (0.5 + 2 / (ratio * ratio));
          const auto bodies = engine->bodies();
          // The thesis' schemes begin differently: a free body under a torque has the same share.
          const double substeps_ahead = integrator.kind == IntegratorKind::thesis_rk4      ? 1
                                        : integrator.kind == IntegratorKind::thesis_verlet ? -0.5
                                                                                           : 0;
          const double seconds = 2 * (1 + substeps_ahead / 480);
          CHECK(bodies[1].angular_velocity == Approx(seconds * acceleration).epsilon(1e-5));
          CHECK(bodies[3].angular_velocity == Approx(-seconds * acceleration / ratio).epsilon(1e-5));
          CHECK(gear_coordinate(*engine, 0, 0) + ratio * gear_coordinate(*engine, 0, 1) == Approx(0).margin(0.01));
          CHECK(bodies[1].center.x == Approx(0).margin(1e-6));
          // The forces of the last substep: l = -T (I_b / r^2) / (I_a + I_b / r^2), and r l.
          const double force = -acceleration * 2 / (ratio * ratio);
          CHECK(joint_value(*engine, 2, "linear_force", 0) == Approx(force).epsilon(0.01));
          CHECK(joint_value(*engine, 2, "linear_force", 1) == Approx(ratio * force).epsilon(0.01));
        }
}

TEST_CASE("gears stay in mesh over many turns, also at more than half a turn in a substep",
          "[engine][joints][gear][analytic]") {
  for (const auto& precision : engine::precisions)
    for (const auto& [speed, substeps] : {std::pair{20.0, 4}, {1500.0, 4}, {1000.0, 1}})
      for (const SolverKind solver : {SolverKind::tgs_soft, SolverKind::pgs}) {
        if (solver == SolverKind::pgs && substeps != 1) continue;
        CAPTURE(precision.name, speed, substeps, static_cast<int>(solver));
        Scene scene = pinned_discs({0.5, 2}, precision.kind);
        scene.settings.solver = solver;
        scene.settings.substeps = substeps;
        scene.joints.push_back(gear_of(0, 1, 2));
        scene.bodies[1].angular_velocity = speed;
        scene.bodies[3].angular_velocity = -speed / 2;
        const auto engine = make_engine_or_fail(scene);
        run_ticks(*engine, 600);
        const double rounding = precision.kind == Precision::f32 ? 1e-4 : 1e-9;
        CHECK(engine->bodies()[1].angular_velocity == Approx(speed).epsilon(rounding));
        CHECK(engine->bodies()[3].angular_velocity == Approx(-speed / 2).epsilon(rounding));
        CHECK(gear_coordinate(*engine, 0, 0) == Approx(10 * speed).epsilon(rounding));
        CHECK(gear_coordinate(*engine, 0, 1) == Approx(-5 * speed).epsilon(rounding));
      }
}

TEST_CASE("the teeth do not slip: an angle of the driven disc is that of the driving one, turns later",
          "[engine][joints][gear][analytic]") {
  // With the ratio 1/3, a lost turn of the second disc would be a third of a turn of the first.
  Scene scene = pinned_discs({1, 1}, Precision::f32);
  scene.joints.push_back(gear_of(0, 1, 1.0 / 3));
  scene.joints[0].motor = engine::JointMotor{1.7, 1e4};
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 3600);
  const auto bodies = engine->bodies();
  const double turned = gear_coordinate(*engine, 0, 0);
  CHECK(turned > 100);
  CHECK(std::remainder(bodies[1].angle - turned, 2 * engine::pi) == Approx(0).margin(1e-4));
  CHECK(std::remainder(bodies[3].angle + 3 * turned, 2 * engine::pi) == Approx(0).margin(1e-3));
}

TEST_CASE("a weight on a rack turns the pinion", "[engine][joints][gear][analytic]") {
  constexpr double g = 10;
  for (const auto& precision : engine::precisions)
    for (const auto& [solver, joints] : {std::pair{SolverKind::tgs_soft, JointSolverKind::iterative},
                                         std::pair{SolverKind::tgs_soft, JointSolverKind::direct},
                                         std::pair{SolverKind::pgs, JointSolverKind::iterative}})
      for (const bool automatic : {false, true}) {
        if (automatic && solver == SolverKind::pgs) continue;
        CAPTURE(precision.name, static_cast<int>(solver), static_cast<int>(joints), automatic);
        const double radius = 0.25, mass = 2, inertia = 0.5;
        Scene scene = pinned_discs({inertia}, precision.kind);
        scene.gravity = {0, -g};
        scene.settings.solver = solver;
        scene.settings.joints = joints;
        if (solver == SolverKind::pgs) scene.settings.substeps = 1;
        if (automatic) scene.settings.auto_substeps.emplace();
        scene.bodies.push_back(bob({radius, 0}, mass, 0.1));
        Joint slider = joint_of(JointKind::prismatic, 0, 2);
        slider.axis = {0, 1};
        slider.anchor_a = {radius, 0};
        scene.joints.push_back(slider);
        scene.joints.push_back(gear_of(1, 0, -radius));  // the rack moves as the pinion's rim does
        const auto engine = make_engine_or_fail(scene);
        run_ticks(*engine, 60);
        const double acceleration = -g * mass / (mass + inertia / (radius * radius));
        const auto bodies = engine->bodies();
        CHECK(bodies[2].velocity.y == Approx(acceleration).epsilon(5e-3));
        CHECK(bodies[1].angular_velocity == Approx(acceleration / radius).epsilon(5e-3));
        CHECK(bodies[2].center.x == Approx(radius).margin(1e-3));
        CHECK(gear_coordinate(*engine, 0, 0) == Approx(acceleration / 2).epsilon(0.02));
        CHECK(gear_coordinate(*engine, 0, 0) - radius * gear_coordinate(*engine, 0, 1) == Approx(0).margin(2e-3));
      }
}

TEST_CASE("a torque runs through a train of three gears", "[engine][joints][gear][analytic]") {
  for (const auto& precision : engine::precisions) {
    CAPTURE(precision.name);
    Scene scene = pinned_discs({0.5, 0.2, 1}, precision.kind);
    scene.joints.push_back(gear_of(0, 1, 2));
    scene.joints.push_back(gear_of(1, 2, 0.5));
    scene.forces = {torque_on(1, 4)};
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 120);
    // w_b = -w_a / 2, w_c = -w_b / 0.5 = w_a.
    const double acceleration = 4 / (0.5 + 0.2 / 4 + 1);
    const auto bodies = engine->bodies();
    CHECK(bodies[1].angular_velocity == Approx(2 * acceleration).epsilon(5e-3));
    CHECK(bodies[3].angular_velocity == Approx(-acceleration).epsilon(5e-3));
    CHECK(bodies[5].angular_velocity == Approx(2 * acceleration).epsilon(5e-3));
  }
}

TEST_CASE("a pendulum in mesh with a flywheel swings with the inertia of both", "[engine][joints][gear][analytic]") {
  // 1 kg, 1 m below its pin, against a flywheel: T = 2 pi sqrt((1 + I_a + I_b / r^2) / g) for small swings.
  const double ratio = 0.5, g = 10, amplitude = 0.05;
  const double period = 2 * engine::pi * std::sqrt((1 + 0.1 + 0.3 / (ratio * ratio)) / g);
  for (const auto& precision : engine::precisions)
    for (const auto& integrator : engine::integrators)
      for (const JointSolverKind joints : {JointSolverKind::iterative, JointSolverKind::direct}) {
        if (!integrator.carries_constraints) continue;
        CAPTURE(precision.name, integrator.name, static_cast<int>(joints));
        Scene scene = pinned_discs({0.1, 0.3}, precision.kind);
        scene.gravity = {0, -g};
        scene.settings.integrator = integrator.kind;
        scene.settings.joints = joints;
        scene.settings.substeps = 16;
        scene.bodies[1].position = {std::sin(amplitude), -std::cos(amplitude)};
        scene.bodies[1].angle = amplitude;
        scene.joints[0].anchor_b = {0, 1};
        scene.joints.push_back(gear_of(0, 1, ratio));
        const auto engine = make_engine_or_fail(scene);
        const auto ticks = static_cast<int>(std::lround(period / dt));
        run_ticks(*engine, ticks / 2);
        CHECK(engine->bodies()[1].angle == Approx(-amplitude).epsilon(0.01));
        CHECK(engine->bodies()[3].angle == Approx(2 * amplitude / ratio).epsilon(0.01));
        run_ticks(*engine, ticks - ticks / 2);
        CHECK(engine->bodies()[1].angle == Approx(amplitude).epsilon(0.01));
        CHECK(engine->bodies()[3].angle == Approx(0).margin(0.02 * amplitude));
      }
}

TEST_CASE("gears on a moving frame keep momentum, angular momentum and energy",
          "[engine][joints][gear][conservation]") {
  for (const auto& precision : engine::precisions)
    for (const JointSolverKind joints : {JointSolverKind::iterative, JointSolverKind::direct})
      for (const double ratio : {1.0, -1.0, 2.5}) {
        CAPTURE(precision.name, static_cast<int>(joints), ratio);
        Scene scene = discs_on_a_free_bar(precision.kind, ratio);
        scene.settings.joints = joints;
        const auto engine = make_engine_or_fail(scene);
        const Momenta before = momenta_of(*engine);
        run_ticks(*engine, 600);
        const Momenta after = momenta_of(*engine);
        const double rounding = precision.kind == Precision::f32 ? 1e-3 : 1e-9;
        CHECK(after.x == Approx(before.x).margin(rounding));
        CHECK(after.y == Approx(before.y).margin(rounding));
        CHECK(after.angular == Approx(before.angular).margin(rounding));
        CHECK(after.energy == Approx(before.energy).epsilon(0.02));
        const auto bodies = engine->bodies();
        const double spin = bodies[0].angular_velocity;
        CHECK((bodies[1].angular_velocity - spin) + ratio * (bodies[2].angular_velocity - spin) ==
              Approx(0).margin(0.01));
        // 30 rad of the first disc against the bar: the coordinates are still in mesh.
        CHECK(gear_coordinate(*engine, 0, 0) + ratio * gear_coordinate(*engine, 0, 1) == Approx(0).margin(0.01));
        CHECK(std::fabs(gear_coordinate(*engine, 0, 0)) > 10);
      }
}

TEST_CASE("a gear over four free bodies keeps momentum", "[engine][joints][gear][conservation]") {
  Scene scene = empty_scene();
  scene.gravity = {0, 0};
  scene.bodies = {bob({0, 0}, 1, 0.3), bob({1, 0}, 2, 0.2), bob({4, 1}, 3, 0.5), bob({4, 2}, 0.5, 0.1)};
  scene.joints = {joint_of(JointKind::revolute, 0, 1), joint_of(JointKind::prismatic, 2, 3), gear_of(0, 1, 0.8)};
  scene.joints[0].anchor_a = {1, 0};
  scene.joints[1].axis = {1, 3};
  scene.joints[1].anchor_b = {0.2, -0.1};
  scene.bodies[0].velocity = {1, -1};
  scene.bodies[1].angular_velocity = 4;
  scene.bodies[3].velocity = {0.5, 1.5};
  scene.bodies[2].angular_velocity = scene.bodies[3].angular_velocity = 0.5;
  const auto engine = make_engine_or_fail(scene);
  const Momenta before = momenta_of(*engine);
  run_ticks(*engine, 300);
  const Momenta after = momenta_of(*engine);
  CHECK(after.x == Approx(before.x).margin(1e-9));
  CHECK(after.y == Approx(before.y).margin(1e-9));
  CHECK(after.angular == Approx(before.angular).margin(1e-9));
  CHECK(after.energy < before.energy * (1 + 1e-6));
}

TEST_CASE("a gear whose parts cancel does nothing", "[engine][joints][gear][conservation]") {
  // Two sliders of the same two bodies, the other way round, along axes that differ by rounding alone.
  for (const auto& precision : engine::precisions) {
    CAPTURE(precision.name);
    Scene scene = empty_scene(precision.kind);
    scene.gravity = {0, 0};
    scene.bodies = {bob({0, 0}, 1, 0.3), bob({std::cos(0.3), std::sin(0.3)}, 2, 0.2)};
    scene.bodies[0].angle = 0.3;
    scene.bodies[1].angle = 1.1;
    Joint there = joint_of(JointKind::prismatic, 0, 1);
    const auto in_frame = [](double angle, Point d) -> Point {
      return {std::cos(angle) * d.x + std::sin(angle) * d.y, std::cos(angle) * d.y - std::sin(angle) * d.x};
    };
    there.anchor_a = in_frame(0.3, scene.bodies[1].position);
    there.axis = {1, 0};
    there.reference_angle = 0.8;
    Joint back = joint_of(JointKind::prismatic, 1, 0);
    back.anchor_a = in_frame(1.1, {-std::cos(0.3), -std::sin(0.3)});
    back.axis = {std::cos(0.8), -std::sin(0.8)};  // the same direction in the world
    back.reference_angle = -0.8;
    scene.joints = {there, back, gear_of(0, 1, 1)};
    scene.bodies[1].velocity = {std::cos(0.3), std::sin(0.3)};
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 120);
    const double rounding = precision.kind == Precision::f32 ? 1e-3 : 1e-9;
    CHECK(momenta_of(*engine).energy == Approx(1).margin(rounding));
    CHECK(joint_value(*engine, 2, "linear_force", 0) == 0);
  }
}

TEST_CASE("sliders that share a light body far from an anchor are in mesh", "[engine][joints][gear][analytic]") {
  // Joint 0 slides disc 1 along disc 0, joint 1 slides disc 0 along an axis of the world 90 m away.
  const auto far_sliders = [](Precision precision) {
    Scene scene = empty_scene(precision);
    scene.gravity = {0, 0};
    scene.settings.substeps = 64;
    scene.bodies = {bob({0, 0}, 0.01, 2e-5), bob({-0.125, 0}, 0.01, 2e-5), peg({-64, 64})};
    scene.joints = {joint_of(JointKind::prismatic, 1, 0), joint_of(JointKind::prismatic, 0, 2), gear_of(1, 0, 3)};
    scene.joints[0].anchor_a = {0.0625, 0};
    scene.joints[0].anchor_b = {-0.0625, 0};
    scene.joints[0].axis = {0, 1};
    scene.joints[1].anchor_a = {-64, 64};
    scene.joints[1].axis = {1, 0};
    return scene;
  };
  for (const auto& precision : engine::precisions) {
    CAPTURE(precision.name);
    {
      const double rounding = precision.kind == Precision::f32 ? 1e-4 : 1e-9;
      Scene scene = far_sliders(precision.kind);
      scene.bodies[0].velocity = {1, 0};
      scene.bodies[1].velocity = {1, -0.3};
      const auto engine = make_engine_or_fail(scene);
      run_ticks(*engine, 15);
      // The mesh asks for v_x = -3 v_y of disc 1. Masses of .02 kg along x and of .01 kg along y meet it with equal
      // impulses along (1, 3): v_x = 18.9 / 19 m/s.
      const auto bodies = engine->bodies();
      CHECK(bodies[1].velocity.x == Approx(18.9 / 19).epsilon(rounding));
      CHECK(bodies[1].velocity.y == Approx(-6.3 / 19).epsilon(rounding));
      CHECK(gear_coordinate(*engine, 0, 0) + 3 * gear_coordinate(*engine, 0, 1) == Approx(0).margin(rounding));
    }
    {
      // A third disc is welded to both: nothing can slide, against a motor.
      Scene scene = far_sliders(precision.kind);
      scene.joints[1].motor = engine::JointMotor{-1, 1e5};
      scene.bodies.push_back(bob({-0.0625, -0.1}, 0.01, 2e-5));
      for (const std::uint32_t other : {1u, 0u}) {
        const double side = other == 1 ? -1 : 1;
        Joint weld = joint_of(JointKind::weld, 3, other);
        weld.anchor_a = {side * 0.03125, 0.05};
        weld.anchor_b = {-side * 0.03125, -0.05};
        scene.joints.push_back(weld);
      }
      const auto engine = make_engine_or_fail(scene);
      run_ticks(*engine, 15);
      for (const BodyReport& body : engine->bodies()) CHECK(std::hypot(body.velocity.x, body.velocity.y) < 2);
    }
  }
}

TEST_CASE("a kinematic carrier turns a planet wheel on a fixed sun", "[engine][joints][gear][analytic]") {
  // Sun and planet have 2 : 1 teeth: seen from the carrier, w_planet - w = -2 (w_sun - w).
  Scene scene = empty_scene();
  scene.gravity = {0, 0};
  scene.bodies = {body_of(disc_shape(0.1), {0, 0}, BodyType::kinematic_body), bob({0, 0}, 1, 0.5),
                  bob({3, 0}, 0.5, 0.2), peg({0, 0})};
  scene.bodies[0].angular_velocity = 1.5;
  scene.joints = {joint_of(JointKind::revolute, 0, 1), joint_of(JointKind::revolute, 0, 2),
                  joint_of(JointKind::weld, 3, 1), gear_of(0, 1, 0.5)};
  scene.joints[1].anchor_a = {3, 0};
  scene.bodies[2].velocity = {0, 4.5};
  scene.bodies[2].angular_velocity = 4.5;
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 300);
  CHECK(engine->bodies()[1].angular_velocity == Approx(0).margin(0.01));
  CHECK(engine->bodies()[2].angular_velocity == Approx(4.5).epsilon(0.005));
}

TEST_CASE("a gear is removed with any of its bodies, and its other bodies run on", "[engine][joints][gear][analytic]") {
  for (std::uint32_t removed = 0; removed < 4; ++removed) {
    CAPTURE(removed);
    Scene scene = pinned_discs({1, 1, 1, 1});
    scene.joints.push_back(gear_of(0, 1, 1));
    scene.joints.push_back(gear_of(2, 3, 2));
    scene.inputs = {engine::InputKind::remove};
    scene.forces = {torque_on(1, 2), torque_on(5, 2)};
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 10);
    CHECK(gear_count(*engine) == 2);
    const double kept = gear_coordinate(*engine, 1, 0);
    step_with(*engine, {input_to(engine::InputKind::remove, removed)});
    REQUIRE(gear_count(*engine) == 1);
    CHECK(joint_count(*engine) == 4);
    CHECK(gear_coordinate(*engine, 0, 0) > kept);  // the other gear has kept its row
    CHECK(gear_coordinate(*engine, 0, 0) < 1.3 * kept);
    const auto names = engine->state().schema->find_table("gears");
    CHECK(engine->row_name(*names, 0) == "joint#5");
    run_ticks(*engine, 60);
    CHECK_FALSE(find_non_finite(engine->state()).has_value());
    const double speed = engine->bodies().back().angular_velocity;
    CHECK(speed == Approx(-0.5 * 2 / (1 + 0.25) * 71 * dt).epsilon(0.01));
    Bytes image = image_of(*engine);
    const auto again = make_engine_or_fail(scene);
    REQUIRE(again->load(image).has_value());
    run_ticks(*engine, 5);
    run_ticks(*again, 5);
    CHECK(root_hash(engine->state()) == root_hash(again->state()));
  }
}

TEST_CASE("an image with rows of gears that the scene has not is refused", "[engine][joints][gear][corruption]") {
  Scene two = pinned_discs({1, 1, 1});
  two.joints.push_back(gear_of(0, 1, 1));
  two.joints.push_back(gear_of(1, 2, 1));
  const auto engine = make_engine_or_fail(two);
  Bytes image = image_of(*engine);
  Scene one = two;
  one.joints.pop_back();
  const Status status = make_engine_or_fail(one)->load(image);
  CHECK_FALSE(status.has_value());
}

TEST_CASE("the bodies of a gear fall asleep together and wake together", "[engine][joints][gear][sleep]") {
  for (const std::uint32_t pushed : {0u, 1u, 2u, 3u}) {
    CAPTURE(pushed);
    Scene scene = empty_scene();
    scene.settings.sleep.emplace();
    scene.inputs = {engine::InputKind::impulse};
    // Two frames far apart stand on the ground, each with a disc. Only the gear connects them.
    scene.bodies = {unit_box({0, 0.5}), bob({0, 3}, 0.1, 0.01), unit_box({20, 0.5}), bob({20, 3}, 0.1, 0.01),
                    body_of(box_shape(40, 1), {0, -1}, BodyType::static_body)};
    scene.joints = {joint_of(JointKind::revolute, 0, 1), joint_of(JointKind::revolute, 2, 3), gear_of(0, 1, 1)};
    for (std::size_t i = 0; i < 2; ++i) {
      scene.joints[i].anchor_a = {0, 0.2};
      scene.joints[i].anchor_b = {0, -2.3};
      scene.joints[i].limits = engine::Range{0, 0};
    }
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 300);
    const auto asleep = engine->bodies();
    for (const BodyReport& body : asleep) CHECK(body.velocity == Point{0, 0});
    engine::Input push = input_to(engine::InputKind::impulse, pushed);
    push.values[1] = 1e-3;
    step_with(*engine, {push});
    const auto table = engine->state().schema->find_table("sleep");
    REQUIRE(table.has_value());
    const TableRows& rows = engine->state().tables[*table];
    const TableSchema& schema = engine->state().schema->tables[*table];
    for (std::size_t row = 0; row < 4; ++row) {
      std::uint32_t is_asleep = 1;
      std::memcpy(&is_asleep, rows.data + row * schema.row_size + schema.columns[1].offset, 4);
      CHECK(is_asleep == 0);
    }
  }
}

TEST_CASE("discs of a gear touch only where the gear says so", "[engine][joints][gear][analytic]") {
  for (const bool touch : {false, true}) {
    Scene scene = pinned_discs({1, 1});
    for (const std::size_t disc : {1u, 3u}) scene.bodies[disc].shapes[0] = disc_shape(1.1);
    for (const std::size_t at : {0u, 2u}) scene.bodies[at].shapes[0].filter.mask = 0;
    scene.joints.push_back(gear_of(0, 1, 1));
    scene.joints[2].collide_connected = touch;
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 2);
    CHECK(engine->contacts().empty() != touch);
  }
}

TEST_CASE("discs of a gear touch again when the gear has gone with a frame", "[engine][joints][gear][analytic]") {
  Scene scene = pinned_discs({1, 1});
  for (const std::size_t disc : {1u, 3u}) scene.bodies[disc].shapes[0] = disc_shape(1.1);
  for (const std::size_t at : {0u, 2u}) scene.bodies[at].shapes[0].filter.mask = 0;
  scene.joints.push_back(gear_of(0, 1, 1));
  scene.inputs = {engine::InputKind::remove};
  engine::EngineOptions options;
  options.check_caches = true;
  const auto engine = make_engine_or_fail(scene, options);
  run_ticks(*engine, 20);
  CHECK(engine->contacts().empty());
  step_with(*engine, {input_to(engine::InputKind::remove, 0)});
  run_ticks(*engine, 1);
  CHECK(engine->contacts().size() == 1);
}

TEST_CASE("threads, chunks, cold caches and images change no bit of gears",
          "[engine][joints][gear][threads][determinism]") {
  for (const auto& precision : engine::precisions) {
    // A net of 60 pinned discs, each in mesh with the next, on three free bars.
    std::vector<double> inertias;
    for (int i = 0; i < 60; ++i) inertias.push_back(0.1 + 0.01 * i);
    Scene scene = pinned_discs(inertias, precision.kind);
    scene.gravity = {0, -10};
    for (std::uint32_t i = 0; i + 1 < 60; ++i) scene.joints.push_back(gear_of(i, i + 1, i % 3 == 0 ? -1.5 : 1));
    scene.forces = {torque_on(1, 3)};
    const Session session{"gears", scene, {}, {}};
    const auto plain = tick_hashes(session, 60);
    for (const unsigned threads : {2u, 4u})
      for (const std::size_t chunk : {std::size_t{0}, std::size_t{1}, std::size_t{7}}) {
        engine::EngineOptions options;
        options.thread_count = threads;
        options.parallel.chunk_size_forced = chunk;
        CHECK(tick_hashes(session, 60, options) == plain);
      }
    engine::EngineOptions checked;
    checked.check_caches = true;
    CHECK(tick_hashes(session, 60, checked) == plain);
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 23);
    const auto restored = make_engine_or_fail(scene);
    REQUIRE(restored->load(image_of(*engine)).has_value());
    for (int tick = 23; tick < 60; ++tick) {
      run_ticks(*restored, 1);
      CHECK(root_hash(restored->state()) == plain[static_cast<std::size_t>(tick)]);
    }
  }
}

TEST_CASE("jointed bodies with a gear are solved by iteration, others beside them directly",
          "[engine][joints][gear][direct]") {
  Scene scene = pinned_discs({0.5, 2});
  scene.gravity = {0, -10};
  scene.joints.push_back(gear_of(0, 1, 2));
  scene.forces = {torque_on(1, 1)};
  Scene direct = scene;
  direct.settings.joints = JointSolverKind::direct;
  const auto geared = make_engine_or_fail(direct);
  run_ticks(*geared, 60);
  const auto iterated = make_engine_or_fail(scene);
  run_ticks(*iterated, 60);
  CHECK(root_hash(geared->state()) == root_hash(iterated->state()));
  // A chain of 100 times its mass sags by 2e-6 m and not by millimetres.
  const auto first = static_cast<std::uint32_t>(scene.bodies.size());
  direct.bodies.push_back(peg({10, 0}));
  for (int i = 0; i < 10; ++i) {
    direct.bodies.push_back(bob({10, -0.5 - i}, i == 9 ? 100 : 1));
    Joint pin =
        joint_of(JointKind::revolute, first + static_cast<std::uint32_t>(i), first + 1 + static_cast<std::uint32_t>(i));
    pin.anchor_a = i == 0 ? Point{0, 0} : Point{0, -0.5};
    pin.anchor_b = {0, 0.5};
    direct.joints.push_back(pin);
  }
  direct.forces[0].body = 1;
  const auto both = make_engine_or_fail(direct);
  run_ticks(*both, 60);
  CHECK(both->bodies().back().center.y == Approx(-9.5).margin(1e-5));
  direct.settings.joints = JointSolverKind::iterative;
  const auto sagging = make_engine_or_fail(direct);
  run_ticks(*sagging, 60);
  CHECK(sagging->bodies().back().center.y < -9.5 - 1e-3);
}

TEST_CASE("gears that mean nothing are refused by the name of the field", "[engine][joints][gear]") {
  using Catch::Matchers::Contains;
  CHECK(gear_refusal([](Scene&) {}) == "");
  for (const double ratio : {0.0, 1e-4, -1e-4, 1e4, -1e4, std::nan("")})
    CHECK_THAT(gear_refusal([ratio](Scene& s) { s.joints[2].ratio = ratio; }), Contains("s: joints[2].ratio: "));
  CHECK_THAT(gear_refusal([](Scene& s) { s.joints[2].joint_b = 2; }),
             Contains("s: joints[2].joint_b: no joint before this one has this index: found 2, expected 0..1"));
  CHECK_THAT(gear_refusal([](Scene& s) { std::swap(s.joints[0], s.joints[2]); }),
             Contains("s: joints[0].joint_a: no joint before this one has this index: found 0, expected none"));
  CHECK_THAT(gear_refusal([](Scene& s) { s.joints[1].kind = JointKind::weld; }),
             Contains("s: joints[2].joint_b: must be a revolute or prismatic joint: found a weld joint"));
  CHECK_THAT(gear_refusal([](Scene& s) { s.joints.push_back(gear_of(2, 1, 1)); }),
             Contains("s: joints[3].joint_a: must be a revolute or prismatic joint: found a gear joint"));
  CHECK_THAT(gear_refusal([](Scene& s) { s.joints[2].joint_b = 0; }), Contains("couples a joint with itself"));
  CHECK_THAT(gear_refusal([](Scene& s) { s.joints[1] = joint_of(JointKind::revolute, 2, 1); }),
             Contains("s: joints[2].joint_b: the two joints have the same body_b: found body 1 twice"));
  CHECK_THAT(gear_refusal([](Scene& s) { s.joints[2].body_b = 1; }),
             Contains("s: joints[2].body_b: a gear joint has none"));
  CHECK_THAT(gear_refusal([](Scene& s) { s.joints[0].joint_a = 1; }),
             Contains("s: joints[0].joint_a: a revolute joint has none"));
}

TEST_CASE("a scene with a gear has an encoding of its own, and no other scene",
          "[engine][joints][gear][scene_binary]") {
  Scene scene = pinned_discs({1, 1});
  const auto version = [](const Scene& of) {
    const Bytes bytes = engine::encode_scene(of);
    return bytes[0] + 256 * bytes[1];
  };
  CHECK(version(scene) == 2);
  scene.joints.push_back(gear_of(0, 1, -1.25));
  CHECK(version(scene) == 5);
  const auto back = engine::decode_scene(engine::encode_scene(scene));
  REQUIRE(back.has_value());
  CHECK(*back == scene);
  const auto read = engine::parse_scene(engine::print_scene(scene), "f");
  REQUIRE(read.has_value());
  CHECK(*read == scene);
}

TEST_CASE("joints that go take their gears along, and the others are numbered anew",
          "[engine][joints][gear][analytic]") {
  Scene scene = pinned_discs({1, 1, 1});
  scene.joints.push_back(gear_of(0, 1, 1));
  scene.joints.push_back(gear_of(1, 2, 3));
  std::vector<std::uint8_t> is_kept{0, 1, 1, 1, 1};
  CHECK(engine::keep_joints(scene, is_kept) == std::vector<std::uint32_t>{engine::no_joint, 0, 1, engine::no_joint, 2});
  REQUIRE(scene.joints.size() == 3);
  CHECK(scene.joints[2] == gear_of(0, 1, 3));
  CHECK(engine::check_scene(scene, "s").has_value());
}
