// Held islands: with measured loads, islands at rest keep their state and are not solved until something disturbs them.
// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "base/hash.h"
#include "base/parallel/chunk_order.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "tests/support/engine_runs.h"
#include "tests/support/joints.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::BodyReport;
using engine::Engine;
using engine::Input;
using engine::InputKind;

namespace {

constexpr int two_seconds = 120;  // ticks

Scene measured(Scene scene) {
  scene.settings.auto_substeps.emplace();
  scene.settings.substep_loads = engine::SubstepLoads::measured;
  return scene;
}

Scene builtin(const std::string& text, Precision precision) {
  Result<Scene> scene = engine::make_builtin_scene(text);
  REQUIRE(scene.has_value());
  scene->settings.precision = precision;
  return measured(*std::move(scene));
}

Scene tower(int count, Precision precision = Precision::f32) {
  Scene scene = measured(empty_scene(precision));
  scene.bodies.push_back(ground());
  for (int i = 0; i < count; ++i) scene.bodies.push_back(unit_box({0, i + 0.5}));
  return scene;
}

bool all_stand_still(const Engine& engine) {
  for (const BodyReport& body : engine.bodies())
    if (body.velocity.x != 0 || body.velocity.y != 0 || body.angular_velocity != 0) return false;
  return true;
}

// The bytes of all tables but `world`, which counts ticks.
Bytes bytes_of(const Engine& engine) {
  const StateView& view = engine.state();
  Bytes bytes;
  for (std::size_t table = 0; table < view.tables.size(); ++table) {
    if (view.schema->tables[table].name == "world") continue;
    const std::size_t size = view.tables[table].row_count * view.schema->tables[table].row_size;
    bytes.insert(bytes.end(), view.tables[table].data, view.tables[table].data + size);
  }
  return bytes;
}

void step_with(Engine& engine, const std::vector<Input>& inputs) {
  Bytes bytes;
  engine::encode_inputs(inputs, bytes);
  REQUIRE(engine.step({engine.scene().settings.dt, bytes}, nullptr));
}

Input input_to(InputKind kind, std::uint32_t body, double x, double y) {
  Input input;
  input.kind = kind;
  input.body = body;
  input.values = {x, y};
  return input;
}

// The way of the last body of a scene in the ten seconds after the first three, m.
double way_of_last(const Scene& scene) {
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 180);
  const Point start = engine->bodies().back().center;
  run_ticks(*engine, 600);
  const Point end = engine->bodies().back().center;
  return std::hypot(end.x - start.x, end.y - start.y);
}

}  // namespace

TEST_CASE("after 2.5 s at rest nothing is solved: no bit of the state changes", "[engine][islands][held]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const char* text : {"stack?boxes=10", "stack?boxes=40", "pyramid", "card_house", "chain"}) {
      CAPTURE(precision, text);
      const auto engine = make_engine_or_fail(builtin(text, precision));
      run_ticks(*engine, 150);
      CHECK(all_stand_still(*engine));
      const Bytes held = bytes_of(*engine);
      run_ticks(*engine, 100);
      CHECK(bytes_of(*engine) == held);
    }
}

TEST_CASE("held islands use no substep of their budget, and save it for what lands on them",
          "[engine][islands][held][budget]") {
  for (const int count : {3, 10}) {
    Scene scene = tower(count);
    scene.settings.substep_budget = 160;
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 150);
    // A scene counts as at least 88 boxes: each one, and a contact three times.
    CHECK(saved_work(*engine) == 6 * 160 * (88 * 4));
  }
}

