// Force elements against closed forms, with every integrator if the form does not depend on the integrator.
// SPDX-License-Identifier: MIT
#include <cmath>
#include <memory>
#include <string>

#include "engine/scene/input.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/scenes.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::BodyReport;
using engine::Force;
using engine::ForceKind;
using engine::InputKind;
using engine::IntegratorInfo;
using engine::IntegratorKind;

namespace {

Force force_of(ForceKind kind) {
  Force force;
  force.kind = kind;
  return force;
}

Body disc_of_1_kg(Point position) {
  Body body = body_of(disc_shape(0.5), position);
  body.shapes[0].filter.mask = 0;  // no collisions
  body.mass = engine::ExplicitMass{1, {}, {}};
  return body;
}

Scene weightless(Precision precision, Body body) {
  Scene scene = flight_scene(precision, std::move(body));
  scene.gravity = {0, 0};
  return scene;
}

std::unique_ptr<engine::Engine> run(const Scene& scene, int tick_count) {
  auto engine = make_engine_or_fail(scene);
  for (int i = 0; i < tick_count; ++i) REQUIRE(engine->step({scene.settings.dt, {}}, nullptr));
  return engine;
}

std::uint32_t unconverged_of(const engine::Engine& engine) {
  const StateView& state = engine.state();
  const auto table = state.schema->find_table("integrator");
  REQUIRE(table.has_value());
  std::uint32_t count = 0;
  for (int i = 0; i < 4; ++i) count |= static_cast<std::uint32_t>(state.tables[*table].data[i]) << (8 * i);
  return count;
}

/// Two discs of 1 kg and 3 kg at rest, 2 m apart. A spring of 1 m joins anchors off their centres.
Scene sprung_pair(double stiffness, double damping) {
  Scene scene = weightless(Precision::f64, disc_of_1_kg({0, 0}));
  scene.bodies.push_back(disc_of_1_kg({2, 0}));
  scene.bodies[1].mass->mass = 3;
  Force spring = force_of(ForceKind::spring);
  spring.body = 0;
  spring.other = 1;
  spring.anchor = {0, 0.3};
  spring.point = {0, -0.2};
  spring.rest_length = 1;
  spring.stiffness = stiffness;
  spring.damping = damping;
  scene.forces.push_back(spring);
  return scene;
}

}  // namespace

TEST_CASE("a drag takes a body to the speed of the sum of the winds", "[engine][forces][analytic]") {
  for (const ForceKind drag : {ForceKind::linear_drag, ForceKind::quadratic_drag}) {
    for (const IntegratorInfo& info : engine::integrators) {
      CAPTURE(drag, info.name);
      Scene scene = weightless(Precision::f64, disc_of_1_kg({0, 0}));
      scene.settings.integrator = info.kind;
      scene.forces = {force_of(drag), force_of(ForceKind::wind), force_of(ForceKind::wind)};
      scene.forces[0].coefficient = 2;
      scene.forces[1].vector = {3, 1};
      scene.forces[2].vector = {1, -4};
      // Linear: e^(-2 t); quadratic: |u| = 5 / (1 + 10 t), 5e-3 after 100 s.
      const BodyReport body = run(scene, 6000)->bodies()[0];
      CHECK(std::fabs(body.velocity.x - 4) < 0.005);
      CHECK(std::fabs(body.velocity.y + 3) < 0.005);
    }
  }
}

