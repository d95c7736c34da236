// Stress cases of every integrator with each rigid kind of joint: energy gained in 60 s.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "engine/math/trig.h"
#include "tool/study/stress/stress_parts.h"
#include "tool/study/worlds.h"

namespace ticktrue::tool {
namespace {

using engine::Body;
using engine::JointKind;
using engine::Precision;
using engine::Scene;

// A mechanism that swings under gravity without loss. `swing` is the energy difference between its highest and lowest
// position, J.
struct Mechanism {
  Scene scene;
  double swing = 0;
};

Mechanism empty_mechanism(Precision precision) {
  Mechanism out{worlds::empty(precision)};
  out.scene.name = "mechanism";
  out.scene.bodies.push_back(worlds::peg({0, 0}));
  return out;
}

// A box of 1 kg on an arm of 1 m below the origin, turned to 60 degrees.
Body swung_box() {
  Body body = worlds::weighted(worlds::box(0.1, 0.1), {std::sin(engine::pi / 3), -0.5}, 1);
  body.angle = engine::pi / 3;
  return body;
}

Mechanism on_revolute(Precision precision) {
  Mechanism out = empty_mechanism(precision);
  out.scene.bodies.push_back(swung_box());
  out.scene.joints = {worlds::joint(JointKind::revolute, 0, 1, {}, {0, 1})};
  out.swing = 5;
  return out;
}

Mechanism on_distance(Precision precision) {
  Mechanism out = empty_mechanism(precision);
  out.scene.bodies.push_back(swung_box());
  out.scene.joints = {worlds::joint(JointKind::distance, 0, 1)};
  out.swing = 5;
  return out;
}

// The box is welded to a second box, which hangs on a revolute joint.
Mechanism on_weld(Precision precision) {
  Mechanism out = empty_mechanism(precision);
  out.scene.bodies.push_back(swung_box());
  Body upper = worlds::weighted(worlds::box(0.1, 0.1), {0.5 * std::sin(engine::pi / 3), -0.25}, 1);
  upper.angle = engine::pi / 3;
  out.scene.bodies.push_back(upper);
  out.scene.joints = {worlds::joint(JointKind::revolute, 0, 2, {}, {0, 0.5}),
                      worlds::joint(JointKind::weld, 2, 1, {0, -0.25}, {0, 0.25})};
  out.swing = 7.5;
  return out;
}

// A rod of 2 m whose ends slide on the two axes. It starts at 30 degrees above level.
Body trammel_rod() {
  Body rod = worlds::weighted(worlds::box(1, 0.05), {std::cos(engine::pi / 6), std::sin(engine::pi / 6)}, 1);
  rod.angle = -engine::pi / 6;  // from (0, 1) to (1.73, 0)
  return rod;
}

// Revolute joints connect the ends of the rod to blocks on prismatic joints.
Mechanism on_prismatic(Precision precision) {
  Mechanism out = empty_mechanism(precision);
  out.scene.bodies.push_back(trammel_rod());
  out.scene.bodies.push_back(worlds::weighted(worlds::box(0.1, 0.1), {0, 1}, 1));
  out.scene.bodies.push_back(worlds::weighted(worlds::box(0.1, 0.1), {std::sqrt(3.0), 0}, 1));
  out.scene.joints = {worlds::joint(JointKind::prismatic, 0, 2), worlds::joint(JointKind::prismatic, 0, 3),
                      worlds::joint(JointKind::revolute, 2, 1, {}, {-1, 0}),
                      worlds::joint(JointKind::revolute, 3, 1, {}, {1, 0})};
  out.scene.joints[0].axis = {0, 1};
  out.swing = 10 * (1 + 2) + 10 * (0.5 + 1);  // at the lowest position the rod hangs from the level axis
  return out;
}

Mechanism on_wheel(Precision precision) {
  Mechanism out = empty_mechanism(precision);
  out.scene.bodies.push_back(trammel_rod());
  out.scene.joints = {worlds::joint(JointKind::wheel, 0, 1, {}, {-1, 0}),
                      worlds::joint(JointKind::wheel, 0, 1, {}, {1, 0})};
  out.scene.joints[0].axis = {0, 1};
  out.swing = 10 * (0.5 + 1);
  return out;
}

// A weight swings by half a radian. A counterweight balances the mean pull of the first weight: 1 + 0.5^2 / 4 times its
// mass.
Mechanism on_pulley(Precision precision) {
  Mechanism out = empty_mechanism(precision);
  const engine::SinCos lean = engine::sin_cos(0.5);
  out.scene.bodies.push_back(worlds::weighted(worlds::disc(0.1), {5 * lean.sin, 2 - 5 * lean.cos}, 1));
  out.scene.bodies.push_back(worlds::weighted(worlds::disc(0.1), {-4, -3}, 1.0625));
  engine::Joint pulley = worlds::joint(JointKind::pulley, 1, 2);
  pulley.ground_anchor_a = {0, 2};
  pulley.ground_anchor_b = {-4, 2};
  pulley.length = 10;
  out.scene.joints = {pulley};
  out.swing = 10 * 5 * (1 - lean.cos);
  return out;
}

// A gear couples the pin of a swinging box with that of a disc.
Mechanism on_gear(Precision precision) {
  Mechanism out = on_revolute(precision);
  out.scene.bodies.push_back(worlds::weighted(worlds::disc(0.5), {4, 0}, 2));
  out.scene.joints.push_back(worlds::joint(JointKind::revolute, 0, 2, {4, 0}));
  out.scene.joints.push_back(worlds::gear(0, 1, 2));
  return out;
}

struct Kind {
  JointKind joint;
  const char* what;
  Mechanism (*make)(Precision precision);
};
constexpr Kind kinds[]{
    {JointKind::revolute, "a box on a pin swings from 60 degrees", on_revolute},
    {JointKind::distance, "a box on a rod swings from 60 degrees", on_distance},
    {JointKind::weld, "a pendulum of two welded boxes swings from 60 degrees", on_weld},
    {JointKind::prismatic, "a rod turns between blocks on two sliders", on_prismatic},
    {JointKind::wheel, "a rod slides along two axes", on_wheel},
    {JointKind::pulley, "a weight swings on a pulley against another", on_pulley},
    {JointKind::gear, "a box on a pin swings from 60 degrees and turns a disc by a gear", on_gear},
};

std::vector<StressMethod> scheme_methods(bool joins_direct) {
  std::vector<StressMethod> methods = integrator_methods();
  for (StressMethod& method : methods) {
    method.solver = engine::SolverKind::tgs_soft;
    method.joins_direct = joins_direct;
  }
  return methods;
}

}  // namespace

void add_scheme_cases(std::vector<StressCase>& cases) {
  constexpr double seconds = 60, window = 10;
  for (const bool joins_direct : {false, true})
    for (const Kind& kind : kinds) {
      const std::string joint(engine::info_of(engine::joint_kinds, kind.joint).name);
      StressCase c =
          make_case((joins_direct ? "direct_gain_" : "gain_") + joint,
                    std::string(kind.what) + (joins_direct ? ", direct joints" : ", iterative joints") +
                        ", 60 s: mean energy of the last 10 s over that of the first, as a share of the swing's",
                    "of 1", joins_direct ? -0.01 : -0.1, 0.01, scheme_methods(joins_direct));
      c.run = [&kind](const StressMethod& method, Precision precision) {
        Mechanism mechanism = kind.make(precision);
        worlds::touch_nothing(mechanism.scene);
        const Scene scene = with_method(mechanism.scene, method);
        const double dt = scene.settings.dt;
        double first = 0, last = 0, time = 0;
        return run_case(
            scene, seconds,
            [&](const Bodies& bodies) {
              time += dt;
              if (time < window + dt / 2) first += energy_of(scene, bodies) * dt / window;
              if (time > seconds - window + dt / 2) last += energy_of(scene, bodies) * dt / window;
              return true;
            },
            [&](const engine::Engine&, const Bodies&, const Bodies&) { return (last - first) / mechanism.swing; });
      };
      cases.push_back(std::move(c));
    }
}

}  // namespace ticktrue::tool
