// The sessions over which engine properties are tested.
// SPDX-License-Identifier: MIT
#include "tests/support/engine_runs.h"

#include "engine/builtin_scenes.h"
#include "engine/math/random.h"
#include "engine/scene_fields.h"
#include "tests/support/catch.h"
#include "tests/support/scenes.h"

namespace ticktrue::test {
namespace {

using engine::Input;
using engine::InputKind;

/// A closed room with a kinematic paddle, a compound body and every shape, that declares every kind of input.
engine::Scene playground(engine::SolverKind solver, engine::Precision precision) {
  engine::Scene scene;
  scene.name = "playground";
  scene.settings.solver = solver;
  scene.settings.substeps = solver == engine::SolverKind::impulse ? 1 : 4;
  scene.settings.precision = precision;
  for (const auto& [x, y, hx, hy] : {std::array{0.0, -0.5, 8.0, 0.5}, {-8.5, 5.0, 0.5, 6.0}, {8.5, 5.0, 0.5, 6.0}})
    scene.bodies.push_back(body_of(box_shape(hx, hy), {x, y}, BodyType::static_body));
  scene.bodies.push_back(body_of(box_shape(1, 0.2), {-3, 1.5}, BodyType::kinematic_body));
  scene.bodies.back().angular_velocity = 2;
  scene.bodies.push_back(body_of(box_shape(0.8, 0.2), {3, 1}));
  Shape wing = box_shape(0.2, 0.6);
  wing.center = {0.5, 0.3};
  wing.angle = 0.4;
  wing.material.restitution = 0.6;
  scene.bodies.back().shapes.push_back(wing);
  scene.bodies.back().linear_damping = 0.3;
  scene.bodies.back().angular_damping = 0.2;
  for (int i = 0; i < 6; ++i) {
    const double x = -4 + 1.5 * i;
    scene.bodies.push_back(body_of(i % 2 == 0 ? disc_shape(0.4) : box_shape(0.4, 0.3), {x, 3.0 + 0.5 * i}));
    scene.bodies.back().shapes[0].material.restitution = 0.1 * i;
  }
  scene.prototypes = {body_of(disc_shape(0.3), {}), body_of(box_shape(0.35, 0.25), {}),
                      body_of(polygon_shape({{0.5, 0}, {0.2, 0.45}, {-0.4, 0.3}, {-0.35, -0.3}, {0.1, -0.5}}), {})};
  scene.prototypes[0].name = "disc";
  scene.prototypes[1].name = "brick";
  scene.prototypes[2].name = "gem";
  for (const engine::InputInfo& info : engine::input_kinds)
    if (!info.has_joint) scene.inputs.push_back(info.kind);  // it has no joints
  scene.pointer.emplace().spawns = {"disc", "brick", "gem"};
  scene.bounds = engine::Bounds{{-12, -4}, {12, 14}};
  scene.spawned_max = 12;
  return scene;
}

/// The playground with every shape, a chain for its floor, filters, a conveyor, a sensor and events.
engine::Scene shape_playground(engine::Precision precision) {
  engine::Scene scene = playground(engine::SolverKind::tgs_soft, precision);
  scene.name = "shapes";
  scene.settings.events = true;
  scene.bodies[0] =
      body_of(chain_shape({{8, 1}, {5, 0}, {1, 0.2}, {-2, 0}, {-5, 0.3}, {-8, 1}}), {0, 0}, BodyType::static_body);
  scene.bodies[0].shapes[0].material.tangent_speed = 0.5;
  Shape zone = box_shape(3, 1);
  zone.center = {2, 2};
  zone.sensor = true;
  scene.bodies[0].shapes.push_back(zone);
  scene.bodies[0].shapes.push_back(segment_shape({-6, 3}, {-4, 2.5}));
  Shape rounded = box_shape(0.3, 0.2);
  rounded.radius = 0.1;
  Shape gem = polygon_shape({{0.4, 0}, {0, 0.4}, {-0.4, -0.1}});
  gem.radius = 0.15;
  for (const Shape& shape : {capsule_shape({-0.3, 0}, {0.3, 0.1}, 0.25), rounded, gem}) {
    scene.prototypes.push_back(body_of(shape, {}));
    scene.prototypes.back().name = "shape_" + std::to_string(scene.prototypes.size());
    scene.pointer->spawns.push_back(scene.prototypes.back().name);
    scene.bodies.push_back(body_of(shape, {-3 + 2.0 * static_cast<double>(scene.prototypes.size() % 4), 6}));
  }
  scene.prototypes[3].shapes[0].material.rolling_resistance = 0.1;
  scene.prototypes[4].shapes[0].filter = {2, 0xfffffffe, -1};
  return scene;
}

/// The playground with a joint of every kind between its movable bodies, with limits, motors and springs.
engine::Scene jointed_playground(engine::Precision precision) {
  engine::Scene scene = playground(engine::SolverKind::tgs_soft, precision);
  scene.name = "jointed playground";
  scene.inputs.push_back(engine::InputKind::set_motor);
  for (const engine::Choice<engine::JointKind>& info : engine::joint_kinds) {
    const auto number = static_cast<std::uint32_t>(info.kind);
    engine::Joint joint;
    joint.name = number % 2 == 0 ? std::string(info.name) : "";
    joint.kind = info.kind;
    joint.body_a = 3 + number;  // the paddle is the first
    joint.body_b = number == 7 ? 4 : 4 + number;
    const auto& fields = info_of(engine::joint_fields, joint.kind);
    const auto has = [&fields](engine::JointField field) { return !engine::key_of(fields, field).empty(); };
    if (!has(engine::JointField::body_a)) joint.body_a = 0;
    if (has(engine::JointField::anchor_b)) joint.anchor_b = {-0.4, 0.1};
    if (has(engine::JointField::anchor_a)) joint.anchor_a = {0.9, 0.1};
    if (has(engine::JointField::limits))
      joint.limits = engine::Range{joint.kind == engine::JointKind::distance ? 0.5 : -0.5, 1.7};
    if (has(engine::JointField::motor)) joint.motor = engine::JointMotor{number - 3.0, 4};
    if (has(engine::JointField::spring) && number % 2 == 0)
      joint.spring = number == 4 ? engine::JointSpring{true, 0, 0, 40, 0.5} : engine::JointSpring{false, 2, 0.3, 0, 0};
    if (has(engine::JointField::offset)) joint.offset = {1.5, 0.5};
    if (has(engine::JointField::force_max)) joint.force_max = 30;
    if (has(engine::JointField::torque_max)) joint.torque_max = 5;
    if (has(engine::JointField::collide_connected)) joint.collide_connected = number == 2;
    scene.joints.push_back(joint);
  }
  return scene;
}

std::vector<Bytes> random_inputs(const engine::Scene& scene, std::uint64_t seed, std::uint64_t tick_count) {
  engine::Random random(seed);
  std::vector<Bytes> encoded;
  const auto event = [&](InputKind kind, std::uint8_t player) {
    Input input;
    input.kind = kind;
    input.player = player;
    const engine::InputInfo& info = info_of(engine::input_kinds, kind);
    if (info.has_body) input.body = static_cast<std::uint32_t>(4 + random.below(7));
    if (info.has_joint) input.joint = static_cast<std::uint32_t>(random.below(scene.joints.size()));
    if (info.has_prototype) input.prototype = static_cast<std::uint16_t>(random.below(scene.prototypes.size()));
    for (std::size_t i = 0; i < info.value_count; ++i) input.values[i] = random.real(-3, 3);
    const bool is_place = kind == InputKind::spawn || kind == InputKind::press || kind == InputKind::drag;
    if (is_place) input.values[0] = random.real(-7, 7);
    if (is_place) input.values[1] = random.real(0.5, 9);
    if (kind == InputKind::set_motor) input.values[1] = random.real(0, 20);
    if (kind == InputKind::set_gravity) input.values[1] = random.real(-12, -6);
    return input;
  };
  for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
    std::vector<Input> inputs;
    for (std::uint8_t player = 0; player < 2; ++player)
      for (std::uint32_t sequence = 0; sequence < random.below(3); ++sequence) {
        static constexpr InputKind often[] = {InputKind::press,   InputKind::drag,  InputKind::drag,
                                              InputKind::release, InputKind::spawn, InputKind::force,
                                              InputKind::impulse, InputKind::torque};
        static constexpr InputKind seldom[] = {InputKind::remove, InputKind::set_velocity, InputKind::set_gravity};
        const InputKind kind = random.below(20) == 0 ? seldom[random.below(3)] : often[random.below(8)];
        const bool drives = !scene.joints.empty() && random.below(4) == 0;
        inputs.push_back(event(drives ? InputKind::set_motor : kind, player));
        inputs.back().sequence = sequence;
      }
    Bytes bytes;
    engine::encode_inputs(inputs, bytes);
    encoded.push_back(std::move(bytes));
  }
  return encoded;
}

}  // namespace

