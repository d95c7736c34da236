// Stress cases of free motion: stiff springs and long orbits under every integrator, fast spins, damping, bad input.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/math/trig.h"
#include "tool/study/stress/stress_parts.h"
#include "tool/study/worlds.h"

namespace ticktrue::tool {
namespace {

using engine::Engine;
using engine::Force;
using engine::ForceKind;
using engine::Precision;
using engine::Scene;

StressCase motion_case(std::string name, std::string what, std::string unit, double lower, double upper,
                       std::string best_known, std::string source) {
  StressCase out;
  out.name = std::move(name);
  out.what = std::move(what);
  out.unit = std::move(unit);
  out.lower = lower;
  out.upper = upper;
  out.best_known = std::move(best_known);
  out.source = source.empty() || source == "own" ? std::move(source) : "accuracy study of 2026-11: " + source;
  out.methods = integrator_methods();
  return out;
}

Scene set_integrator(Scene scene, const StressMethod& method) {
  scene.settings.integrator = method.integrator;
  return scene;
}

void add_integrator_cases(std::vector<StressCase>& cases) {
  StressCase spring = motion_case(
      "force_spring_100", "1 kg on a force element of 100 N/m, no damping, 60 Hz, 10 s: amplitude of the last second",
      "of 1", 0.9, 1.1, "1 (midpoint, Verlet, by theory); Box2D HEAD 0.02, AVBD 0.0005", "section 6 case 2");
  spring.run = [](const StressMethod& method, Precision precision) {
    Scene scene = worlds::flight(precision, {1, 0}, {0, 0});
    Force force;
    force.kind = ForceKind::spring;
    force.body = 0;
    force.stiffness = 100;
    scene.forces.push_back(force);
    double most = 0;
    int tick = 0;
    return run_case(
        set_integrator(std::move(scene), method), 10,
        [&](const Bodies& bodies) {
          if (++tick > 540) most = std::max(most, std::fabs(bodies[0].center.x));
          return true;
        },
        [&](const Engine&, const Bodies&, const Bodies&) { return most; });
  };
  cases.push_back(std::move(spring));
  StressCase orbit = motion_case(
      "kepler_100",
      "an orbit of eccentricity 0.3, 100 times around, 500 steps each: largest relative error of the energy", "of 1", 0,
      0.01, "symplectic: bounded", "problem 9");
  orbit.only = Precision::f64;  // rounding in 50,000 steps of f32 exceeds the bound
  orbit.run = [](const StressMethod& method, Precision) {
    Scene scene = worlds::flight(Precision::f64, {0.7, 0}, {0, std::sqrt(1.3 / 0.7)});
    Force force;
    force.kind = ForceKind::central;
    force.coefficient = 1;
    force.exponent = -2;
    scene.forces.push_back(force);
    scene.settings.dt = 2 * engine::pi / 500;
    double most = 0;
    return run_case(
        set_integrator(std::move(scene), method), 100 * 2 * engine::pi,
        [&](const Bodies& bodies) {
          const double energy = kinetic_energy(bodies) - 1 / std::hypot(bodies[0].center.x, bodies[0].center.y);
          most = std::max(most, std::fabs(energy + 0.5) / 0.5);
          return true;
        },
        [&](const Engine&, const Bodies&, const Bodies&) { return most; });
  };
  cases.push_back(std::move(orbit));
  for (const double damping : {1.0, 1e3, 1e6}) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", damping);
    StressCase c =
        motion_case(std::string("damping_") + text,
                    std::string("damping of ") + text + " 1/s, from 10 m/s, 60 Hz, 2 s: least speed forwards", "m/s", 0,
                    10, "implicit 1/(1 + h c) form: never reverses", "section 6 case 3, derived");
    if (damping > 100)
      for (StressMethod& method : c.methods) {
        // These integrators evaluate damping as a force: c h must stay below their limit. No scene at 60 Hz keeps c h
        // below that limit here.
        const auto kind = method.integrator;
        method.is_baseline = method.is_baseline || kind == engine::IntegratorKind::rk4 ||
                             kind == engine::IntegratorKind::implicit_midpoint ||
                             kind == engine::IntegratorKind::yoshida4;
      }
    c.run = [damping](const StressMethod& method, Precision precision) {
      Scene scene = worlds::flight(precision, {0, 0}, {10, 0});
      scene.bodies[0].linear_damping = damping;
      double least = 10;
      return run_case(
          set_integrator(std::move(scene), method), 2,
          [&](const Bodies& bodies) {
            least = std::min(least, bodies[0].velocity.x);
            return true;
          },
          [&](const Engine&, const Bodies&, const Bodies&) { return least; });
    };
    cases.push_back(std::move(c));
  }
  StressCase spin =
      motion_case("spin_1000", "a free box at 1000 rad/s, 10 s: relative change of its spin", "of 1", 0, 1e-12,
                  "clamped to 47.1 (Box2D HEAD at 60 Hz) and 50 rad/s (AVBD)", "section 6 case 27");
  spin.run = [](const StressMethod& method, Precision precision) {
    Scene scene = worlds::flight(precision, {0, 0}, {0, 0});
    scene.bodies[0].angular_velocity = 1000;
    return run_case(set_integrator(std::move(scene), method), 10, {},
                    [](const Engine&, const Bodies&, const Bodies& end) {
                      return std::fabs(end[0].angular_velocity - 1000) / 1000;
                    });
  };
  cases.push_back(std::move(spin));
}

// Scenes that must be refused, each with one error.
std::vector<Scene> bad_scenes(Precision precision) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  std::vector<Scene> bad;
  const auto add = [&](auto change) {
    Scene scene = worlds::stack(precision, 2);
    change(scene);
    bad.push_back(std::move(scene));
  };
  for (const double value : {nan, inf, -inf}) {
    add([value](Scene& s) { s.bodies[1].position.x = value; });
    add([value](Scene& s) { s.bodies[1].velocity.y = value; });
    add([value](Scene& s) { s.bodies[1].angle = value; });
    add([value](Scene& s) { s.bodies[1].angular_velocity = value; });
    add([value](Scene& s) { s.gravity.y = value; });
    add([value](Scene& s) { s.settings.dt = value; });
    add([value](Scene& s) { s.bodies[1].shapes[0].density = value; });
    add([value](Scene& s) { s.bodies[1].shapes[0].half_size.x = value; });
    add([value](Scene& s) { s.bodies[1].mass = engine::ExplicitMass{value, {}, {}}; });
  }
  for (const double value : {0.0, -1.0}) {
    add([value](Scene& s) { s.settings.dt = value; });
    add([value](Scene& s) { s.bodies[1].mass = engine::ExplicitMass{value, {}, {}}; });
    add([value](Scene& s) { s.bodies[1].shapes[0].half_size.x = value; });
  }
  // Triangles: collinear corners, a repeated corner, an angle of almost 0.
  add([](Scene& s) { s.bodies[1].shapes[0] = worlds::polygon({{0, 0}, {1, 0}, {2, 0}}); });
  add([](Scene& s) { s.bodies[1].shapes[0] = worlds::polygon({{0, 0}, {1, 0}, {1, 0}}); });
  add([](Scene& s) { s.bodies[1].shapes[0] = worlds::polygon({{0, 0}, {1, 0}, {1, 1e-9}}); });
  return bad;
}