TEST_CASE("a drag of any strength slows a body without turning it round", "[engine][forces][stiff]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    for (const ForceKind drag : {ForceKind::linear_drag, ForceKind::quadratic_drag}) {
      for (const IntegratorKind kind :
           {IntegratorKind::semi_implicit_euler, IntegratorKind::velocity_verlet, IntegratorKind::position_verlet}) {
        for (const double coefficient : {1e-3, 1.0, 1e3, 1e6, 1e9}) {
          CAPTURE(precision, drag, kind, coefficient);
          Scene scene = weightless(precision, disc_of_1_kg({0, 0}));
          scene.settings.integrator = kind;
          scene.bodies[0].velocity = {10, 0};
          scene.bodies[0].angular_velocity = 5;
          scene.forces = {force_of(drag)};
          scene.forces[0].coefficient = coefficient;
          scene.forces[0].angular_coefficient = coefficient;
          const auto engine = make_engine_or_fail(scene);
          double speed = 10, spin = 5;
          for (int tick = 0; tick < 60; ++tick) {
            REQUIRE(engine->step({scene.settings.dt, {}}, nullptr));
            const BodyReport body = engine->bodies()[0];
            REQUIRE(body.velocity.x >= 0);
            REQUIRE(body.velocity.x <= speed);
            REQUIRE(body.angular_velocity >= 0);
            REQUIRE(body.angular_velocity <= spin);
            speed = body.velocity.x;
            spin = body.angular_velocity;
          }
        }
      }
    }
  }
}

TEST_CASE("a quadratic drag slows a body of any speed under any integrator", "[engine][forces][stiff]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    for (const IntegratorInfo& info : engine::integrators) {
      for (const double coefficient : {1e-3, 1.0, 1e3, 1e6}) {
        CAPTURE(precision, info.name, coefficient);
        Scene scene = weightless(precision, disc_of_1_kg({0, 0}));
        scene.settings.integrator = info.kind;
        scene.bodies[0].velocity = {1e5, 0};
        scene.bodies[0].angular_velocity = 1e5;
        scene.forces = {force_of(ForceKind::quadratic_drag)};
        scene.forces[0].coefficient = coefficient;
        scene.forces[0].angular_coefficient = coefficient;
        const auto engine = make_engine_or_fail(scene);
        for (int tick = 0; tick < 60; ++tick) {
          REQUIRE(engine->step({scene.settings.dt, {}}, nullptr));
          const BodyReport body = engine->bodies()[0];
          REQUIRE(std::fabs(body.velocity.x) < 1e5);
          REQUIRE(std::fabs(body.angular_velocity) < 1e5);
        }
        // The midpoint rule reverses a stiff motion and keeps most of its speed.
        if (info.kind != IntegratorKind::implicit_midpoint) CHECK(std::fabs(engine->bodies()[0].velocity.x) < 2e4);
      }
    }
  }
}

TEST_CASE("quadratic drag alone is exact: v = v0 / (1 + c v0 t / m)", "[engine][forces][analytic]") {
  for (const IntegratorKind kind : {IntegratorKind::semi_implicit_euler, IntegratorKind::explicit_euler,
                                    IntegratorKind::velocity_verlet, IntegratorKind::position_verlet}) {
    Scene scene = weightless(Precision::f64, disc_of_1_kg({0, 0}));
    scene.settings.integrator = kind;
    scene.bodies[0].velocity = {6, 8};
    scene.forces = {force_of(ForceKind::quadratic_drag)};
    scene.forces[0].coefficient = 0.3;
    const BodyReport body = run(scene, 120)->bodies()[0];
    CHECK(body.velocity.x == Approx(6 / (1 + 0.3 * 10 * 2)).epsilon(1e-12));
    CHECK(body.velocity.y == Approx(8 / (1 + 0.3 * 10 * 2)).epsilon(1e-12));
  }
}

TEST_CASE("constant forces and torques accelerate by F / m and torque / inertia", "[engine][forces][analytic]") {
  for (const IntegratorInfo& info : engine::integrators) {
    if (info.kind == IntegratorKind::thesis_verlet || info.kind == IntegratorKind::thesis_rk4) continue;
    CAPTURE(info.name);
    Scene scene = weightless(Precision::f64, disc_of_1_kg({0, 0}));
    scene.settings.integrator = info.kind;
    scene.bodies[0].mass->inertia = 0.5;
    scene.forces = {force_of(ForceKind::constant)};
    scene.forces[0].vector = {2, -1};
    scene.forces[0].torque = 0.25;
    const BodyReport body = run(scene, 60)->bodies()[0];
    CHECK(body.velocity.x == Approx(2).epsilon(1e-12));
    CHECK(body.velocity.y == Approx(-1).epsilon(1e-12));
    CHECK(body.angular_velocity == Approx(0.5).epsilon(1e-12));
  }
}