std::vector<Session> property_sessions() {
  std::vector<Session> sessions;
  for (const engine::Choice<Precision>& precision : engine::precisions) {
    const std::string suffix = "precision=" + std::string(precision.name);
    for (const char* text : {"stack?boxes=6&jitter=0.01&", "pyramid?base=6&", "circles?", "mixed_pile?bodies=50&",
                             "projectile?", "billiards?", "shapes?bodies=30&", "slide?", "pendulum?", "chain?angle=1&", "bridge?planks=8&",
                             "joint_grid?columns=8&", "stack?boxes=4&solver=impulse&"}) {
      const auto scene = engine::make_builtin_scene(text + suffix);
      INFO(text << suffix << ": " << (scene ? "" : scene.error().message));
      REQUIRE(scene.has_value());
      sessions.push_back({text + suffix, *scene, {}});
    }
    const engine::Scene shapes = shape_playground(precision.kind);
    sessions.push_back({"shape playground " + suffix, shapes, random_inputs(shapes, 8, 400)});
    for (const engine::SolverKind solver : {engine::SolverKind::tgs_soft, engine::SolverKind::impulse}) {
      const engine::Scene scene = playground(solver, precision.kind);
      sessions.push_back({"playground " + std::string(info_of(engine::solvers, solver).name) + " " + suffix, scene,
                          random_inputs(scene, 7, 400)});
    }
    // Every force element, and an integrator with a table of its own.
    engine::Scene forced = playground(engine::SolverKind::tgs_soft, precision.kind);
    forced.settings.integrator = engine::IntegratorKind::thesis_verlet;
    for (const auto& info : engine::force_kinds) {
      engine::Force force;
      force.kind = info.kind;
      const auto& fields = info_of(engine::force_fields, info.kind);
      const auto has = [&fields](engine::ForceField field) { return !engine::key_of(fields, field).empty(); };
      if (has(engine::ForceField::vector)) force.vector = {0.5, 1};
      if (has(engine::ForceField::coefficient)) force.coefficient = 0.05;
      if (has(engine::ForceField::angular_coefficient)) force.angular_coefficient = 0.02;
      if (has(engine::ForceField::stiffness)) force.stiffness = 20;
      if (has(engine::ForceField::damping)) force.damping = 0.5;
      if (has(engine::ForceField::exponent)) force.exponent = 1;
      if (has(engine::ForceField::point)) force.point = {0, 3};
      if (info.kind == engine::ForceKind::spring) force.body = 5;
      forced.forces.push_back(force);
    }
    sessions.push_back({"playground forces " + suffix, forced, random_inputs(forced, 11, 400)});
    const engine::Scene jointed = jointed_playground(precision.kind);
    sessions.push_back({"jointed playground " + suffix, jointed, random_inputs(jointed, 11, 400)});
  }
  return sessions;
}

std::unique_ptr<engine::Engine> make_engine_or_fail(const engine::Scene& scene, const engine::EngineOptions& options) {
  auto engine = engine::make_engine(scene, options);
  INFO((engine ? "" : engine.error().message));
  REQUIRE(engine.has_value());
  return *std::move(engine);
}

TickInput input_of(const Session& session, std::uint64_t tick) {
  return {session.scene.settings.dt, tick < session.inputs.size() ? ByteView(session.inputs[tick]) : ByteView()};
}

std::vector<std::uint64_t> tick_hashes(const Session& session, std::uint64_t tick_count,
                                       const engine::EngineOptions& options) {
  const auto engine = make_engine_or_fail(session.scene, options);
  std::vector<std::uint64_t> hashes;
  for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
    const Status accepted = engine->accept(input_of(session, tick));
    INFO("tick " << tick << ": " << (accepted ? "" : accepted.error().message));
    REQUIRE(accepted.has_value());
    engine->step(input_of(session, tick), nullptr);
    hashes.push_back(root_hash(engine->state()));
  }
  return hashes;
}

Bytes image_of(const Simulation& simulation) {
  Bytes image;
  encode_image(simulation.state(), image);
  return image;
}

}  // namespace ticktrue::test
