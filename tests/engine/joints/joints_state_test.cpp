// Joints as state: state rows appear and disappear with bodies, motors follow inputs, images restore the rows.
// SPDX-License-Identifier: MIT
#include "engine/scene/input.h"
#include "tests/support/engine_runs.h"
#include "tests/support/joints.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::Engine;
using engine::Input;
using engine::InputKind;

namespace {

Bytes encoded(const Input& input) {
  Bytes bytes;
  engine::encode_inputs({input}, bytes);
  return bytes;
}

Bytes set_motor(std::uint32_t joint, double speed, double force_max) {
  Input input;
  input.kind = InputKind::set_motor;
  input.joint = joint;
  input.values = {speed, force_max};
  return encoded(input);
}

Bytes remove_of(std::uint32_t body) {
  Input input;
  input.kind = InputKind::remove;
  input.body = body;
  return encoded(input);
}

// Two discs on pegs with motors, and a rod between them, without gravity.
Scene gear_scene() {
  Scene scene = empty_scene();
  scene.gravity = {0, 0};
  scene.bodies = {peg({0, 0}), bob({0, 0}, 1, 0.5), peg({5, 0}), bob({5, 0}, 1, 0.5)};
  scene.joints = {joint_of(JointKind::revolute, 0, 1), joint_of(JointKind::distance, 1, 3),
                  joint_of(JointKind::revolute, 2, 3)};
  scene.joints[0].motor = scene.joints[2].motor = engine::JointMotor{0, 0};
  scene.joints[1].length = 5;
  scene.joints[0].name = "left";
  scene.inputs = {InputKind::remove, InputKind::set_motor};
  return scene;
}

void step(Engine& engine, const Bytes& inputs = {}) {
  const TickInput input{dt, inputs};
  const Status accepted = engine.accept(input);
  INFO((accepted ? "" : accepted.error().message));
  REQUIRE(accepted.has_value());
  REQUIRE(engine.step(input, nullptr));
}

}  // namespace

TEST_CASE("set_motor acts from its tick on, on its joint alone", "[engine][joints][analytic]") {
  const auto engine = make_engine_or_fail(gear_scene());
  for (int tick = 0; tick < 10; ++tick) step(*engine);
  CHECK(engine->bodies()[1].angular_velocity == 0);
  step(*engine, set_motor(0, 10, 3));  // 6 rad/s^2
  CHECK(engine->bodies()[1].angular_velocity == Approx(6 * dt).epsilon(1e-9));
  CHECK(engine->bodies()[3].angular_velocity == 0);
  for (int tick = 0; tick < 59; ++tick) step(*engine);
  CHECK(engine->bodies()[1].angular_velocity == Approx(6).epsilon(1e-9));
  CHECK(joint_value(*engine, 0, "motor_speed") == 10);
  CHECK(joint_value(*engine, 0, "motor_force_max") == 3);
  step(*engine, set_motor(0, 0, 0));
  const double coasting = engine->bodies()[1].angular_velocity;
  for (int tick = 0; tick < 60; ++tick) step(*engine);
  CHECK(engine->bodies()[1].angular_velocity == Approx(coasting).epsilon(1e-12));
}

TEST_CASE("a joint goes with the first of its bodies, and its motor's inputs are then ignored",
          "[engine][joints][analytic]") {
  const auto engine = make_engine_or_fail(gear_scene());
  REQUIRE(joint_count(*engine) == 3);
  const std::size_t table = *engine->state().schema->find_table("joints");
  CHECK(engine->row_name(table, 0) == "left");
  CHECK(engine->row_name(table, 1) == "joint#1");
  step(*engine, remove_of(0));
  REQUIRE(joint_count(*engine) == 2);
  CHECK(joint_value(*engine, 0, "joint") == 1);
  CHECK(joint_value(*engine, 1, "joint") == 2);
  CHECK(engine->row_name(table, 0) == "joint#1");
  CHECK(engine->ignored_inputs() == 0);
  step(*engine, set_motor(0, 10, 3));
  CHECK(engine->ignored_inputs() == 1);
  step(*engine, set_motor(2, 10, 3));
  CHECK(engine->ignored_inputs() == 1);
  CHECK(engine->bodies().back().angular_velocity > 0);
  step(*engine, remove_of(3));
  CHECK(joint_count(*engine) == 0);
  step(*engine, set_motor(2, 1, 1));
  CHECK(engine->ignored_inputs() == 2);
}

TEST_CASE("bodies that leave the bounds take their joints with them", "[engine][joints][analytic]") {
  Scene scene = gear_scene();
  scene.bounds = engine::Bounds{{-10, -10}, {10, 10}};
  scene.bodies.push_back(bob({9.9, 5}));
  scene.bodies[4].velocity = {10, 0};
  scene.joints.push_back(joint_of(JointKind::distance, 3, 4));
  scene.joints.back().spring = absolute_spring(0.001);
  const auto engine = make_engine_or_fail(scene);
  CHECK(joint_count(*engine) == 4);
  for (int tick = 0; tick < 5; ++tick) step(*engine);
  CHECK(engine->bodies().size() == 4);
  CHECK(joint_count(*engine) == 3);
}