TEST_CASE("springs keep momentum and angular momentum", "[engine][forces][conservation]") {
  for (const IntegratorInfo& info : engine::integrators) {
    CAPTURE(info.name);
    Scene scene = sprung_pair(40, 0.5);
    scene.settings.integrator = info.kind;
    scene.bodies[0].velocity = {0, 3};
    scene.bodies[1].velocity = {0, -1};
    const auto engine = run(scene, 120);
    double x = 0, y = 0;
    for (const BodyReport& body : engine->bodies()) {
      x += body.mass * body.velocity.x;
      y += body.mass * body.velocity.y;
    }
    CHECK(std::fabs(x) < 1e-11);
    CHECK(std::fabs(y) < 1e-11);
    CHECK(engine->bodies()[0].angular_velocity != 0);
  }
}

TEST_CASE("implicit_midpoint keeps angular momentum of a sprung pair exactly", "[engine][forces][conservation]") {
  Scene scene = sprung_pair(40, 2);
  scene.settings.integrator = IntegratorKind::implicit_midpoint;
  scene.bodies[0].velocity = {0, 3};
  scene.bodies[1].velocity = {0, -1};
  const auto momentum = [](const engine::Engine& engine) {
    double sum = 0;
    for (const BodyReport& body : engine.bodies())
      sum += body.inertia * body.angular_velocity +
             body.mass * (body.center.x * body.velocity.y - body.center.y * body.velocity.x);
    return sum;
  };
  // The scheme conserves quadratic invariants up to the tolerance of its equations, about 1e-14 m in each of 120 steps.
  CHECK(std::fabs(momentum(*run(scene, 120)) - momentum(*run(scene, 0))) < 1e-9);
}

TEST_CASE("a damper of any strength stops the relative motion along its line and nothing more",
          "[engine][forces][stiff]") {
  for (const IntegratorKind kind :
       {IntegratorKind::semi_implicit_euler, IntegratorKind::velocity_verlet, IntegratorKind::position_verlet}) {
    for (const double damping : {1e3, 1e6, 1e9}) {
      CAPTURE(kind, damping);
      Scene scene = sprung_pair(0, damping);
      scene.settings.integrator = kind;
      scene.forces[0].anchor = scene.forces[0].point = {0, 0};
      scene.bodies[0].velocity = {4, 0};
      const auto engine = run(scene, 600);
      for (const BodyReport& body : engine->bodies()) CHECK(body.velocity.x == Approx(1).margin(1e-3));
    }
  }
}

TEST_CASE("implicit_midpoint keeps stiff spring chains bounded and counts no unsolved substep",
          "[engine][forces][stiff]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    for (const double stiffness : {1e3, 1e6, 1e9}) {
      CAPTURE(precision, stiffness);
      Scene scene = weightless(precision, disc_of_1_kg({0, 0}));
      scene.gravity = {0, -10};
      scene.settings.integrator = IntegratorKind::implicit_midpoint;
      for (int i = 0; i < 8; ++i) {
        if (i > 0) scene.bodies.push_back(disc_of_1_kg({1.0 * i, 0}));
        Force spring = force_of(ForceKind::spring);
        spring.body = static_cast<std::uint32_t>(i);
        if (i > 0) spring.other = static_cast<std::uint32_t>(i - 1);
        spring.point = i > 0 ? Point{} : Point{-1, 0};
        spring.stiffness = i % 2 == 0 ? 1e3 : stiffness;
        spring.damping = 1;
        spring.rest_length = 1;
        scene.forces.push_back(spring);
      }
      const auto engine = run(scene, 600);
      for (const BodyReport& body : engine->bodies()) {
        // Eight metres of chain, plus the extension of its soft springs.
        CHECK(std::fabs(body.center.x) < 15);
        CHECK(std::fabs(body.center.y) < 15);
      }
      // With stiffer springs, violent compression leaves a few steps in a thousand unsolved. The engine counts them.
      CHECK(unconverged_of(*engine) <= (stiffness > 1e6 ? 24 : 0));
    }
  }
}

