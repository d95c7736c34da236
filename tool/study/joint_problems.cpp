// Verification problems of joints: pendulums, chains, springs, sliders.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "engine/math/trig.h"
#include "tool/study/closed_forms.h"
#include "tool/study/problem_families.h"
#include "tool/study/reference_numbers.h"
#include "tool/study/worlds.h"

namespace ticktrue::tool {
namespace {

using engine::BodyReport;
using engine::Engine;
using engine::JointKind;
using engine::JointMotor;
using engine::JointSpring;
using engine::pi;
using engine::Point;
using engine::Precision;
using engine::Scene;

Problem of_joints(std::string name, std::string summary, std::string reference, double duration) {
  Problem problem;
  problem.name = std::move(name);
  problem.summary = std::move(summary);
  problem.reference = std::move(reference);
  problem.kind = ProblemClass::joint;
  problem.duration = duration;
  problem.size = 0.2;  // discs of 0.1 m, links of 0.1 m half width; angles refer to arms of 1 m
  return problem;
}

/// Sets the bars of the three integrators that solve joints, at the default settings of a scene. `energy` in J, or 0
/// for no bar.
void set_bars(Problem& problem, double error, double energy = 0) {
  for (const char* method : {"tgs_soft", "tgs_soft verlet", "tgs_soft rk4"})
    problem.bars.push_back({method, "4 sub", error, energy});
}

// A disc that is almost a point.
engine::Body bob(Point position) {
  return worlds::weighted(worlds::disc(0.1), position, 1, 0.01);
}

double angle_below(const Point& from, const Point& to) {
  return std::atan2(to.x - from.x, from.y - to.y);
}

Problem pendulum_joint() {
  Problem problem =
      of_joints("pendulum_rod", "1 kg on a rod of 1 m, from 60 degrees, 4 s: angle", "closed form (Jacobi's sn)", 4);
  problem.is_angle = true;
  problem.scale = pi / 3;
  problem.scene = [](Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies = {worlds::peg({0, 0}), bob({std::sin(pi / 3), -0.5})};
    scene.joints = {worlds::joint(JointKind::distance, 0, 1)};
    return scene;
  };
  problem.observe = [](const Engine& engine) {
    return std::vector<double>{angle_below({0, 0}, engine.bodies()[1].center)};
  };
  problem.exact = [](double t) { return std::vector<double>{pendulum_angle(pi / 3, std::sqrt(10.0), t)}; };
  problem.slope = 1;
  problem.slope_of_higher = 2;    // the impulses of rods move bodies for the whole step (Andersen 1983)
  set_bars(problem, 0.02, 0.05);  // 1 % of the energy of the fall
  return problem;
}

Problem double_pendulum(std::string name, double start, const double* numbers) {
  Problem problem = of_joints(
      std::move(name),
      "two points of 1 kg on rods of 1 m, both from " + std::string(start < 2 ? "90" : "120") + " degrees, 2 s: angles",
      "long double integration, 17 digits (reference_numbers.h)", 2);
  problem.is_angle = true;
  problem.scale = start;
  problem.scene = [start](Precision precision) {
    Scene scene = worlds::empty(precision);
    const Point first{std::sin(start), -std::cos(start)};
    scene.bodies = {worlds::peg({0, 0}), bob(first), bob({2 * first.x, 2 * first.y})};
    scene.joints = {worlds::joint(JointKind::distance, 0, 1), worlds::joint(JointKind::distance, 1, 2)};
    return scene;
  };
  problem.observe = [](const Engine& engine) {
    const std::vector<BodyReport> bodies = engine.bodies();
    return std::vector<double>{angle_below({0, 0}, bodies[1].center), angle_below(bodies[1].center, bodies[2].center)};
  };
  problem.exact = [numbers](double t) {
    const int sample = static_cast<int>(std::lround(t * 10)) - 1;
    return std::vector<double>{numbers[2 * sample], numbers[2 * sample + 1]};
  };
  problem.slope = 1;
  problem.slope_of_higher = 2;  // the impulses of rods move bodies for the whole step (Andersen 1983)
  problem.substeps_max = 256;   // from 120 degrees the order shows beyond 32 substeps
  set_bars(problem, 0.02, 10 * (1 + 2) * (start < 2 ? 1 : 1.5) / 100);  // 1 % of the energy of the fall
  return problem;
}

// A spring without damping, given in N/m. With y = w h, the roots of the scheme equal those of the exact solution up to
// order y^5.
Problem spring_joint() {
  Problem problem = of_joints("spring_joint", "1 kg on a spring joint of 100 N/m, no damping, 2 s", "closed form", 2);
  problem.scale = 0.1;
  problem.scene = [](Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.gravity = {0, 0};
    scene.bodies = {worlds::peg({0, 0}), bob({1.1, 0})};
    scene.joints = {worlds::joint(JointKind::distance, 0, 1)};
    scene.joints[0].spring = JointSpring{true, 0, 0, 100, 0};
    return scene;
  };
  problem.observe = [](const Engine& engine) { return std::vector<double>{engine.bodies()[1].center.x - 1}; };
  problem.exact = [](double t) { return std::vector<double>{0.1 * std::cos(10 * t)}; };
  problem.slope = 1;
  set_bars(problem, 0.02);  // theory: w h / 2 = 0.021 of the amplitude, an RMS of 0.015
  return problem;
}

// A motor adds the same impulse in every substep: x = F t (t + h) / (2 m).
Problem slider_motor() {
  Problem problem = of_joints("slider_motor", "2 kg on a rail, driven by 6 N from rest, 2 s", "closed form", 2);
  problem.scale = 6;
  problem.scene = [](Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.gravity = {0, 0};
    scene.bodies = {worlds::peg({0, 0}), worlds::weighted(worlds::disc(0.1), {0, 0}, 2, 0.01)};
    scene.joints = {worlds::joint(JointKind::prismatic, 0, 1)};
    scene.joints[0].motor = JointMotor{1000, 6};
    return scene;
  };
  problem.observe = [](const Engine& engine) { return std::vector<double>{engine.bodies()[1].center.x}; };
  problem.exact = [](double t) { return std::vector<double>{1.5 * t * t}; };
  problem.slope = 1;
  set_bars(problem, 0.01);
  return problem;
}

// A pendulum turns a balanced wheel by a gear. The wheel adds inertia / ratio^2 and no weight.
Problem geared_pendulum() {
  constexpr double ratio = 2;
  constexpr double wheel_inertia = 4;
  // 1 kg and 0.01 kg m^2, 1 m from its pin; the wheel counts as 1 kg m^2.
  const double rate = std::sqrt(10 / (1 + 0.01 + wheel_inertia / (ratio * ratio)));
  Problem problem = of_joints("geared_pendulum", "1 kg swings from 60 degrees and turns a wheel by a gear, 4 s: angles",
                              "closed form (Jacobi's sn)", 4);
  problem.is_angle = true;
  problem.scale = pi / 3;
  problem.scene = [](Precision precision) {
    Scene scene = worlds::empty(precision);
    const Point start{std::sin(pi / 3), -std::cos(pi / 3)};
    scene.bodies = {worlds::peg({0, 0}), bob(start), worlds::peg({3, 0}),
                    worlds::weighted(worlds::disc(0.5), {3, 0}, 2, wheel_inertia)};
    scene.joints = {worlds::joint(JointKind::revolute, 0, 1, {}, {-start.x, -start.y}),
                    worlds::joint(JointKind::revolute, 2, 3), worlds::gear(0, 1, ratio)};
    return scene;
  };
  problem.observe = [](const Engine& engine) {
    const std::vector<BodyReport> bodies = engine.bodies();
    return std::vector<double>{pi / 3 + bodies[1].angle, pi / 3 - ratio * bodies[3].angle};
  };
  problem.exact = [rate](double t) {
    const double angle = pendulum_angle(pi / 3, rate, t);
    return std::vector<double>{angle, angle};
  };
  problem.slope = 1;
  problem.slope_of_higher = 2;    // the impulses of joints move bodies for the whole step (Andersen 1983)
  set_bars(problem, 0.02, 0.05);  // 1 % of the energy of the fall
  // A wrong impulse of the gear on the pinned body doubles the error of these two.
  for (const char* method : {"tgs_soft verlet", "tgs_soft rk4"}) problem.bars.push_back({method, "4 sub", 0.001, 0});
  return problem;
}

// A slider of 2 kg falls along a vertical rail and turns a wheel by a gear, as a rack does. The wheel counts as
// inertia / ratio^2 = 2 kg, so that the slider has half of the acceleration of gravity.
Problem rack() {
  constexpr double ratio = 4;  // m/rad: the wheel does not turn by half
  Problem problem = of_joints(
      "rack", "a slider of 2 kg falls and turns a wheel by a gear, 2 s: its way, and the wheel's", "closed form", 2);
  problem.scale = 10;
  problem.scene = [](Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies = {worlds::peg({0, 0}), worlds::weighted(worlds::disc(0.1), {0, 0}, 2, 0.01), worlds::peg({3, 0}),
                    worlds::weighted(worlds::disc(0.5), {3, 0}, 1, 2 * ratio * ratio)};
    engine::Joint rail = worlds::joint(JointKind::prismatic, 0, 1);
    rail.axis = {0, -1};
    scene.joints = {rail, worlds::joint(JointKind::revolute, 2, 3), worlds::gear(0, 1, ratio)};
    return scene;
  };
  problem.observe = [](const Engine& engine) {
    const std::vector<BodyReport> bodies = engine.bodies();
    return std::vector<double>{-bodies[1].center.y, -ratio * bodies[3].angle};
  };
  problem.exact = [](double t) { return std::vector<double>{2.5 * t * t, 2.5 * t * t}; };
  problem.slope = 1;
  problem.slope_of_higher = 2;  // the impulses of joints move bodies for the whole step (Andersen 1983)
  set_bars(problem, 0.01);
  return problem;
}

// Two weights of 2 kg on a rope over two wheels of different heights; the sides of the rope count 1 and 2 times. The
// first falls with g r (r m1 - m2) / (r^2 m1 + m2) = 4 m/s^2, the second rises with half of that.
Problem tackle() {
  Problem problem = of_joints("tackle", "a weight falls and pulls up another over a pulley of ratio 2, 2 s: both ways",
                              "closed form", 2);
  problem.scale = 8;
  problem.scene = [](Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies = {worlds::weighted(worlds::disc(0.1), {-1, 1}, 2), worlds::weighted(worlds::disc(0.1), {1.5, -2}, 2)};
    engine::Joint pulley = worlds::joint(JointKind::pulley, 0, 1);
    pulley.ground_anchor_a = {-1, 3};
    pulley.ground_anchor_b = {1.5, 5};
    pulley.ratio = 2;
    pulley.length = 2 + 2 * 7;
    scene.joints = {pulley};
    return scene;
  };
  problem.observe = [](const Engine& engine) {
    const std::vector<BodyReport> bodies = engine.bodies();
    return std::vector<double>{1 - bodies[0].center.y, bodies[1].center.y + 2};
  };
  problem.exact = [](double t) { return std::vector<double>{2 * t * t, t * t}; };
  problem.slope = 1;
  problem.slope_of_higher = 2;
  set_bars(problem, 0.01);
  return problem;
}

// A bar turns with 1 rad/s; a bead slides outward on it: r'' = r.
Problem bead() {
  Problem problem = of_joints("bead", "a bead slides outward on a bar that turns with 1 rad/s, 2 s: x and y",
                              "closed form (cosh)", 2);
  problem.scale = std::cosh(2.0);
  problem.scene = [](Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.gravity = {0, 0};
    scene.bodies = {worlds::body(worlds::box(4, 0.05), {0, 0}, engine::BodyType::kinematic_body), bob({1, 0})};
    scene.bodies[0].angular_velocity = scene.bodies[1].angular_velocity = 1;
    scene.bodies[1].velocity = {0, 1};
    scene.joints = {worlds::joint(JointKind::prismatic, 0, 1)};
    scene.joints[0].axis = {1, 0};
    return scene;
  };
  problem.observe = [](const Engine& engine) {
    const Point center = engine.bodies()[1].center;
    return std::vector<double>{center.x, center.y};
  };
  problem.exact = [](double t) { return std::vector<double>{std::cosh(t) * std::cos(t), std::cosh(t) * std::sin(t)}; };
  problem.slope = 2;  // no force acts but that of the joint
  set_bars(problem, 0.02);
  return problem;
}

// How far a body has fallen with 10 m/s^2 that something stops after `way` m.
double stopped_fall(double t, double way) {
  return std::min(way, 5 * t * t);
}

// A slider falls 4 m down a rail to its limit, and a weight falls 3 m until its rope is taut.
Problem stops() {
  constexpr double way_of_slider = 4, way_of_weight = 3;
  Problem problem = of_joints(
      "stops", "a slider falls to the end of its rail and a weight to that of its rope, 2 s: ways", "closed form", 2);
  problem.scale = way_of_slider;
  problem.scene = [](Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies = {worlds::peg({0, 0}), bob({0, 0}), bob({2, -0.5})};
    engine::Joint rail = worlds::joint(JointKind::prismatic, 0, 1);
    rail.axis = {0, 1};
    rail.limits = engine::Range{-way_of_slider, 1};
    engine::Joint rope = worlds::joint(JointKind::distance, 0, 2, {2, 0});
    rope.limits = engine::Range{0, 0.5 + way_of_weight};
    scene.joints = {rail, rope};
    return scene;
  };
  problem.observe = [](const Engine& engine) {
    const std::vector<BodyReport> bodies = engine.bodies();
    return std::vector<double>{-bodies[1].center.y, -0.5 - bodies[2].center.y};
  };
  problem.exact = [](double t) {
    return std::vector<double>{stopped_fall(t, way_of_slider), stopped_fall(t, way_of_weight)};
  };
  problem.slope = 1;  // a limit lets a body come as far as it within the substep
  problem.slope_of_higher = 2;
  set_bars(problem, 0.02);
  return problem;
}

Problem catenary() {
  Problem problem = of_joints("catenary", "20 links of 0.6 m between pegs 10 m apart, hung for 20 s: lowest point",
                              "exact equations of the links (sag 2.927214753 m)", 20);
  problem.sample_count = 1;
  problem.scale = catenary_sag;
  problem.size = 0.1;
  problem.scene = worlds::catenary;
  problem.observe = [](const Engine& engine) {
    const BodyReport link = engine.bodies()[10];
    return std::vector<double>{-(link.center.y + 0.3 * std::sin(link.angle))};
  };
  problem.exact = [](double) { return std::vector<double>{catenary_sag}; };
  problem.slope = 2;
  set_bars(problem, 0.01);
  return problem;
}

Problem straight_chain() {
  Problem problem =
      of_joints("chain", "20 links of 1 m hang straight down for 10 s: where the last one is", "geometry", 10);
  problem.sample_count = 1;
  problem.scale = 1;
  problem.scene = [](Precision precision) { return worlds::chain(precision, 20, {0, -1}, 1); };
  problem.observe = [](const Engine& engine) { return std::vector<double>{engine.bodies().back().center.y}; };
  problem.exact = [](double) { return std::vector<double>{-19.5}; };
  problem.slope = 2;
  set_bars(problem, 0.03);
  return problem;
}

Problem cantilever() {
  Problem problem =
      of_joints("cantilever", "5 planks of 1 m welded into a beam from a wall, 10 s: its end", "geometry", 10);
  problem.sample_count = 1;
  problem.scale = 1;
  problem.scene = [](Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies.push_back(worlds::peg({0, 0}));
    for (std::uint32_t i = 0; i < 5; ++i) {
      scene.bodies.push_back(worlds::weighted(worlds::box(0.5, 0.1), {i + 0.5, 0}, 1));
      scene.bodies.back().angular_damping = 1;
      scene.joints.push_back(worlds::joint(JointKind::weld, i, i + 1, i == 0 ? Point{0, 0} : Point{0.5, 0}, {-0.5, 0}));
    }
    return scene;
  };
  problem.observe = [](const Engine& engine) { return std::vector<double>{engine.bodies().back().center.y}; };
  problem.exact = [](double) { return std::vector<double>{0}; };
  problem.slope = 2;
  set_bars(problem, 0.01);
  for (const char* method : {"tgs_soft", "tgs_soft verlet", "tgs_soft rk4"})
    problem.shortfalls.push_back(
        {method, "welds give way by the square of a substep; `tgs_soft auto` keeps the bar", 0.12, 0});
  return problem;
}

}  // namespace

std::vector<Problem> joint_problems() {
  return {pendulum_joint(),
          double_pendulum("double_pendulum", pi / 2, double_pendulum_90),
          double_pendulum("double_pendulum_120", 2 * pi / 3, double_pendulum_120),
          spring_joint(),
          slider_motor(),
          geared_pendulum(),
          rack(),
          tackle(),
          bead(),
          stops(),
          catenary(),
          straight_chain(),
          cantilever()};
}

}  // namespace ticktrue::tool