TEST_CASE("a held island keeps its needs while another island moves", "[engine][islands][held]") {
  Scene scene = tower(20);
  for (const double x : {30.0, 31.0}) {  // two discs that roll to and fro in a bowl
    Body disc = body_of(disc_shape(0.2), {x, 6});
    disc.can_sleep = false;
    scene.bodies.push_back(disc);
  }
  scene.bodies.push_back(
      body_of(chain_shape({{36, 8}, {33, 2}, {30, 1}, {27, 2}, {24, 8}}), {0, 0}, BodyType::static_body));
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 180);
  const auto needs = [&] {  // of the tower's boxes, which are rows 1 to 20
    const StateView& view = engine->state();
    Bytes bytes;
    for (std::size_t table = 0; table < view.tables.size(); ++table) {
      const std::string& name = view.schema->tables[table].name;
      if (name != "substeps" && name != "loads" && name != "bodies") continue;
      const std::size_t size = view.schema->tables[table].row_size;
      bytes.insert(bytes.end(), view.tables[table].data + size, view.tables[table].data + 21 * size);
    }
    return bytes;
  };
  const Bytes before = needs();
  run_ticks(*engine, 120);
  CHECK_FALSE(all_stand_still(*engine));
  CHECK(needs() == before);
}

TEST_CASE("a press that is stalled is held, and goes on when its load is removed", "[engine][islands][held]") {
  Scene scene = tower(3);
  scene.inputs = {InputKind::remove};
  scene.bodies.push_back(unit_box({0, 3.5}));
  Joint ram = joint_of(JointKind::prismatic, 0, 4);
  ram.anchor_a = {0, 4.5};
  ram.axis = {0, -1};
  ram.motor = engine::JointMotor{1, 1000};
  scene.joints = {ram};
  const auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 180);
  REQUIRE(all_stand_still(*engine));
  const Bytes held = bytes_of(*engine);
  run_ticks(*engine, 60);
  CHECK(bytes_of(*engine) == held);
  const double before = engine->bodies().back().center.y;
  step_with(*engine, {input_to(InputKind::remove, 2, 0, 0)});
  run_ticks(*engine, 60);
  CHECK(before - engine->bodies().back().center.y > 0.5);
}

TEST_CASE("islands are held only with measured loads, in scenes without sleep", "[engine][islands][held]") {
  Scene by_weight = tower(10);
  by_weight.settings.substep_loads = engine::SubstepLoads::weight;
  Scene with_sleep = tower(10);
  with_sleep.settings.sleep.emplace();
  with_sleep.settings.sleep->after_s = 1000;
  for (const Scene& scene : {by_weight, with_sleep}) {
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, 300);
    CHECK_FALSE(all_stand_still(*engine));
  }
}

TEST_CASE("what disturbs a held tower moves it in the same tick or the next", "[engine][islands][held]") {
  Scene scene = tower(5);
  scene.inputs = {InputKind::spawn, InputKind::remove,       InputKind::impulse,
                  InputKind::force, InputKind::set_velocity, InputKind::set_gravity};
  scene.prototypes = {unit_box({0, 0})};
  scene.prototypes[0].name = "box";
  scene.bodies.push_back(body_of(box_shape(0.5, 0.5), {2, 0.5}, BodyType::kinematic_body));
  Input gravity = input_to(InputKind::set_gravity, 0, 1, -10);
  Input spawn = input_to(InputKind::spawn, 0, 0, 5.5);
  spawn.values[3] = 3;  // m/s
  const struct {
    const char* name;
    Input input;
    int ticks;
  } cases[] = {{"impulse", input_to(InputKind::impulse, 3, 0.01, 0), 1},
               {"force", input_to(InputKind::force, 3, 1, 0), 1},
               {"velocity", input_to(InputKind::set_velocity, 3, 0.1, 0), 1},
               {"no support", input_to(InputKind::remove, 1, 0, 0), 1},
               {"gravity", gravity, 1},
               {"a box comes to it", spawn, 1},
               {"a kinematic box comes to it", input_to(InputKind::set_velocity, 6, -1, 0), 62}};
  for (const auto& each : cases) {
    CAPTURE(each.name);
    const auto engine = make_engine_or_fail(scene);
    run_ticks(*engine, two_seconds);
    REQUIRE(all_stand_still(*engine));
    const Point before = engine->bodies()[3].center;
    step_with(*engine, {each.input});
    run_ticks(*engine, each.ticks);
    const std::size_t row = each.input.kind == InputKind::remove ? 2 : 3;
    const Point after = engine->bodies()[row].center;
    CHECK((after.x != before.x || after.y != before.y));
  }
}