TEST_CASE("implicit_midpoint counts substeps whose equations it could not solve", "[engine][forces][stiff]") {
  // The body falls into a singularity: within a step of the centre, the equations may have no solution.
  Scene scene = weightless(Precision::f64, disc_of_1_kg({0.01, 0.003}));
  scene.settings.integrator = IntegratorKind::implicit_midpoint;
  scene.forces.push_back(force_of(ForceKind::central));
  scene.forces[0].coefficient = 1e3;
  scene.forces[0].exponent = -3;
  CHECK(unconverged_of(*run(scene, 60)) > 0);
}

TEST_CASE("elements of removed bodies vanish, and every integrator restores at any tick", "[engine][forces][restore]") {
  for (const IntegratorInfo& info : engine::integrators) {
    CAPTURE(info.name);
    Scene scene = sprung_pair(40, 0.5);
    scene.settings.integrator = info.kind;
    scene.bodies.push_back(disc_of_1_kg({5, 5}));
    scene.forces.push_back(force_of(ForceKind::central));
    scene.forces[1].coefficient = 2;
    scene.forces[1].exponent = 1;
    scene.forces.push_back(force_of(ForceKind::quadratic_drag));
    scene.forces[2].coefficient = 0.1;
    scene.prototypes = {disc_of_1_kg({0, 0})};
    scene.prototypes[0].name = "disc";
    scene.inputs = {InputKind::spawn, InputKind::remove};
    const auto input_of_tick = [](int tick) {
      engine::Input input;
      Bytes bytes;
      if (tick == 10) input.kind = InputKind::spawn, input.values[0] = 3;
      if (tick == 20) input.kind = InputKind::remove, input.body = 0;
      if (tick == 10 || tick == 20) engine::encode_inputs({input}, bytes);
      return bytes;
    };
    const auto whole = make_engine_or_fail(scene);
    for (int tick = 0; tick < 60; ++tick) {
      const auto restored = make_engine_or_fail(scene);
      const Status loaded = restored->load(image_of(*whole));
      INFO((loaded ? "" : loaded.error().message));
      REQUIRE(loaded.has_value());
      const Bytes bytes = input_of_tick(tick);
      REQUIRE(whole->step({scene.settings.dt, bytes}, nullptr));
      REQUIRE(restored->step({scene.settings.dt, bytes}, nullptr));
      REQUIRE(image_of(*whole) == image_of(*restored));
    }
    CHECK(whole->bodies().size() == 3);
  }
}

