// Verification problems of contacts: impacts, friction, rest, and four tasks for a disc and each polygon.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "engine/math/trig.h"
#include "tool/study/measures.h"
#include "tool/study/problem_families.h"
#include "tool/study/reference_numbers.h"
#include "tool/study/worlds.h"

namespace ticktrue::tool {
namespace {

using engine::BodyReport;
using engine::ContactReport;
using engine::Engine;
using engine::pi;
using engine::Point;
using engine::Precision;
using engine::Scene;

Problem of_contacts(ProblemClass kind, std::string name, std::string summary, double duration) {
  Problem problem;
  problem.kind = kind;
  problem.name = std::move(name);
  problem.summary = std::move(summary);
  problem.reference = "closed form";
  problem.duration = duration;
  problem.size = 1;
  return problem;
}

std::vector<double> x_of_second(const Engine& engine) {
  return {engine.bodies()[1].center.x};
}

// ---- Impacts ----

Problem bounce(std::string name, double height, double restitution, double duration) {
  Problem problem =
      of_contacts(ProblemClass::impact, std::move(name),
                  "a disc falls " + std::string(height > 5 ? "10" : "1") + " m and bounces with restitution " +
                      std::string(restitution == 1 ? "1" : "0.8") + ": height",
                  duration);
  problem.scale = height;
  problem.scene = [height, restitution](Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies = {worlds::ground(), worlds::body(worlds::disc(0.5), {0, height + 0.5})};
    worlds::set_bounces(scene, restitution);
    return scene;
  };
  problem.observe = [](const Engine& engine) { return std::vector<double>{engine.bodies()[1].center.y - 0.5}; };
  problem.exact = [height, restitution](double t) {
    return std::vector<double>{bouncing_height(height, restitution, t)};
  };
  problem.slope = 1;
  problem.bars = {{"tgs_soft", "4 sub", 0.01}};
  return problem;
}

Problem collision(std::string name, double restitution) {
  Problem problem = of_contacts(
      ProblemClass::impact, std::move(name),
      "1 kg at 4 m/s meets 3 kg at rest, restitution " + std::string(restitution == 1 ? "1" : "0.5") + ": speeds after",
      1);
  problem.sample_count = 1;
  problem.scale = 4;
  problem.is_exact = true;
  problem.is_pair = true;
  problem.size = 0;
  problem.scene = [restitution](Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.gravity = {0, 0};
    scene.bodies = {worlds::weighted(worlds::disc(0.5), {-2, 0}, 1), worlds::weighted(worlds::disc(0.5), {0, 0}, 3)};
    scene.bodies[0].velocity = {4, 0};
    worlds::set_bounces(scene, restitution);
    return scene;
  };
  problem.observe = [](const Engine& engine) {
    const auto bodies = engine.bodies();
    return std::vector<double>{bodies[0].velocity.x, bodies[1].velocity.x};
  };
  problem.exact = [restitution](double) { return std::vector<double>{1 - 3 * restitution, 1 + restitution}; };
  problem.bars = {{"tgs_soft", "4 sub", 1e-6}};
  return problem;
}

Problem cradle() {
  Problem problem =
      of_contacts(ProblemClass::impact, "cradle", "a disc at 10 m/s meets four in a row, 1 mm apart: speeds after", 1);
  problem.sample_count = 1;
  problem.scale = 10;
  problem.is_exact = true;
  problem.size = 0;
  problem.scene = [](Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.gravity = {0, 0};
    scene.bodies = {worlds::weighted(worlds::disc(0.5), {-2, 0}, 1)};
    scene.bodies[0].velocity = {10, 0};
    for (int i = 0; i < 4; ++i) scene.bodies.push_back(worlds::weighted(worlds::disc(0.5), {i * 1.001, 0}, 1));
    worlds::set_bounces(scene, 1);
    return scene;
  };
  problem.observe = [](const Engine& engine) {
    std::vector<double> speeds;
    for (const BodyReport& body : engine.bodies()) speeds.push_back(body.velocity.x);
    return speeds;
  };
  problem.exact = [](double) { return std::vector<double>{0, 0, 0, 0, 10}; };
  problem.bars = {{"tgs_soft", "4 sub", 1e-6}};
  return problem;
}

Problem billiards() {
  Problem problem = of_contacts(ProblemClass::impact, "billiards",
                                "a disc at 20 m/s breaks fifteen, restitution 1: momentum and root of the energy", 2);
  problem.sample_count = 4;
  problem.scale = 20;
  problem.is_exact = true;
  problem.size = 0;
  problem.scene = [](Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.gravity = {0, 0};
    scene.bodies = {worlds::weighted(worlds::disc(0.5), {-6, 0.1}, 1)};
    scene.bodies[0].velocity = {20, 0};
    for (int row = 0; row < 5; ++row)
      for (int i = 0; i <= row; ++i)
        scene.bodies.push_back(worlds::weighted(worlds::disc(0.5), {row * 0.88, i * 1.01 - row * 0.505}, 1));
    worlds::set_bounces(scene, 1);
    return scene;
  };
  problem.observe = [](const Engine& engine) {
    const Bodies bodies = engine.bodies();
    const Point momentum = momentum_of(bodies);
    return std::vector<double>{momentum.x, momentum.y, std::sqrt(2 * kinetic_energy(bodies))};
  };
  problem.exact = [](double) { return std::vector<double>{20, 0, 20}; };
  problem.bars = {{"tgs_soft", "4 sub", 0.001}};
  return problem;
}

// ---- Friction ----

Scene slide_scene(Precision precision, double speed, double friction) {
  Scene scene = worlds::empty(precision);
  scene.bodies = {worlds::ground(), worlds::body(worlds::box(0.5, 0.5), {0, 0.5})};
  scene.bodies[1].velocity = {speed, 0};
  worlds::set_material(scene, friction, 0);
  return scene;
}

double slid(double t) {
  return t < 2 ? 10 * t - 2.5 * t * t : 10;
}

Problem slide() {
  Problem problem = of_contacts(ProblemClass::friction, "slide", "a box at 10 m/s, friction 0.5, stops after 10 m", 3);
  problem.scale = 10;
  problem.scene = [](Precision precision) { return slide_scene(precision, 10, 0.5); };
  problem.observe = x_of_second;
  problem.exact = [](double t) { return std::vector<double>{slid(t)}; };
  problem.slope = 1;
  problem.slope_of_higher = 2;  // a known friction is a constant force
  problem.bars = {{"tgs_soft", "4 sub", 0.0025}};
  return problem;
}

Problem slip() {
  Problem problem = of_contacts(ProblemClass::friction, "slip",
                                "a box on a slope of 20 degrees, friction 0.95 tan 20, slips 0.342 m in 2 s", 2);
  problem.scale = 0.3420201433;
  problem.scene = [](Precision precision) {
    Scene scene = slide_scene(precision, 0, 0.95 * std::tan(20 * pi / 180));
    worlds::lean(scene, 20);
    return scene;
  };
  problem.observe = x_of_second;
  problem.exact = [](double t) { return std::vector<double>{0.25 * std::sin(20 * pi / 180) * t * t}; };
  problem.slope = 1;
  return problem;
}

// A disc (inertia m r^2 / 2) or ring (m r^2) of 1 kg and 0.5 m.
Problem rolling(std::string name, double inertia_share) {
  Problem problem = of_contacts(
      ProblemClass::friction, std::move(name),
      std::string(inertia_share < 1 ? "a disc" : "a ring") + " rolls down a slope of 20 degrees, friction 0.5, 2 s", 2);
  problem.scene = [inertia_share](Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies = {worlds::ground(), worlds::weighted(worlds::disc(0.5), {0, 0.5}, 1, inertia_share * 0.25)};
    worlds::set_material(scene, 0.5, 0);
    worlds::lean(scene, 20);
    return scene;
  };
  const double acceleration = 10 * std::sin(20 * pi / 180) / (1 + inertia_share);
  problem.scale = 2 * acceleration;
  problem.observe = x_of_second;
  problem.exact = [acceleration](double t) { return std::vector<double>{acceleration * t * t / 2}; };
  problem.slope = 1;
  problem.slope_of_higher = 2;  // a known friction is a constant force
  problem.bars = {{"tgs_soft", "4 sub", 0.005}};
  return problem;
}

// A belt accelerates the body at mu g = 5 m/s^2 until the body moves at 2 m/s.
Problem conveyor() {
  Problem problem =
      of_contacts(ProblemClass::friction, "conveyor", "a box at rest on a belt of 2 m/s, friction 0.5, 1 s", 1);
  problem.scale = 1.6;
  problem.scene = [](Precision precision) {
    Scene scene = slide_scene(precision, 0, 0.5);
    scene.bodies[0].shapes[0].material.tangent_speed = -2;  // clockwise: the top runs to the right
    return scene;
  };
  problem.observe = x_of_second;
  problem.exact = [](double t) { return std::vector<double>{t < 0.4 ? 2.5 * t * t : 2 * t - 0.4}; };
  problem.slope = 1;
  problem.slope_of_higher = 2;  // a known friction is a constant force
  return problem;
}

// Rolling resistance decelerates the disc at 2/3 c g.
Problem rolling_resistance() {
  Problem problem = of_contacts(ProblemClass::friction, "rolling_resistance",
                                "a disc rolls at 4 m/s, rolling resistance 0.3, stops after 4 m", 3);
  problem.scale = 4;
  problem.scene = [](Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies = {worlds::ground(), worlds::weighted(worlds::disc(0.5), {0, 0.5}, 1, 0.125)};
    worlds::set_material(scene, 1, 0);
    scene.bodies[1].shapes[0].material.rolling_resistance = 0.3;
    scene.bodies[1].velocity = {4, 0};
    scene.bodies[1].angular_velocity = -8;
    return scene;
  };
  problem.observe = x_of_second;
  problem.exact = [](double t) { return std::vector<double>{t < 2 ? 4 * t - t * t : 4}; };
  problem.slope = 1;
  return problem;
}

// ---- Rest ----

double force_under(const Engine& engine, std::uint32_t body) {
  double force = 0;
  for (const ContactReport& contact : engine.contacts()) {
    if (contact.body_a != body && contact.body_b != body) continue;
    const double up = contact.body_b == body ? contact.normal.y : -contact.normal.y;
    if (up <= 0) continue;
    for (int i = 0; i < contact.point_count; ++i) force += up * contact.normal_force[i];
  }
  return force;
}

Problem stack_forces() {
  Problem problem =
      of_contacts(ProblemClass::rest, "stack_forces", "a stack of 10 boxes, 10 s: the force under each", 10);
  problem.sample_count = 1;
  problem.scale = 100;
  problem.why_no_slope = "the forces settle: what is left after 10 s is damped motion, no error of a step";
  problem.size = 0;
  problem.bars = {{"tgs_soft", "4 sub", 0.001}};
  problem.scene = [](Precision precision) { return worlds::stack(precision, 10); };
  problem.observe = [](const Engine& engine) {
    std::vector<double> forces;
    for (std::uint32_t i = 1; i <= 10; ++i) forces.push_back(force_under(engine, i));
    return forces;
  };
  problem.exact = [](double) {
    std::vector<double> forces;
    for (int i = 1; i <= 10; ++i) forces.push_back(10.0 * (11 - i));
    return forces;
  };
  return problem;
}

Problem stack_height(std::string name, int count, double top_mass, double limit) {
  Problem problem = of_contacts(ProblemClass::rest, std::move(name),
                                "a stack of " + std::to_string(count) + " boxes of 1 m" +
                                    (top_mass > 1 ? ", the top one of 100 kg" : "") + ", 10 s: height of the top",
                                10);
  problem.sample_count = 1;
  problem.reference = "geometry";
  problem.scene = [count, top_mass](Precision precision) {
    Scene scene = worlds::stack(precision, count);
    if (top_mass > 1) scene.bodies.back().mass = engine::ExplicitMass{top_mass, {}, {}};
    return scene;
  };
  problem.observe = [](const Engine& engine) { return std::vector<double>{engine.bodies().back().center.y}; };
  problem.exact = [count](double) { return std::vector<double>{count - 0.5}; };
  problem.slope = 2;
  problem.bars = {{"tgs_soft", "4 sub", limit}};
  if (count > 10) problem.substeps_max = 256;  // high stacks show their order only at fine steps
  return problem;
}

// ---- A disc and polygons ----

std::string corners_name(int n) {
  return n == 0 ? "disc" : std::to_string(n) + "-gon";
}

engine::Shape shape_of(int n) {
  return n == 0 ? worlds::disc(0.5) : worlds::regular(n, 0.5);
}

double height_of(int n) {
  return n == 0 ? 0.5 : worlds::apothem(n, 0.5);
}

Problem family(ProblemClass kind, int n, std::string summary, double duration) {
  Problem problem = of_contacts(kind,
                                std::string(problem_class_names[static_cast<std::size_t>(kind)]) + "_" +
                                    (n == 0 ? "disc" : std::to_string(n) + "gon"),
                                corners_name(n) + " " + summary, duration);
  problem.corner_count = n;
  return problem;
}

Problem family_slide(int n) {
  Problem problem = family(ProblemClass::slide, n, "at 10 m/s, friction 0.5, stops after 10 m", 3);
  problem.scale = 10;
  problem.slope = 1;
  problem.scene = [n](Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies = {worlds::ground(), worlds::weighted(shape_of(n), {0, height_of(n)}, 1)};
    scene.bodies[1].velocity = {10, 0};
    scene.bodies[1].fixed_rotation = true;  // so that every shape slides
    worlds::set_material(scene, 0.5, 0);
    return scene;
  };
  problem.observe = x_of_second;
  problem.exact = [](double t) { return std::vector<double>{slid(t)}; };
  return problem;
}

// A polygon starts on a flat side and turns about its right corner. A disc starts to roll at the same spin.
Problem family_roll(int n) {
  Problem problem = family(ProblemClass::roll, n, "rolls over a level floor: angle", 2);
  problem.is_angle = true;
  problem.size = 0;
  problem.scale = 1;
  problem.why_no_slope = "corners land between the steps, and each landing shifts all that follows";
  if (n == 0) problem.why_no_slope = "within a tick the contact's point turns with the disc";
  problem.reference = n == 0 ? "closed form" : "long double integration (reference_numbers.h)";
  problem.scene = [n](Precision precision) {
    Scene scene = worlds::empty(precision);
    const double height = height_of(n);
    scene.bodies = {worlds::ground(), worlds::weighted(shape_of(n), {0, height}, 1)};
    const double half_side = n == 0 ? 0 : 0.5 * engine::sin_cos(pi / n).sin;
    scene.bodies[1].angular_velocity = -rolling_spin;
    scene.bodies[1].velocity = {rolling_spin * height, rolling_spin * half_side};
    worlds::set_material(scene, 5, 0);
    return scene;
  };
  problem.observe = [](const Engine& engine) { return std::vector<double>{-engine.bodies()[1].angle}; };
  problem.exact = [n](double t) {
    if (n == 0) return std::vector<double>{rolling_spin * t};
    return std::vector<double>{rolled_angle[n - 3][static_cast<int>(std::lround(t * 10)) - 1]};
  };
  return problem;
}

Problem family_stack(int n) {
  Problem problem = family(ProblemClass::stack, n, "five upon each other, 10 s: height of the top", 10);
  problem.sample_count = 1;
  problem.scale = 1;
  problem.slope = 2;
  problem.scene = [n](Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies.push_back(worlds::ground());
    for (int i = 0; i < 5; ++i)
      scene.bodies.push_back(worlds::weighted(shape_of(n), {0, height_of(n) * (2 * i + 1)}, 1));
    return scene;
  };
  problem.observe = [](const Engine& engine) { return std::vector<double>{engine.bodies().back().center.y}; };
  problem.exact = [n](double) { return std::vector<double>{9 * height_of(n)}; };
  return problem;
}

Problem family_bounce(int n) {
  Problem problem = family(ProblemClass::bounce, n, "falls 1 m and bounces with restitution 0.8: height", 2);
  problem.scale = 1;
  problem.slope = 1;
  problem.scene = [n](Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies = {worlds::ground(), worlds::weighted(shape_of(n), {0, 1 + height_of(n)}, 1)};
    worlds::set_bounces(scene, 0.8);
    return scene;
  };
  problem.observe = [n](const Engine& engine) {
    return std::vector<double>{engine.bodies()[1].center.y - height_of(n)};
  };
  problem.exact = [](double t) { return std::vector<double>{bouncing_height(1, 0.8, t)}; };
  return problem;
}

}  // namespace

std::vector<Problem> contact_problems() {
  return {bounce("bounce", 1, 0.8, 2),
          bounce("elastic", 10, 1, 10),
          collision("collision_elastic", 1),
          collision("collision_half", 0.5),
          cradle(),
          billiards(),
          slide(),
          slip(),
          rolling("rolling_disc", 0.5),
          rolling("rolling_ring", 1),
          conveyor(),
          rolling_resistance(),
          stack_forces(),
          stack_height("stack_10", 10, 1, 0.04),
          stack_height("stack_40", 40, 1, 0),
          stack_height("stack_ratio_100", 10, 100, 0)};
}

std::vector<Problem> shape_problems() {
  std::vector<Problem> problems;
  for (Problem (*make)(int) : {family_roll, family_slide, family_stack, family_bounce})
    for (int n = 0; n <= 16; ++n) {
      if (n == 1 || n == 2) continue;
      if (make == family_stack && n % 2 == 1)
        continue;  // a polygon with an odd number of corners has a corner at the top: no body can rest on it
      problems.push_back(make(n));
    }
  return problems;
}

}  // namespace ticktrue::tool
