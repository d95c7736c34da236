// Stress cases of bodies that rotate in empty space or about a fixed point: a disc with rods, and bolas.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/math/trig.h"
#include "tool/study/stress/stress_parts.h"
#include "tool/study/worlds.h"

namespace ticktrue::tool {
namespace {

using engine::Body;
using engine::JointKind;
using engine::Point;
using engine::Precision;
using engine::Scene;

constexpr double turn_seconds = 10;
constexpr double slight_bend = 0.02;  // rad
constexpr double whip_bend = 0.3;     // rad

// Rotates all moving bodies about the origin as one rigid body.
void spin(Scene& scene, double speed) {
  for (Body& body : scene.bodies) {
    if (body.type != engine::BodyType::dynamic_body) continue;
    body.velocity = {-speed * body.position.y, speed * body.position.x};
    body.angular_velocity = speed;
  }
}

// A disc of 1 kg and 1 m, with rods of 2 m on its rim, joined by revolute joints.
Scene hub(Precision precision, int rods, double speed, bool is_pinned) {
  Scene scene = worlds::empty(precision);
  scene.name = "hub";
  scene.gravity = {0, 0};
  scene.bodies.push_back(worlds::weighted(worlds::disc(0.5), {0, 0}, 1, 0.125));
  for (int i = 0; i < rods; ++i) {
    const double angle = 2 * engine::pi * i / rods;
    const engine::SinCos to = engine::sin_cos(angle);
    Body rod = worlds::body(worlds::box(1, 0.05), {1.5 * to.cos, 1.5 * to.sin});
    rod.angle = angle;
    scene.bodies.push_back(std::move(rod));
    scene.joints.push_back(worlds::joint(JointKind::revolute, 0, static_cast<std::uint32_t>(i) + 1,
                                         {0.5 * to.cos, 0.5 * to.sin}, {-1, 0}));
  }
  if (is_pinned) {
    scene.bodies.push_back(worlds::peg({0, 0}));
    scene.joints.push_back(worlds::joint(JointKind::revolute, static_cast<std::uint32_t>(rods) + 1, 0));
  }
  worlds::touch_nothing(scene);
  spin(scene, speed);
  return scene;
}

// Two balls of 10 kg on a chain of six links of 0.5 m and 0.1 kg, which bend by turns. If `is_pinned`, a revolute joint
// holds the middle of the chain.
Scene bolas(Precision precision, double speed, double bend, bool is_pinned) {
  constexpr int links = 6;
  Scene scene = worlds::empty(precision);
  scene.name = "bolas";
  scene.gravity = {0, 0};
  const engine::SinCos turn = engine::sin_cos(bend);
  const Point half{0.25 * turn.cos, 0.25 * turn.sin};
  Point end{-links * half.x, 0};
  scene.bodies.push_back(worlds::weighted(worlds::disc(0.2), end, 10));
  for (std::uint32_t i = 0; i < links; ++i) {
    const double up = i % 2 == 0 ? 1 : -1;
    Body link = worlds::weighted(worlds::box(0.25, 0.05), {end.x + half.x, end.y + up * half.y}, 0.1);
    link.angle = up * bend;
    scene.bodies.push_back(link);
    scene.joints.push_back(worlds::joint(JointKind::revolute, i, i + 1, i == 0 ? Point{} : Point{0.25, 0}, {-0.25, 0}));
    end = {end.x + 2 * half.x, end.y + 2 * up * half.y};
  }
  scene.bodies.push_back(worlds::weighted(worlds::disc(0.2), end, 10));
  scene.joints.push_back(worlds::joint(JointKind::revolute, links, links + 1, {0.25, 0}));
  if (is_pinned) {
    scene.bodies.push_back(worlds::peg({0, 2 * half.y}));
    scene.joints.push_back(worlds::joint(JointKind::revolute, links + 2, links / 2, {}, {0.25, 0}));
  }
  worlds::touch_nothing(scene);
  spin(scene, speed);
  return scene;
}

using MakeScene = std::function<Scene(Precision)>;

void add_pair(std::vector<StressCase>& cases, const std::string& name, const std::string& what, double size,
              MakeScene make) {
  StressCase energy = make_case(name + "_energy", what + ": largest change of the energy over the start's", "of 1", 0,
                                0.01, joint_methods());
  energy.run = [make](const StressMethod& method, Precision precision) {
    const Scene scene = make(precision);
    double least = HUGE_VAL, most = 0;
    return run_case(
        with_method(scene, method), turn_seconds,
        [&](const Bodies& bodies) {
          least = std::min(least, kinetic_energy(bodies));
          most = std::max(most, kinetic_energy(bodies));
          return true;
        },
        [&](const engine::Engine&, const Bodies& start, const Bodies&) {
          return std::max(most / kinetic_energy(start) - 1, 1 - least / kinetic_energy(start));
        });
  };
  cases.push_back(std::move(energy));
  StressCase gap = make_case(name + "_gap", what + ": widest gap over the size of the smallest body", "of 1", 0, 0.01,
                             joint_methods());
  gap.run = [make = std::move(make), size](const StressMethod& method, Precision precision) {
    return worst_gap(with_method(make(precision), method), turn_seconds, 0, size);
  };
  cases.push_back(std::move(gap));
}

}  // namespace

void add_floating_cases(std::vector<StressCase>& cases) {
  for (const bool is_pinned : {false, true}) {
    const std::string name = is_pinned ? "pinned_" : "floating_";
    const std::string where = is_pinned ? "pinned to the world" : "in empty space";
    for (const int rods : {3, 8, 12})
      for (const double speed : {5.0, 20.0, 50.0})
        add_pair(cases, name + "hub_" + std::to_string(rods) + "_" + plain_number(speed),
                 "a hub of 1 kg with " + std::to_string(rods) + " pinned rods of 2 m " + where + " turns at " +
                     plain_number(speed) + " rad/s, 10 s",
                 1, [=](Precision precision) { return hub(precision, rods, speed, is_pinned); });
    for (const double speed : {5.0, 20.0, 50.0})
      add_pair(cases, name + "bolas_" + plain_number(speed),
               "two balls of 10 kg on a chain of 3 m and 0.6 kg " + where + " turn at " + plain_number(speed) +
                   " rad/s, 10 s",
               0.4, [=](Precision precision) { return bolas(precision, speed, 0, is_pinned); });
    for (const double speed : {5.0, 10.0})
      add_pair(cases, name + "whip_bolas_" + plain_number(speed),
               "the same, and the links bend by " + plain_number(whip_bend) + " rad in turns, at " +
                   plain_number(speed) + " rad/s, 10 s",
               0.4, [=](Precision precision) { return bolas(precision, speed, whip_bend, is_pinned); });
    for (const double speed : {5.0, 20.0, 50.0})
      add_pair(cases, name + "bent_bolas_" + plain_number(speed),
               "the same, and the links bend by " + plain_number(slight_bend) + " rad in turns, at " +
                   plain_number(speed) + " rad/s, 10 s",
               0.4, [=](Precision precision) { return bolas(precision, speed, slight_bend, is_pinned); });
  }
}

}  // namespace ticktrue::tool