TEST_CASE("force elements that mean nothing are refused with their place", "[engine][forces][scene]") {
  const auto refusal = [](const Force& force) {
    Scene scene = flight_scene(Precision::f64, disc_of_1_kg({0, 0}));
    scene.bodies.push_back(disc_of_1_kg({0, 0}));
    scene.bodies[1].type = BodyType::static_body;
    scene.bodies[1].mass.reset();
    scene.forces = {force};
    const Status status = engine::check_scene(scene, "s");
    return status ? std::string() : status.error().message;
  };
  Force spring = force_of(ForceKind::spring);
  CHECK(refusal(spring).find("s: forces[0].body: missing") == 0);
  spring.body = 7;
  CHECK(refusal(spring).find("s: forces[0].body: no body has this index") == 0);
  spring.body = 0;
  CHECK(refusal(spring).empty());
  spring.other = 0;
  CHECK(refusal(spring).find("s: forces[0].other: joins a body with itself") == 0);
  Force constant = force_of(ForceKind::constant);
  constant.body = 1;
  CHECK(refusal(constant).find("s: forces[0].body: must be dynamic") == 0);
  Force central = force_of(ForceKind::central);
  central.exponent = -1.5;
  CHECK(refusal(central).find("s: forces[0].exponent: must be whole") == 0);
  Force drag = force_of(ForceKind::linear_drag);
  drag.coefficient = -1;
  CHECK(refusal(drag).find("s: forces[0].coefficient: must be >= 0") == 0);
  drag.coefficient = NAN;
  CHECK(refusal(drag).find("s: forces[0].coefficient: must be finite") == 0);
}

std::size_t asleep_count(const engine::Engine& engine) {
  const StateView& state = engine.state();
  std::size_t count = 0;
  for (std::size_t t = 0; t < state.tables.size(); ++t) {
    const TableSchema& table = state.schema->tables[t];
    if (table.name != "sleep") continue;
    for (const Column& column : table.columns)
      for (std::size_t row = 0; column.name == "asleep" && row < state.tables[t].row_count; ++row)
        count += state.tables[t].data[row * table.row_size + column.offset] != 0 ? 1 : 0;
  }
  return count;
}

TEST_CASE("a body asleep on a spring wakes when the kinematic body at its other end moves", "[engine][forces][sleep]") {
  Scene scene = empty_scene();
  scene.gravity = {0, 0};
  scene.settings.sleep.emplace();
  scene.inputs = {InputKind::set_velocity};
  scene.bodies = {disc_of_1_kg({0, 0}), disc_of_1_kg({0, 2})};
  scene.bodies[1].type = BodyType::kinematic_body;
  scene.bodies[1].mass.reset();
  Force spring = force_of(ForceKind::spring);
  spring.body = 0;
  spring.other = 1;
  spring.stiffness = 100;
  spring.rest_length = 2;
  scene.forces = {spring};
  const auto engine = make_engine_or_fail(scene);
  const TickInput nothing{scene.settings.dt, {}};
  for (int tick = 0; tick < 120; ++tick) REQUIRE(engine->step(nothing, nullptr));
  CHECK(engine->bodies()[0].center.y == 0);
  CHECK(asleep_count(*engine) == 1);
  engine::Input up;
  up.kind = InputKind::set_velocity;
  up.body = 1;
  up.values[1] = 1;
  Bytes bytes;
  engine::encode_inputs({up}, bytes);
  REQUIRE(engine->step({scene.settings.dt, bytes}, nullptr));
  CHECK(asleep_count(*engine) == 0);
  for (int tick = 0; tick < 60; ++tick) REQUIRE(engine->step(nothing, nullptr));
  CHECK(engine->bodies()[0].center.y > 0.5);  // it follows the other body, which is 1 m higher
}

TEST_CASE("a body asleep on a spring falls when the body at its other end is removed", "[engine][forces][sleep]") {
  for (const BodyType type : {BodyType::static_body, BodyType::kinematic_body, BodyType::dynamic_body}) {
    CAPTURE(type);
    Scene scene = empty_scene();
    scene.settings.sleep.emplace();
    scene.inputs = {InputKind::remove};
    scene.bodies = {disc_of_1_kg({0, 0}), disc_of_1_kg({0, 4}), disc_of_1_kg({9, 0})};
    scene.bodies[0].linear_damping = 3;
    scene.bodies[1].type = type;
    if (type != BodyType::dynamic_body) scene.bodies[1].mass.reset();
    scene.bodies[1].linear_damping = 3;
    Force spring = force_of(ForceKind::spring);
    spring.body = 0;
    spring.other = 1;
    spring.stiffness = 100;
    spring.rest_length = 3.9;
    scene.forces = {spring};
    spring.body = 1;
    spring.other.reset();
    spring.point = {0, 6};
    spring.stiffness = 200;
    spring.rest_length = 1.9;
    if (type == BodyType::dynamic_body) scene.forces.push_back(spring);
    scene.bodies.back().gravity_scale = 0;  // it sleeps on
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 600);
    const std::size_t all = type == BodyType::dynamic_body ? 3 : 2;
    CHECK(asleep_count(*engine) == all);
    engine::Input remove;
    remove.kind = InputKind::remove;
    remove.body = 1;
    Bytes bytes;
    engine::encode_inputs({remove}, bytes);
    REQUIRE(engine->step({scene.settings.dt, bytes}, nullptr));
    CHECK(asleep_count(*engine) == 1);
    run_ticks(*engine, 59);
    CHECK(engine->bodies()[0].center.y < -2);  // after 1 s with damping
  }
}

