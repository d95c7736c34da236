// The smooth verification problems: motions whose error has the order of the integrator.
// SPDX-License-Identifier: MIT
// Source: Hairer, Lubich, Wanner, "Geometric Numerical Integration", 2006, I (oscillator, pendulum, Kepler).
#include "tool/study/problems.h"

#include <cmath>

#include "engine/math/trig.h"
#include "tool/study/closed_forms.h"
#include "tool/study/problem_families.h"
#include "tool/study/worlds.h"

namespace ticktrue::tool {

using engine::BodyReport;
using engine::Engine;
using engine::Force;
using engine::ForceKind;
using engine::pi;
using engine::Point;
using engine::Precision;
using engine::Scene;

double bouncing_height(double height, double restitution, double time_s) {
  double speed = std::sqrt(2 * 10 * height);
  double left = time_s - speed / 10;
  if (left < 0) return height - 5 * time_s * time_s;
  for (int bounce = 0; bounce < 1000; ++bounce) {
    speed *= restitution;
    if (left < 2 * speed / 10) return speed * left - 5 * left * left;
    left -= 2 * speed / 10;
  }
  return 0;
}

namespace {

std::vector<double> place_of_first(const Engine& engine) {
  const BodyReport body = engine.bodies()[0];
  return {body.center.x, body.center.y};
}

Force force_of(ForceKind kind) {
  Force force;
  force.kind = kind;
  return force;
}

// A spring of relaxed length 5 m from the disc to (-5, 0). Its force on the x axis is k x.
Force spring_along_x(double stiffness, double damping) {
  Force force = force_of(ForceKind::spring);
  force.body = 0;
  force.point = {-5, 0};
  force.rest_length = 5;
  force.stiffness = stiffness;
  force.damping = damping;
  return force;
}

Problem smooth(std::string name, std::string summary, double duration, int step_count, Point start, Point velocity) {
  Problem problem;
  problem.name = std::move(name);
  problem.summary = std::move(summary);
  problem.reference = "closed form";
  problem.duration = duration;
  problem.step_count = step_count;
  problem.start = start;
  problem.start_velocity = velocity;
  problem.observe = place_of_first;
  return problem;
}

Problem projectile() {
  Problem problem = smooth("projectile", "thrown at (3, 7) m/s, 2 s", 2, 40, {0, 0}, {3, 7});
  problem.is_exact_from_order_2 = true;
  problem.scale = 6;
  problem.scene = [](Precision precision) {
    Scene scene = worlds::flight(precision, {0, 0}, {3, 7});
    scene.gravity = {0, -10};
    return scene;
  };
  problem.exact = [](double t) { return std::vector<double>{3 * t, 7 * t - 5 * t * t}; };
  problem.acceleration = [](Point, Point) { return Point{0, -10}; };
  return problem;
}

Problem linear_drag() {
  Problem problem = smooth("linear_drag", "thrown at (10, 10) m/s, drag 0.5 kg/s, 2 s", 2, 40, {0, 0}, {10, 10});
  problem.scale = 10;
  problem.scene = [](Precision precision) {
    Scene scene = worlds::flight(precision, {0, 0}, {10, 10});
    scene.gravity = {0, -10};
    scene.forces.push_back(force_of(ForceKind::linear_drag));
    scene.forces[0].coefficient = 0.5;
    return scene;
  };
  problem.exact = [](double t) {
    const double gone = 1 - std::exp(-0.5 * t);
    return std::vector<double>{20 * gone, -20 * t + 60 * gone};
  };
  problem.acceleration = [](Point, Point v) { return Point{-0.5 * v.x, -10 - 0.5 * v.y}; };
  return problem;
}

// v = -u tanh(g t / u + a), u = sqrt(g / c), tanh a = 1 / u. The motion does not start from rest, because |v| v is not
// smooth at 0.
Problem quadratic_drag() {
  Problem problem =
      smooth("quadratic_drag", "thrown down at 1 m/s, drag 0.4 kg/m (5 m/s at last), 2 s", 2, 40, {0, 0}, {0, -1});
  problem.scale = 5;
  problem.scene = [](Precision precision) {
    Scene scene = worlds::flight(precision, {0, 0}, {0, -1});
    scene.gravity = {0, -10};
    scene.forces.push_back(force_of(ForceKind::quadratic_drag));
    scene.forces[0].coefficient = 0.4;
    return scene;
  };
  problem.exact = [](double t) {
    const double a = std::atanh(0.2);
    return std::vector<double>{0, -2.5 * std::log(std::cosh(2 * t + a) / std::cosh(a))};
  };
  problem.acceleration = [](Point, Point v) {
    const double speed = std::sqrt(v.x * v.x + v.y * v.y);
    return Point{-0.4 * speed * v.x, -10 - 0.4 * speed * v.y};
  };
  return problem;
}

// x'' = -100 x - 20 zeta x', from x = 1 at rest.
Problem oscillator(std::string name, double zeta) {
  Problem problem = smooth(std::move(name),
                           "100 N/m, 1 kg, damping ratio " +
                               std::string(zeta == 0   ? "0"
                                           : zeta < 1  ? "0.1"
                                           : zeta == 1 ? "1"
                                                       : "5") +
                               ", 2 s",
                           2, zeta > 1 ? 640 : 320, {1, 0}, {0, 0});
  problem.has_clocks = zeta == 0;
  problem.scene = [zeta](Precision precision) {
    Scene scene = worlds::flight(precision, {1, 0}, {0, 0});
    scene.forces.push_back(spring_along_x(100, 20 * zeta));
    return scene;
  };
  problem.exact = [zeta](double t) -> std::vector<double> {
    const double a = 10 * zeta;
    if (zeta == 1) return {std::exp(-a * t) * (1 + a * t), 0};
    if (zeta < 1) {
      const double w = 10 * std::sqrt(1 - zeta * zeta);
      return {std::exp(-a * t) * (std::cos(w * t) + a / w * std::sin(w * t)), 0};
    }
    const double s = 10 * std::sqrt(zeta * zeta - 1);
    return {((s + a) * std::exp((s - a) * t) + (s - a) * std::exp(-(s + a) * t)) / (2 * s), 0};
  };
  problem.acceleration = [zeta](Point x, Point v) { return Point{-100 * x.x - 20 * zeta * v.x, 0}; };
  return problem;
}

// theta'' = -10 sin theta from 60 degrees: theta = 2 asin(k sn(K - w t, k)). The scene has no joint. A very soft spring
// to a point 1e7 m below pulls the end of an arm of 1 m with 10 N, always in the same direction. A constant force of 10
// N at the centre balances the spring. The changing length of the spring changes its force by a relative 1e-12.
Problem pendulum() {
  Problem problem =
      smooth("pendulum", "1 m, from 60 degrees, as an equation of the angle, 2 s", 2, 120, {pi / 3, 0}, {0, 0});
  problem.has_clocks = true;
  problem.reference = "closed form (Jacobi's sn)";
  problem.is_angle = true;
  problem.scale = pi / 3;
  problem.scene = [](Precision precision) {
    Scene scene = worlds::flight(precision, {0, 0}, {0, 0});
    scene.bodies[0].mass->inertia = 1;
    scene.bodies[0].angle = pi / 3;
    Force pull = force_of(ForceKind::spring);
    pull.body = 0;
    pull.anchor = {0, -1};
    pull.point = {0, -1e7};
    pull.stiffness = 1e-6;
    Force hold = force_of(ForceKind::constant);
    hold.body = 0;
    hold.vector = {0, 10};
    scene.forces = {pull, hold};
    return scene;
  };
  problem.observe = [](const Engine& engine) { return std::vector<double>{engine.bodies()[0].angle}; };
  problem.exact = [](double t) { return std::vector<double>{pendulum_angle(pi / 3, std::sqrt(10.0), t)}; };
  problem.acceleration = [](Point x, Point) { return Point{-10 * std::sin(x.x), 0}; };
  return problem;
}

Problem kepler(std::string name, double e, int step_count) {
  Problem problem =
      smooth(std::move(name), "an orbit of eccentricity " + std::string(e < 0.5 ? "0.3" : "0.9") + ", once around",
             2 * pi, step_count, {1 - e, 0}, {0, std::sqrt((1 + e) / (1 - e))});
  problem.has_clocks = e < 0.5;
  problem.reference = "Kepler's equation";
  problem.scene = [start = problem.start, velocity = problem.start_velocity](Precision precision) {
    Scene scene = worlds::flight(precision, start, velocity);
    scene.forces.push_back(force_of(ForceKind::central));
    scene.forces[0].coefficient = 1;
    scene.forces[0].exponent = -2;
    return scene;
  };
  problem.exact = [e](double t) {
    double anomaly = e > 0.8 ? pi : t;
    for (int i = 0; i < 100; ++i) anomaly -= (anomaly - e * std::sin(anomaly) - t) / (1 - e * std::cos(anomaly));
    return std::vector<double>{std::cos(anomaly) - e, std::sqrt(1 - e * e) * std::sin(anomaly)};
  };
  problem.acceleration = [](Point x, Point) {
    const double r2 = x.x * x.x + x.y * x.y;
    const double r3 = r2 * std::sqrt(r2);
    return Point{-x.x / r3, -x.y / r3};
  };
  return problem;
}

// No torque acts: the angle is w t in every scheme.
Problem spin() {
  Problem problem = smooth("spin", "a free box at 100 rad/s, 2 s: angle and spin", 2, 40, {0, 0}, {100, 0});
  problem.is_angle = true;
  problem.is_exact = true;
  problem.scene = [](Precision precision) {
    Scene scene = worlds::flight(precision, {0, 0}, {0, 0});
    scene.bodies[0].angular_velocity = 100;
    return scene;
  };
  problem.observe = [](const Engine& engine) { return std::vector<double>{engine.bodies()[0].angle}; };
  problem.exact = [](double t) { return std::vector<double>{std::remainder(100 * t, 2 * pi)}; };
  problem.acceleration = [](Point, Point) { return Point{0, 0}; };
  return problem;
}

}  // namespace

std::vector<Problem> verification_problems() {
  std::vector<Problem> problems{projectile(),
                                linear_drag(),
                                quadratic_drag(),
                                oscillator("oscillator", 0),
                                oscillator("damped", 0.1),
                                oscillator("critical", 1),
                                oscillator("overdamped", 5),
                                pendulum(),
                                kepler("kepler", 0.3, 240),
                                kepler("kepler_09", 0.9, 4000),
                                spin()};
  for (Problem& problem : joint_problems()) problems.push_back(std::move(problem));
  for (Problem& problem : contact_problems()) problems.push_back(std::move(problem));
  return problems;
}

}  // namespace ticktrue::tool
