// The sessions over which engine properties are tested.
// SPDX-License-Identifier: MIT
#include "tests/support/engine_runs.h"

#include <fstream>
#include <sstream>

#include "base/random.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/clock/step_control.h"
#include "engine/scene/scene_json.h"
#include "tests/support/catch.h"
#include "tests/support/scenes.h"

namespace ticktrue::test {
namespace {

using engine::Input;
using engine::InputKind;

/// A closed room with a kinematic paddle, a compound body and every shape. The scene declares every kind of input.
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
    if (!info.has_joint) scene.inputs.push_back(info.kind);  // the scene has no joints
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

/// The scene with a gear between two of its joints, over four bodies. Jointed bodies with gears are solved by
/// iteration.
engine::Scene with_gear(engine::Scene scene) {
  engine::Joint pin;
  pin.kind = engine::JointKind::revolute;
  pin.body_a = 7;
  pin.body_b = 9;
  pin.anchor_a = {0.8, 0};
  pin.anchor_b = {-0.3, 0};
  engine::Joint gear;
  gear.kind = engine::JointKind::gear;
  gear.joint_a = static_cast<std::uint32_t>(engine::JointKind::revolute);
  gear.joint_b = static_cast<std::uint32_t>(scene.joints.size());
  gear.ratio = 1.5;
  scene.joints.push_back(pin);
  scene.joints.push_back(gear);
  return scene;
}

/// The playground with a joint of every kind but gears between its movable bodies, with limits, motors and springs.
engine::Scene jointed_playground(engine::Precision precision) {
  engine::Scene scene = playground(engine::SolverKind::tgs_soft, precision);
  scene.name = "jointed playground";
  scene.inputs.push_back(engine::InputKind::set_motor);
  for (const engine::Choice<engine::JointKind>& info : engine::joint_kinds) {
    if (info.kind == engine::JointKind::gear) continue;  // with_gear
    const auto number = static_cast<std::uint32_t>(info.kind);
    engine::Joint joint;
    joint.name = number % 2 == 0 ? std::string(info.name) : "";
    joint.kind = info.kind;
    joint.body_a = 3 + number;  // the body with id 3 is the paddle
    joint.body_b = number == 7 ? 4 : 4 + number;
    const auto& fields = info_of(engine::joint_kinds, joint.kind);
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
    if (joint.kind == engine::JointKind::pulley) {
      joint.body_a = 5;
      joint.body_b = 9;
      joint.ground_anchor_a = {-2, 8};
      joint.ground_anchor_b = {2, 9};
      joint.length = 9;
      joint.ratio = 1.5;
    }
    scene.joints.push_back(joint);
  }
  return scene;
}

/// Small boxes and discs form two heaps. The second heap falls onto the first, and a rope ties both. The scene uses
/// automatic substeps, and removes bodies that are thrown far away.
engine::Scene merging_heaps(engine::Precision precision) {
  engine::Scene scene;
  scene.name = "merging heaps";
  scene.settings.precision = precision;
  scene.settings.auto_substeps = engine::AutoSubsteps{0.005, 64};
  scene.settings.events = true;
  scene.bodies.push_back(body_of(box_shape(8, 0.5), {0, -0.5}, BodyType::static_body));
  for (int i = 0; i < 7; ++i) scene.bodies.push_back(body_of(box_shape(0.5, 0.25), {-2, 0.25 + 0.5 * i}));
  for (int i = 0; i < 5; ++i) scene.bodies.push_back(body_of(box_shape(0.4, 0.2), {-1.6 + 0.1 * i, 6 + 0.45 * i}));
  for (int i = 0; i < 3; ++i) scene.bodies.push_back(body_of(disc_shape(0.3), {2.0 + 0.7 * i, 0.3}));
  engine::Joint rope;
  rope.kind = engine::JointKind::distance;
  rope.body_a = 12;
  rope.body_b = 13;
  rope.limits = engine::Range{0, 5};
  scene.joints.push_back(rope);
  scene.prototypes = {body_of(disc_shape(0.3), {}), body_of(box_shape(0.35, 0.25), {})};
  scene.prototypes[0].name = "disc";
  scene.prototypes[1].name = "brick";
  scene.inputs = {InputKind::spawn, InputKind::remove, InputKind::impulse};
  scene.bounds = engine::Bounds{{-9, -3}, {9, 14}};
  scene.spawned_max = 4;
  return scene;
}

/// Bodies without contacts, on springs and under forces, solved implicitly. Bodies are spawned and removed.
engine::Scene springs_alone(engine::Precision precision) {
  engine::Scene scene;
  scene.name = "springs";
  scene.settings.precision = precision;
  scene.settings.solver = engine::SolverKind::free_flight;
  scene.settings.integrator = engine::IntegratorKind::implicit_midpoint;
  scene.settings.substeps = 2;
  for (int i = 0; i < 6; ++i) {
    scene.bodies.push_back(body_of(box_shape(0.3, 0.2), {static_cast<double>(i), 0.2 * i}));
    scene.bodies.back().shapes[0].filter.mask = 0;
  }
  scene.bodies[0].type = BodyType::kinematic_body;
  scene.bodies[0].velocity = {0.2, -0.1};
  for (std::uint32_t i = 0; i + 1 < scene.bodies.size(); ++i) {
    engine::Force spring;
    spring.kind = engine::ForceKind::spring;
    spring.body = i + 1;
    spring.other = i;
    spring.anchor = {-0.2, 0.1};
    spring.stiffness = 3000;
    spring.damping = 0.4;
    spring.rest_length = 0.9;
    scene.forces.push_back(spring);
  }
  engine::Force drag;
  drag.kind = engine::ForceKind::quadratic_drag;
  drag.coefficient = 0.1;
  scene.forces.push_back(drag);
  scene.prototypes = {body_of(disc_shape(0.3), {})};
  scene.prototypes[0].name = "disc";
  scene.prototypes[0].shapes[0].filter.mask = 0;
  scene.inputs = {InputKind::spawn, InputKind::remove, InputKind::impulse, InputKind::force, InputKind::torque};
  scene.bounds = engine::Bounds{{-12, -20}, {16, 14}};
  scene.spawned_max = 3;
  return scene;
}

Input random_event(const engine::Scene& scene, Random& random, InputKind kind, std::uint8_t player) {
  Input input;
  input.kind = kind;
  input.player = player;
  const engine::InputInfo& info = info_of(engine::input_kinds, kind);
  // Bodies of the scene from the fifth on, which are all dynamic.
  if (info.has_body)
    input.body = static_cast<std::uint32_t>(4 + random.below(scene.bodies.size() < 11 ? scene.bodies.size() - 4 : 7));
  if (info.has_joint) {
    std::vector<std::uint32_t> driven;
    for (std::uint32_t joint = 0; joint < scene.joints.size(); ++joint)
      if (scene.joints[joint].motor) driven.push_back(joint);
    input.joint = driven[random.below(driven.size())];
  }
  if (info.has_prototype) input.prototype = static_cast<std::uint16_t>(random.below(scene.prototypes.size()));
  for (std::size_t i = 0; i < info.value_count; ++i) input.values[i] = random.real(-3, 3);
  const bool is_place = kind == InputKind::spawn || kind == InputKind::press || kind == InputKind::drag;
  if (is_place) input.values[0] = random.real(-7, 7);
  if (is_place) input.values[1] = random.real(0.5, 9);
  if (kind == InputKind::set_motor) input.values[1] = random.real(0, 20);
  if (kind == InputKind::set_gravity) input.values[1] = random.real(-12, -6);
  return input;
}

/// One random declared event every `gap` ticks, so that bodies may sleep in between.
std::vector<Bytes> sparse_inputs(const engine::Scene& scene, std::uint64_t seed, std::uint64_t tick_count,
                                 std::uint64_t gap) {
  Random random(seed);
  std::vector<Bytes> encoded(tick_count);
  for (std::uint64_t tick = gap; tick < tick_count; tick += gap) {
    const InputKind kind = scene.inputs[random.below(scene.inputs.size())];
    if (kind != InputKind::end) engine::encode_inputs({random_event(scene, random, kind, 0)}, encoded[tick]);
  }
  return encoded;
}

std::vector<Bytes> random_inputs(const engine::Scene& scene, std::uint64_t seed, std::uint64_t tick_count) {
  Random random(seed);
  std::vector<Bytes> encoded;
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
        inputs.push_back(random_event(scene, random, drives ? InputKind::set_motor : kind, player));
        inputs.back().sequence = sequence;
      }
    Bytes bytes;
    engine::encode_inputs(inputs, bytes);
    encoded.push_back(std::move(bytes));
  }
  return encoded;
}

