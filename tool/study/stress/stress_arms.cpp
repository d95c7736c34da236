// Stress cases of arms that hit something: boxes, welded in a row, that turn about a hinge.
// SPDX-License-Identifier: MIT
#include <cmath>

#include "tool/study/stress/stress_parts.h"
#include "tool/study/worlds.h"

namespace ticktrue::tool {
namespace {

using engine::Body;
using engine::JointKind;
using engine::Precision;
using engine::Scene;

constexpr double run_seconds = 1.5;  // the arm hits after .35 rad

// Boxes of 1 m, as one arm, turn about the origin without gravity. They hit a fixed disc.
Scene arm(Precision precision, std::uint32_t boxes, double speed, double restitution) {
  Scene scene = worlds::empty(precision);
  scene.name = "arm";
  scene.gravity = {0, 0};
  scene.bodies.push_back(worlds::peg({0, 0}));
  scene.bodies[0].shapes[0].filter.mask = 0;
  for (std::uint32_t i = 0; i < boxes; ++i) {
    Body box = worlds::weighted(worlds::box(0.5, 0.1), {0.5 + i, 0}, 1);
    box.velocity = {0, speed * box.position.x};
    box.angular_velocity = speed;
    scene.bodies.push_back(box);
    scene.joints.push_back(i == 0 ? worlds::joint(JointKind::revolute, 0, 1, {}, {-0.5, 0})
                                  : worlds::joint(JointKind::weld, i, i + 1, {0.5, 0}, {-0.5, 0}));
  }
  scene.bodies.push_back(worlds::body(worlds::disc(0.1), {0.8, 0.5}, engine::BodyType::static_body));
  worlds::set_material(scene, 0.5, restitution);
  return scene;
}

// `speed`, rad/s: high enough that the disc is hit above the threshold of restitution, 1 m/s. `seconds`: until after
// the bounce.
StressCase bounce_case(const std::string& name, const std::string& what, std::uint32_t boxes, int speed,
                       double seconds) {
  constexpr double restitution = 0.8;
  StressCase bounces = make_case(
      name,
      what + " at " + std::to_string(speed) + " rad/s and hit a disc with restitution .8: speed then, over -.8 of that",
      "of 1", 0.98, 1.02, joint_methods());
  bounces.run = [boxes, speed, seconds](const StressMethod& method, Precision precision) {
    return run_case(with_method(arm(precision, boxes, speed, restitution), method), seconds, {},
                    [speed](const engine::Engine&, const Bodies&, const Bodies& end) {
                      return -end[1].angular_velocity / (restitution * speed);
                    });
  };
  return bounces;
}

}  // namespace

void add_arm_cases(std::vector<StressCase>& cases) {
  for (const std::uint32_t boxes : {1u, 2u, 3u, 5u}) {
    const std::string name = std::to_string(boxes);
    const std::string what = name + (boxes == 1 ? " box of 1 m turns" : " welded boxes of 1 m turn") + " about a hinge";
    StressCase stops =
        make_case("arm_stops_" + name, what + " at 1 rad/s and hit a disc without restitution: speed 1.1 s after that",
                  "rad/s", 0, 0.05, joint_methods());
    stops.run = [boxes](const StressMethod& method, Precision precision) {
      return run_case(
          with_method(arm(precision, boxes, 1, 0), method), run_seconds, {},
          [](const engine::Engine&, const Bodies&, const Bodies& end) { return std::fabs(end[1].angular_velocity); });
    };
    cases.push_back(std::move(stops));
    cases.push_back(bounce_case("arm_bounces_" + name, what, boxes, 4, 0.5));
    cases.push_back(bounce_case("arm_fast_" + name, what, boxes, 12, 0.15));
  }
}

}  // namespace ticktrue::tool