TEST_CASE("a scene without joints has no table of them", "[engine][joints][analytic]") {
  const auto engine = make_engine_or_fail(stack_scene(2));
  CHECK_FALSE(engine->state().schema->find_table("joints").has_value());
}

TEST_CASE("every kind of joint runs on with the same bits from an image", "[engine][joints][restore][determinism]") {
  for (const Session& session : property_sessions()) {
    if (session.scene.joints.empty()) continue;
    CAPTURE(session.name);
    const auto original = make_engine_or_fail(session.scene);
    std::uint64_t tick = 0;
    for (; tick < 25; ++tick) REQUIRE(original->step(input_of(session, tick), nullptr));
    REQUIRE(joint_count(*original) > 0);
    const auto restored = make_engine_or_fail(session.scene);
    REQUIRE(restored->load(image_of(*original)).has_value());
    for (; tick < 150; ++tick) {
      REQUIRE(original->step(input_of(session, tick), nullptr));
      REQUIRE(restored->step(input_of(session, tick), nullptr));
      REQUIRE(image_of(*restored) == image_of(*original));
    }
  }
}

TEST_CASE("each accumulated force of a joint influences the next tick", "[engine][joints][restore][determinism]") {
  // An unused force would not belong to the state. Force columns that a kind does not use stay zero.
  Scene scene = empty_scene();
  scene.bodies = {peg({0, 0}), bob({0.5, 0}), bob({1.5, 0})};
  scene.joints = {joint_of(JointKind::prismatic, 0, 1), joint_of(JointKind::weld, 1, 2)};
  scene.joints[0].axis = {0.3, -1};
  scene.joints[0].motor = engine::JointMotor{0, 3};
  scene.joints[0].spring = absolute_spring(30, 1);
  scene.joints[0].limits = engine::Range{-0.5, 0.01};
  const auto engine = make_engine_or_fail(scene);
  for (int tick = 0; tick < 30; ++tick) step(*engine);
  const Bytes image = image_of(*engine);
  step(*engine);
  const Bytes expected = image_of(*engine);
  const StateSchema& schema = *engine->state().schema;
  const std::size_t t = *schema.find_table("joints");
  const auto parts = split_image(schema, image);
  REQUIRE(parts.has_value());
  const auto at = static_cast<std::size_t>((*parts)[t].rows.data() - image.data());
  for (const char* name : {"motor_speed", "motor_force_max", "linear_force", "torque", "spring_force", "lower_force",
                           "upper_force", "motor_force"})
    for (const Column& column : schema.tables[t].columns) {
      if (column.name != name) continue;
      CAPTURE(name);
      Bytes changed = image;
      changed[at + column.offset + 6] = 0x11;  // exponent and first digits of a little-endian f64
      changed[at + column.offset + 7] = 0x40;
      REQUIRE(engine->load(changed).has_value());
      step(*engine);
      CHECK(image_of(*engine) != expected);
    }
}

TEST_CASE("an image whose joints are not those of the scene is refused", "[engine][joints][restore][corruption]") {
  const auto engine = make_engine_or_fail(gear_scene());
  step(*engine);
  const Bytes image = image_of(*engine);
  const StateSchema& schema = *engine->state().schema;
  const std::size_t t = *schema.find_table("joints");
  const auto parts = split_image(schema, image);
  REQUIRE(parts.has_value());
  const auto at = static_cast<std::size_t>((*parts)[t].rows.data() - image.data());
  const auto refused = [&](const Bytes& changed) {
    const Status status = engine->load(changed);
    return !status && status.error().code == ErrorCode::corrupt && image_of(*engine) == image;
  };
  const ByteView shorter = ByteView(image).first(image.size() - schema.tables[t].row_size);
  Bytes missing(shorter.begin(), shorter.end());  // without the last row
  missing[at - 4] = 2;
  CHECK(refused(missing));
  for (const std::size_t offset : {std::size_t{4}, std::size_t{8}, std::size_t{12}}) {  // kind, body_a, body_b
    Bytes other = image;
    other[at + offset] ^= 2;
    CAPTURE(offset);
    CHECK(refused(other));
  }
}

TEST_CASE("solvers that know no joints refuse them and name one that does", "[engine][joints][analytic]") {
  for (const engine::SolverInfo& solver : engine::solvers) {
    Scene scene = gear_scene();
    scene.settings.solver = solver.kind;
    if (!solver.substeps) scene.settings.substeps = 1;
    if (!solver.solves_constraints)  // otherwise the refusal is about contacts
      for (Body& body : scene.bodies) body.shapes[0].filter.mask = 0;
    const auto made = engine::make_engine(scene);
    CAPTURE(solver.name);
    CHECK(made.has_value() == solver.solves_joints);
    if (made) continue;
    CHECK(made.error().code == ErrorCode::incompatible);
    CHECK_THAT(made.error().message, Catch::Matchers::Contains("solves no joints"));
    CHECK_THAT(made.error().hint, Catch::Matchers::Contains("tgs_soft"));
  }
}