/// Tick lengths that the scene's clock makes of frames. Some frames are steady and some far too long.
std::vector<double> clocked_dts(const Session& session, std::uint64_t tick_count) {
  const auto engine = make_engine_or_fail(session.scene);
  Random random(17);
  engine::TickClock clock(session.scene.settings.clock, session.scene.settings.dt);
  engine::StepControl control(*engine);
  const bool adapts = session.scene.settings.clock.kind == engine::ClockKind::adaptive;
  std::vector<double> dts;
  while (dts.size() < tick_count) {
    clock.add_frame(random.below(9) == 0 ? 0.15 : random.real(0.012, 0.021));
    while (dts.size() < tick_count) {
      const auto wanted =
          adapts && clock.due_s() > 1e-8 ? control.choose(*engine, clock.due_s(), clock.report) : Result<double>(0.0);
      INFO((wanted ? "" : wanted.error().message));
      REQUIRE(wanted.has_value());
      const std::optional<double> dt = clock.next_tick(*wanted);
      if (!dt) break;
      REQUIRE(engine->step({*dt, input_of(session, dts.size()).inputs}, nullptr));
      dts.push_back(*dt);
    }
  }
  return dts;
}

std::string read_text(const std::string& path) {
  std::ifstream in(std::string(TICKTRUE_SOURCE_DIR) + "/" + path, std::ios::binary);
  CAPTURE(path);
  REQUIRE(in.good());
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
  return parts;
}

}  // namespace