TEST_CASE("bodies that are being pushed apart do not sleep", "[engine][sleep]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    Scene scene = empty_scene(precision);
    scene.gravity = {0, 0};
    scene.settings.sleep.emplace();
    scene.bodies = {body_of(disc_shape(10), {0, 0}), body_of(disc_shape(10), {12, 0}),  // 8 m inside each other
                    body_of(box_shape(5, 5), {100, 0}), body_of(box_shape(5, 5), {100, 6})};
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 60);
    CHECK(asleep_count(*engine) == 0);
    run_ticks(*engine, 1140);
    CHECK(engine->bodies()[1].center.x - engine->bodies()[0].center.x > 19.99);
    CHECK(engine->bodies()[3].center.y - engine->bodies()[2].center.y > 9.99);
    CHECK(asleep_count(*engine) == 2);  // the boxes drift apart
  }
}

TEST_CASE("what an immovable new body overlaps wakes and is pushed out", "[engine][sleep]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const BodyType type : {BodyType::static_body, BodyType::kinematic_body})
      for (const double after_s : {0.0, 0.5}) {
        CAPTURE(precision, type, after_s);
        Scene scene = empty_scene(precision);
        scene.settings.sleep.emplace();
        scene.settings.sleep->after_s = after_s;
        scene.bodies = {ground(), unit_box({0, 0.5}), unit_box({9, 0.5})};
        scene.inputs = {engine::InputKind::spawn};
        scene.prototypes = {body_of(disc_shape(0.5), {0, 0}, type)};
        scene.prototypes[0].name = "disc";
        const auto engine = make_engine_or_fail(scene);
        const auto again = make_engine_or_fail(scene);
        run_ticks(*engine, 120);
        CHECK(asleep_count(*engine) == 2);
        REQUIRE(again->load(image_of(*engine)));
        engine::Input spawn;
        spawn.kind = engine::InputKind::spawn;
        spawn.values = {0.75, 0.5};
        Bytes bytes;
        engine::encode_inputs({spawn}, bytes);
        for (engine::Engine* each : {engine.get(), again.get()})
          REQUIRE(each->step({scene.settings.dt, bytes}, nullptr));
        CHECK(asleep_count(*engine) == 1);  // the far box sleeps on
        const auto after_spawn = make_engine_or_fail(scene);
        REQUIRE(after_spawn->load(image_of(*engine)));
        for (engine::Engine* each : {engine.get(), again.get(), after_spawn.get()}) run_ticks(*each, 240);
        CHECK(engine->bodies()[3].center.x - engine->bodies()[1].center.x > 0.98);
        CHECK(asleep_count(*engine) == 2);
        CHECK(root_hash(again->state()) == root_hash(engine->state()));
        CHECK(root_hash(after_spawn->state()) == root_hash(engine->state()));
      }
}

