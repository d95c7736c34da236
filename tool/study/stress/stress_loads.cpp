// Stress cases of loads other than weight: forces, motors, mouse joints, kinematic plates, each compared with an equal
// weight.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "tool/study/stress/stress_parts.h"
#include "tool/study/worlds.h"

namespace ticktrue::tool {
namespace {

using engine::BodyType;
using engine::Engine;
using engine::Input;
using engine::InputKind;
using engine::Point;
using engine::Precision;
using engine::Scene;

constexpr double load_seconds = 5;

// A stack, its load, and the inputs that make the load.
struct LoadedStack {
  Scene scene;
  InputsOfTick inputs = {};
  Point towards{0, -1};  // the direction of the load
};

LoadedStack by_weight(Precision precision, int count, double force) {
  LoadedStack out{worlds::stack(precision, count)};
  out.scene.bodies.back().mass = engine::ExplicitMass{1 + force / 10, {}, {}};
  return out;
}

LoadedStack by_force(Precision precision, int count, double force) {
  LoadedStack out{worlds::stack(precision, count)};
  engine::Force element;
  element.kind = engine::ForceKind::constant;
  element.body = static_cast<std::uint32_t>(count);
  element.vector = {0, -force};
  out.scene.forces.push_back(element);
  return out;
}

LoadedStack by_input(Precision precision, int count, double force) {
  LoadedStack out{worlds::stack(precision, count)};
  out.scene.inputs = {InputKind::force};
  Input push;
  push.kind = InputKind::force;
  push.body = static_cast<std::uint32_t>(count);
  push.values = {0, -force};
  out.inputs = [push](std::uint64_t) { return std::vector<Input>{push}; };
  return out;
}

// A motor drives the topmost box down from a peg above the box.
LoadedStack by_ram(Precision precision, int count, double force) {
  LoadedStack out{worlds::stack(precision, count)};
  const auto top = static_cast<std::uint32_t>(count);
  out.scene.bodies.push_back(worlds::peg({0, count + 20.0}));
  engine::Joint ram = worlds::joint(engine::JointKind::prismatic, top + 1, top, {0, -20.5});
  ram.axis = {0, -1};
  ram.motor = engine::JointMotor{10, force};
  out.scene.joints.push_back(ram);
  return out;
}

// A mouse joint holds the topmost box (1 kg). Its target is far below the ground, so it pulls with its largest force.
LoadedStack by_pointer(Precision precision, int count, double force) {
  LoadedStack out{worlds::stack(precision, count)};
  out.scene.inputs = {InputKind::press, InputKind::drag, InputKind::release};
  out.scene.pointer.emplace();
  out.scene.pointer->force_max_per_kg = force;
  const double top = count - 0.5;
  out.inputs = [top](std::uint64_t tick) {
    Input input;
    input.kind = tick == 0 ? InputKind::press : InputKind::drag;
    input.values = {0, tick == 0 ? top : -1e4};
    return std::vector<Input>{input};
  };
  return out;
}

// A kinematic plate pushes a row of boxes at 1 m/s, without gravity. Drag holds back the foremost box.
LoadedStack by_pusher(Precision precision, int count, double force) {
  LoadedStack out{worlds::empty(precision)};
  out.towards = {-1, 0};
  out.scene.name = "row";
  out.scene.gravity = {0, 0};
  out.scene.bodies.push_back(worlds::body(worlds::box(0.5, 100), {-0.5, 0}, BodyType::kinematic_body));
  for (int i = 0; i < count; ++i) out.scene.bodies.push_back(worlds::body(worlds::box(0.5, 0.5), {i + 0.5, 0}));
  for (engine::Body& body : out.scene.bodies) body.velocity = {1, 0};
  engine::Force drag;
  drag.kind = engine::ForceKind::linear_drag;
  drag.body = static_cast<std::uint32_t>(count);
  drag.coefficient = force;
  out.scene.forces.push_back(drag);
  return out;
}

// How much nearer the last box has come to body 0 (the ground or the plate) along the load, m.
StressValue squeeze(LoadedStack loaded, const StressMethod& method, int count) {
  const Point towards = loaded.towards;
  const auto top = static_cast<std::size_t>(count);
  return run_case(
      with_method(std::move(loaded.scene), method), load_seconds, {},
      [towards, top](const Engine&, const Bodies& start, const Bodies& end) {
        const auto way = [&](std::size_t i) {
          return towards.x * (end[i].center.x - start[i].center.x) + towards.y * (end[i].center.y - start[i].center.y);
        };
        return way(top) - way(0);
      },
      loaded.inputs);
}

struct Load {
  const char* name;
  const char* what;
  LoadedStack (*make)(Precision precision, int count, double force);
};
constexpr Load loads[]{
    {"force", "by a force element", by_force},
    {"input", "by an input force", by_input},
    {"ram", "by a motor", by_ram},
    {"pointer", "by a pointer", by_pointer},
    {"pusher", "between a kinematic plate and drag", by_pusher},
};

constexpr double lift_seconds = 2;
constexpr Point lift_velocity{0.25, 0.5};  // m/s

// Three boxes ride on a kinematic plate that moves up and aside. Friction takes them along.
StressCase lift() {
  StressCase out =
      make_case("lift",
                "a kinematic plate carries 3 boxes of 1 m up and aside for 2 s: how far a box or the plate "
                "is from where it should be",
                "m", 0, 0.003, load_methods());
  out.source = "own";
  out.run = [](const StressMethod& method, Precision precision) {
    Scene scene = worlds::stack(precision, 3);
    scene.bodies[0] = worlds::body(worlds::box(2, 0.5), {0, -0.5}, BodyType::kinematic_body);
    for (engine::Body& body : scene.bodies) body.velocity = lift_velocity;
    return run_case(
        with_method(std::move(scene), method), lift_seconds, {},
        [](const Engine&, const Bodies& start, const Bodies& end) {
          double worst = 0;
          for (std::size_t i = 0; i < end.size(); ++i)
            worst = std::max({worst, std::fabs(end[i].center.x - start[i].center.x - lift_velocity.x * lift_seconds),
                              std::fabs(end[i].center.y - start[i].center.y - lift_velocity.y * lift_seconds)});
          return worst;
        });
  };
  return out;
}

// A kinematic plate pushes a row of boxes over a floor at 1 m/s. All of them have this speed at the start.
StressCase pushed_row(int count, double last_mass) {
  StressCase out =
      make_case("push_" + std::to_string(count) + "_" + plain_number(last_mass),
                "a kinematic plate pushes " + std::to_string(count) +
                    " boxes of 1 m and 1 kg over a floor, the last of " + plain_number(last_mass) + " kg, " +
                    plain_number(load_seconds) + " s: largest speed of a box over that of the plate",
                "of 1", 0, 1.2, load_methods());
  out.source = "own";
  out.run = [=](const StressMethod& method, Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.name = "push";
    scene.bodies.push_back(worlds::body(worlds::box(1, 0.4), {-1, 0.5}, BodyType::kinematic_body));
    for (int i = 0; i < count; ++i) scene.bodies.push_back(worlds::body(worlds::box(0.5, 0.5), {i + 0.5, 0.5}));
    scene.bodies.back().mass = engine::ExplicitMass{last_mass, {}, {}};
    for (engine::Body& body : scene.bodies) body.velocity = {1, 0};
    scene.bodies.push_back(worlds::body(worlds::box(1000, 1), {0, -1}, BodyType::static_body));
    for (engine::Body& body : scene.bodies) body.shapes[0].material.friction = 0.5;
    scene.bodies[0].shapes[0].material.friction = 0;
    double most = 0;
    return run_case(
        with_method(std::move(scene), method), load_seconds,
        [&most](const Bodies& bodies) {
          for (const engine::BodyReport& body : bodies)
            most = std::max(most, std::hypot(body.velocity.x, body.velocity.y));
          return true;
        },
        [&most](const Engine&, const Bodies&, const Bodies&) { return most; });
  };
  return out;
}

}  // namespace

void add_load_cases(std::vector<StressCase>& cases) {
  for (const Load& load : loads)
    for (const int count : {5, 10, 20})
      for (const double force : {1e2, 1e3, 1e4, 1e5}) {
        StressCase c =
            make_case(std::string("load_") + load.name + "_" + std::to_string(count) + "_" + plain_number(force),
                      std::to_string(count) + " boxes of 1 m and 1 kg pressed " + load.what + " of " +
                          plain_number(force) + " N, " + plain_number(load_seconds) +
                          " s: squeeze over that by the same weight with automatic substeps",
                      "of 1", -HUGE_VAL, 1.2, load_methods());
        c.run = [&load, count, force](const StressMethod& method, Precision precision) {
          const StressValue weight = squeeze(by_weight(precision, count, force), contact_methods()[1], count);
          StressValue value = squeeze(load.make(precision, count, force), method, count);
          value.value /= weight.value;
          return value;
        };
        cases.push_back(std::move(c));
      }
  for (const int count : {2, 3, 10})
    for (const double last_mass : {1.0, 30.0, 1000.0}) cases.push_back(pushed_row(count, last_mass));
  cases.push_back(lift());
}

}  // namespace ticktrue::tool