void add_other_cases(std::vector<StressCase>& cases) {
  StressCase bad = motion_case(
      "bad_input",
      "36 scenes, each with one number not finite, of the wrong sign, or a hull without area: accepted ones", "scenes",
      0, 0, "checked in debug builds only", "Box2D HEAD, section 6 case 28");
  bad.methods = {contact_methods()[0]};
  bad.run = [](const StressMethod&, Precision precision) {
    StressValue out;
    out.ran_in = precision;
    for (const Scene& scene : bad_scenes(precision)) out.value += engine::make_engine(scene) ? 1 : 0;
    return out;
  };
  cases.push_back(std::move(bad));
  StressCase landing = motion_case(
      "spin_landing", "a box spinning at 1000 rad/s falls on the ground, 10 s: largest energy over the start's", "of 1",
      0, 1.001, "", "section 6 case 27");
  landing.methods = contact_methods();
  landing.run = [](const StressMethod& method, Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies = {worlds::ground(), worlds::body(worlds::box(0.5, 0.5), {0, 2})};
    scene.bodies[1].angular_velocity = 1000;
    const Scene set = with_method(std::move(scene), method);
    double most = 0;
    return run_case(
        set, 10,
        [&](const Bodies& bodies) {
          most = std::max(most, energy_of(set, bodies));
          return true;
        },
        [&](const Engine&, const Bodies& start, const Bodies&) { return most / energy_of(set, start); });
  };
  cases.push_back(std::move(landing));
}

}  // namespace

void add_motion_cases(std::vector<StressCase>& cases) {
  add_integrator_cases(cases);
  add_other_cases(cases);
}

}  // namespace ticktrue::tool