TEST_CASE("an immovable new body pushes a held body out", "[engine][islands][held]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const BodyType type : {BodyType::static_body, BodyType::kinematic_body}) {
      CAPTURE(precision, type);
      Scene scene = measured(empty_scene(precision));
      scene.bodies = {ground(), body_of(disc_shape(0.5), {0, 0.5})};
      scene.inputs = {InputKind::spawn};
      scene.prototypes = {body_of(disc_shape(0.5), {0, 0}, type)};
      scene.prototypes[0].name = "disc";
      const auto engine = make_engine_or_fail(scene);
      run_ticks(*engine, two_seconds);
      REQUIRE(all_stand_still(*engine));
      step_with(*engine, {input_to(InputKind::spawn, 0, 0.75, 0.5)});
      run_ticks(*engine, two_seconds);
      CHECK(engine->bodies()[2].center.x - engine->bodies()[1].center.x > 0.98);
    }
}

TEST_CASE("what moves slowly on purpose is never held", "[engine][islands][held]") {
  constexpr double slow = 5e-4;  // m/s
  Scene lift = measured(empty_scene(Precision::f32));
  lift.bodies = {body_of(box_shape(2, 0.5), {0, -0.5}, BodyType::kinematic_body), unit_box({0, 0.5})};
  lift.bodies[0].velocity = {0, slow};
  CHECK(way_of_last(lift) == Approx(10 * slow).epsilon(0.01));

  Scene motor = measured(empty_scene(Precision::f32));
  motor.bodies = {ground(), unit_box({0, 5})};
  Joint slider = joint_of(JointKind::prismatic, 0, 1);
  slider.anchor_a = {0, 6};
  slider.axis = {0, 1};
  slider.motor = engine::JointMotor{slow, 100};
  motor.joints = {slider};
  CHECK(way_of_last(motor) == Approx(10 * slow).epsilon(0.05));

  Scene conveyor = measured(empty_scene(Precision::f32));
  conveyor.bodies = {ground(), unit_box({0, 0.5})};
  conveyor.bodies[0].shapes[0].material.tangent_speed = slow;
  CHECK(way_of_last(conveyor) == Approx(10 * slow).epsilon(0.01));

  Scene drifting = measured(empty_scene(Precision::f32));  // a force carries it, and nothing that is immovable
  drifting.bodies = {ground(), unit_box({0, 5})};
  drifting.bodies[1].velocity = {slow, 0};
  engine::Force lift_up;
  lift_up.body = 1;
  lift_up.vector = {0, 10};
  drifting.forces = {lift_up};
  CHECK(way_of_last(drifting) == Approx(10 * slow).epsilon(0.01));

  Scene sinking = measured(empty_scene(Precision::f32));  // through something thick, along a rail
  sinking.bodies = {ground(), unit_box({0, 5})};
  sinking.bodies[1].linear_damping = 10 / slow;
  slider.motor.reset();
  sinking.joints = {slider};
  CHECK(way_of_last(sinking) == Approx(10 * slow).epsilon(0.05));

  // A spring pushes it; damping below the limit would let it be held.
  Scene pushed = measured(empty_scene(Precision::f32));
  pushed.gravity = {-10, 0};  // across the rail
  pushed.bodies = {ground(), unit_box({0, 5})};
  pushed.bodies[1].linear_damping = 5;
  pushed.joints = {slider};
  engine::Force spring;
  spring.kind = engine::ForceKind::spring;
  spring.body = 1;
  spring.point = {0, 15};
  spring.stiffness = 5 * slow / 10;
  pushed.forces = {spring};
  CHECK(way_of_last(pushed) == Approx(10 * slow).epsilon(0.05));

  Scene joint_spring = measured(empty_scene(Precision::f32));
  joint_spring.gravity = {-10, 0};
  joint_spring.bodies = {ground(), unit_box({0, 5})};
  joint_spring.bodies[1].linear_damping = 5;
  slider.anchor_a = {0, 16};
  slider.spring = absolute_spring(5 * slow / 10);
  joint_spring.joints = {slider};
  CHECK(way_of_last(joint_spring) == Approx(10 * slow).epsilon(0.05));
}