std::vector<GoldenSession> golden_sessions() {
  std::vector<GoldenSession> sessions;
  for (const std::string& row : split(read_text("traces/MANIFEST.tsv"), '\n')) {
    const std::vector<std::string> fields = split(row, '\t');
    if (row[0] == '#' || fields[0] == "file") continue;
    CAPTURE(row);
    REQUIRE(fields.size() == 8);
    const std::string& place = fields[1];
    auto scene = place.find(".json") != std::string::npos ? engine::parse_scene(read_text(place), place)
                                                          : engine::make_builtin_scene(place);
    INFO((scene ? "" : scene.error().message));
    REQUIRE(scene.has_value());
    GoldenSession golden{{fields[0], *std::move(scene), {}, {}}, 0};
    std::vector<std::vector<Input>> ticks;
    const bool has_host = fields[2].compare(0, 5, "host:") == 0;  // frames of a host, not inputs
    if (fields[2] != "-" && !has_host)
      for (const std::string& line : split(read_text(fields[2]), '\n')) {
        const auto input = engine::parse_input(golden.session.scene, line, fields[2]);
        INFO((input ? "" : input.error().message));
        REQUIRE(input.has_value());
        if (input->kind == InputKind::end) golden.tick_count = input->tick;
        if (input->kind == InputKind::end) break;
        if (ticks.size() <= input->tick) ticks.resize(input->tick + 1);
        // Ordered by player, then by line.
        std::vector<Input>& tick = ticks[input->tick];
        auto at = tick.end();
        while (at != tick.begin() && (at - 1)->player > input->player) --at;
        const auto added = tick.insert(at, *input);
        added->sequence = added != tick.begin() && (added - 1)->player == added->player ? (added - 1)->sequence + 1 : 0;
      }
    golden.session.inputs.resize(ticks.size());
    for (std::size_t tick = 0; tick < ticks.size(); ++tick)
      engine::encode_inputs(ticks[tick], golden.session.inputs[tick]);
    if (fields[3] != "-") golden.tick_count = std::stoull(fields[3]);
    REQUIRE(golden.tick_count > 0);
    sessions.push_back(std::move(golden));
  }
  return sessions;
}