TEST_CASE("a fast kinematic body hits a body that sleeps", "[engine][sleep]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    CAPTURE(precision);
    Scene scene = empty_scene(precision);
    scene.settings.sleep.emplace();
    scene.bodies = {ground(), body_of(disc_shape(0.5), {0, 0.5}),
                    body_of(disc_shape(0.5), {2, 0.5}, BodyType::kinematic_body)};
    scene.inputs = {engine::InputKind::set_velocity};
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 120);
    CHECK(asleep_count(*engine) == 1);
    engine::Input input;
    input.kind = engine::InputKind::set_velocity;
    input.body = 2;
    input.values = {-150};  // past the sleeping disc in one tick
    Bytes bytes;
    engine::encode_inputs({input}, bytes);
    REQUIRE(engine->step({scene.settings.dt, bytes}, nullptr));
    CHECK(asleep_count(*engine) == 0);
    CHECK(engine->bodies()[2].center.x - engine->bodies()[1].center.x > 0.98);
  }
}

TEST_CASE("a kinematic body that an input stops inside of a sleeping one pushes it out", "[engine][sleep]") {
  // It moves in for one tick, in which nothing touches yet, and does not move in the next one.
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const double deep : {0.01, 0.04, 0.07}) {
      CAPTURE(precision, deep);
      Scene scene = empty_scene(precision);
      scene.settings.sleep.emplace();
      scene.bodies = {ground(), unit_box({0, 0.5}), unit_box({9, 0.5}),
                      body_of(disc_shape(0.5), {1.1 - deep, 0.5}, BodyType::kinematic_body)};
      scene.inputs = {engine::InputKind::set_velocity};
      const auto engine = make_engine_or_fail(scene);
      run_ticks(*engine, 120);
      const auto set_speed = [&](double speed) {
        engine::Input input;
        input.kind = engine::InputKind::set_velocity;
        input.body = 3;
        input.values = {speed};
        Bytes bytes;
        engine::encode_inputs({input}, bytes);
        REQUIRE(engine->step({scene.settings.dt, bytes}, nullptr));
      };
      set_speed(-6);
      CHECK(engine->bodies()[3].center.x - engine->bodies()[1].center.x == Approx(1 - deep).epsilon(1e-5));
      CHECK(asleep_count(*engine) == 2);
      set_speed(0);
      CHECK(asleep_count(*engine) == 1);  // the far box sleeps on
      const auto again = make_engine_or_fail(scene);
      REQUIRE(again->load(image_of(*engine)));
      for (engine::Engine* each : {engine.get(), again.get()}) run_ticks(*each, 240);
      CHECK(engine->bodies()[3].center.x - engine->bodies()[1].center.x > 0.999);
      CHECK(asleep_count(*engine) == 2);
      CHECK(root_hash(again->state()) == root_hash(engine->state()));
      set_speed(0);  // it stood
      CHECK(asleep_count(*engine) == 2);
    }
}

TEST_CASE("where bodies sleep after no time at all, what moves does not sleep", "[engine][sleep]") {
  Scene scene = empty_scene(Precision::f32);
  scene.settings.sleep.emplace();
  scene.settings.sleep->after_s = 0;
  scene.bodies = {ground(), body_of(disc_shape(0.5), {0, 10})};
  scene.bodies[1].velocity = {3, 0};
  const auto falling = make_engine_or_fail(scene);
  run_ticks(*falling, 30);
  CHECK(falling->bodies()[1].center.y == Approx(10 - 5 * 0.5 * 0.5).epsilon(0.02));

  scene.gravity = {0, 0};  // a kinematic disc pushes one that sleeps
  scene.bodies = {body_of(disc_shape(0.5), {0, 1.5}, BodyType::kinematic_body), body_of(disc_shape(0.5), {0, 0.4})};
  scene.bodies[0].velocity = {0, -1};
  const auto pushed = make_engine_or_fail(scene);
  run_ticks(*pushed, 120);
  CHECK(pushed->bodies()[0].center.y - pushed->bodies()[1].center.y > 0.95);
}