TEST_CASE("weak gravity moves a slide, and a pin without gravity goes on turning",
          "[engine][islands][held][analytic]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    constexpr double gravity = 1e-3;  // m/s^2
    Scene slide = measured(empty_scene(precision));
    slide.gravity = {gravity, -gravity * 10};
    slide.bodies = {ground(), unit_box({-5, 0.5})};
    for (engine::Body& body : slide.bodies) body.shapes[0].material.friction = 0;
    // From 3 s to 13 s.
    CHECK(way_of_last(slide) == Approx(0.5 * gravity * (13.0 * 13 - 3 * 3)).epsilon(0.02));

    Scene hinge = measured(empty_scene(precision));  // turns freely about a pin
    hinge.gravity = {0, 0};
    hinge.bodies = {ground(), unit_box({1, 5})};
    hinge.bodies[1].angular_velocity = 2e-4;
    hinge.bodies[1].velocity = {0, 2e-4};
    Joint pin = joint_of(JointKind::revolute, 0, 1);
    pin.anchor_a = {0, 6};
    pin.anchor_b = {-1, 0};
    hinge.joints = {pin};
    CHECK(way_of_last(hinge) == Approx(10 * 2e-4).epsilon(0.05));
  }
}

TEST_CASE("a box lands on a held tower, and the tower moves by less than 5 mm and is held again",
          "[engine][islands][held][resting_impacts]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const int count : {3, 10, 40})
      for (const double aside : {0.0, 0.3})
        for (const double drop : {0.1, 1.0, 5.0}) {
          CAPTURE(precision, count, aside, drop);
          Scene scene = tower(count, precision);
          scene.settings.substep_budget = 160;
          scene.inputs = {InputKind::spawn};
          scene.prototypes = {unit_box({0, 0})};
          scene.prototypes[0].name = "box";
          const auto engine = make_engine_or_fail(scene);
          run_ticks(*engine, 150);
          REQUIRE(all_stand_still(*engine));
          const std::vector<BodyReport> rest = engine->bodies();
          step_with(*engine, {input_to(InputKind::spawn, 0, aside, count + 0.5 + drop)});
          double way = 0;
          for (int tick = 0; tick < 300; ++tick) {
            run_ticks(*engine, 1);
            const std::vector<BodyReport> bodies = engine->bodies();
            for (std::size_t i = 0; i < rest.size(); ++i)
              way = std::fmax(way,
                              std::hypot(bodies[i].center.x - rest[i].center.x, bodies[i].center.y - rest[i].center.y));
          }
          CHECK(way < 0.005);
          CHECK(std::abs(engine->bodies().back().center.y - (count + 0.5)) < 0.01);
          CHECK((count > 10 || all_stand_still(*engine)));
        }
}

TEST_CASE("held islands are the same after a load and in any order of chunks", "[engine][islands][held][determinism]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    Scene scene = tower(10, precision);
    for (int i = 0; i < 5; ++i) scene.bodies.push_back(unit_box({4.0 + i, 0.5 + 2 * i}));
    scene.settings.substep_budget = 160;
    scene.inputs = {InputKind::impulse};
    const auto engine = make_engine_or_fail(scene);
    const auto again = make_engine_or_fail(scene);
    ChunkOrder order(true);
    engine::EngineOptions options;
    options.parallel = {&order, 3};
    const auto chunked = make_engine_or_fail(scene, options);
    for (int tick = 0; tick < 700; ++tick) {
      CAPTURE(precision, tick);
      if (tick % 7 == 0) REQUIRE(again->load(image_of(*engine)));
      const std::vector<Input> inputs =
          tick == 250 ? std::vector<Input>{input_to(InputKind::impulse, 5, 0.5, 0)} : std::vector<Input>{};
      for (Engine* each : {engine.get(), again.get(), chunked.get()}) step_with(*each, inputs);
      REQUIRE(hex64(root_hash(again->state())) == hex64(root_hash(engine->state())));
      REQUIRE(hex64(root_hash(chunked->state())) == hex64(root_hash(engine->state())));
    }
    CHECK(all_stand_still(*engine));
  }
}