std::vector<Session> property_sessions() {
  std::vector<Session> sessions;
  for (const engine::Choice<Precision>& precision : engine::precisions) {
    const std::string suffix = "precision=" + std::string(precision.name);
    for (const char* text : {"stack?boxes=6&jitter=0.01&", "pyramid?base=6&", "pyramid?base=6&substeps=4&", "circles?",
                             "mixed_pile?bodies=50&substeps=4&", "projectile?", "billiards?",
                             "shapes?bodies=30&substeps=4&", "slide?substeps=4&", "pendulum?", "chain?angle=1&",
                             "chain?angle=1&substeps=4&", "bridge?planks=8&", "bridge?planks=8&joints=direct&",
                             "joint_grid?columns=8&", "stack?boxes=4&solver=impulse&", "gas?bodies=150&"}) {
      const auto scene = engine::make_builtin_scene(text + suffix);
      INFO(text << suffix << ": " << (scene ? "" : scene.error().message));
      REQUIRE(scene.has_value());
      sessions.push_back({text + suffix, *scene, {}, {}});
    }
    const engine::Scene shapes = shape_playground(precision.kind);
    sessions.push_back({"shape playground " + suffix, shapes, random_inputs(shapes, 8, 400), {}});
    for (const engine::SolverKind solver : {engine::SolverKind::tgs_soft, engine::SolverKind::impulse}) {
      const engine::Scene scene = playground(solver, precision.kind);
      sessions.push_back({"playground " + std::string(info_of(engine::solvers, solver).name) + " " + suffix,
                          scene,
                          random_inputs(scene, 7, 400),
                          {}});
    }
    // Every force element, and an integrator that has a state table.
    engine::Scene forced = playground(engine::SolverKind::tgs_soft, precision.kind);
    forced.settings.integrator = engine::IntegratorKind::thesis_verlet;
    for (const auto& info : engine::force_kinds) {
      engine::Force force;
      force.kind = info.kind;
      const auto& fields = info_of(engine::force_kinds, info.kind);
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
    sessions.push_back({"playground forces " + suffix, forced, random_inputs(forced, 11, 400), {}});
    const engine::Scene jointed = jointed_playground(precision.kind);
    sessions.push_back({"jointed playground " + suffix, jointed, random_inputs(jointed, 11, 400), {}});
    const engine::Scene geared = with_gear(jointed);
    sessions.push_back({"geared playground " + suffix, geared, random_inputs(geared, 11, 400), {}});
    engine::Scene direct = jointed;
    direct.settings.joints = engine::JointSolverKind::direct;
    sessions.push_back({"direct joints " + suffix, direct, random_inputs(direct, 21, 400), {}});
    direct.settings.integrator = engine::IntegratorKind::velocity_verlet;
    sessions.push_back({"direct joints velocity_verlet " + suffix, direct, random_inputs(direct, 22, 400), {}});
    engine::Scene iterated = geared;
    iterated.settings.solver = engine::SolverKind::pgs;
    iterated.settings.substeps = 1;
    sessions.push_back({"jointed playground pgs " + suffix, iterated, random_inputs(iterated, 12, 400), {}});
    engine::Scene sleepy = shapes;
    sleepy.settings.sleep = engine::SleepSettings{0.1, 0.2};
    sleepy.bodies[3].angular_velocity = 0;
    sessions.push_back({"sleepy shapes " + suffix, sleepy, sparse_inputs(sleepy, 13, 400, 23), {}});
    engine::Scene nodding = geared;
    nodding.settings.sleep = engine::SleepSettings{0.05, 0.5};
    nodding.settings.auto_substeps = engine::AutoSubsteps{0.01, 32};
    nodding.settings.substeps = 3;
    nodding.settings.events = true;
    nodding.bodies[3].angular_velocity = 0;
    sessions.push_back({"nodding joints " + suffix, nodding, sparse_inputs(nodding, 14, 400, 31), {}});
    nodding.joints = jointed.joints;
    nodding.settings.joints = engine::JointSolverKind::direct;
    sessions.push_back({"nodding direct joints " + suffix, nodding, sparse_inputs(nodding, 23, 400, 31), {}});
    const engine::Scene heaps = merging_heaps(precision.kind);
    sessions.push_back({"merging heaps " + suffix, heaps, sparse_inputs(heaps, 15, 400, 17), {}});
    for (const engine::ClockKindInfo& clock : engine::clock_kinds) {
      Session timed{"playground clock " + std::string(clock.name) + " " + suffix, shapes, {}, {}};
      timed.scene.settings.clock.kind = clock.kind;
      if (clock.kind == engine::ClockKind::adaptive) timed.scene.settings.clock.tolerance = 1e-3;
      timed.inputs = random_inputs(timed.scene, 18, 400);
      timed.dts = clocked_dts(timed, 240);
      sessions.push_back(std::move(timed));
    }
    const engine::Scene springs = springs_alone(precision.kind);
    sessions.push_back({"springs " + suffix, springs, sparse_inputs(springs, 16, 400, 7), {}});
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
  const double dt = tick < session.dts.size() ? session.dts[tick] : session.scene.settings.dt;
  return {dt, tick < session.inputs.size() ? ByteView(session.inputs[tick]) : ByteView()};
}

std::vector<std::uint64_t> tick_hashes(const Session& session, std::uint64_t tick_count,
                                       const engine::EngineOptions& options) {
  const auto engine = make_engine_or_fail(session.scene, options);
  std::vector<std::uint64_t> hashes;
  for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
    const Status accepted = engine->accept(input_of(session, tick));
    INFO("tick " << tick << ": " << (accepted ? "" : accepted.error().message));
    REQUIRE(accepted.has_value());
    REQUIRE(engine->step(input_of(session, tick), nullptr));
    hashes.push_back(root_hash(engine->state()));
  }
  return hashes;
}

Bytes image_of(const Simulation& simulation) {
  Bytes image;
  encode_image(simulation.state(), image);
  return image;
}

void run_ticks(engine::Engine& engine, int tick_count) {
  const TickInput input{engine.scene().settings.dt, {}};
  for (int i = 0; i < tick_count; ++i) REQUIRE(engine.step(input, nullptr));
}

std::uint64_t saved_work(const engine::Engine& engine) {
  const StateView& view = engine.state();
  const auto table = view.schema->find_table("budget");
  REQUIRE(table.has_value());
  std::uint64_t work = 0;
  for (const Column& column : view.schema->tables[*table].columns)
    if (column.name == "saved_work") std::memcpy(&work, view.tables[*table].data + column.offset, sizeof work);
  return work;
}

}  // namespace ticktrue::test
