// The rules of a valid scene: every rule of check_scene, and the rules of collision.
// SPDX-License-Identifier: MIT
#include "engine/scene/scene.h"

#include <cmath>
#include <functional>
#include <limits>

#include "base/limits.h"
#include "engine/engine.h"
#include "engine/scene/scene_binary.h"
#include "tests/support/catch.h"
#include "tests/support/scenes.h"

using namespace ticktrue;
using namespace ticktrue::engine;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

Shape circle() {
  Shape shape;
  shape.radius = 0.5;
  return shape;
}

Shape square() {
  Shape shape;
  shape.kind = ShapeKind::polygon;
  shape.vertices = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  return shape;
}

Shape box() {
  Shape shape;
  shape.kind = ShapeKind::box;
  shape.half_size = {1, 2};
  return shape;
}

/// A scene that uses every feature.
Scene whole_scene() {
  Scene scene;
  scene.name = "whole";
  for (int i = 0; i < 4; ++i) {
    Body body;
    body.name = "body_" + std::to_string(i);
    body.position = {1.0 * i, 0.5};
    body.shapes = {circle(), square(), box()};
    scene.bodies.push_back(body);
  }
  scene.bodies[0].type = BodyType::static_body;
  scene.bodies[1].type = BodyType::kinematic_body;
  scene.bodies[1].velocity = {1, 0};
  scene.bodies[2].mass = ExplicitMass{3, 2.0, Point{0.1, 0.2}};
  Body prototype;
  prototype.name = "ball";
  prototype.shapes = {circle()};
  scene.prototypes = {prototype};
  scene.inputs = {InputKind::spawn, InputKind::impulse, InputKind::press, InputKind::drag, InputKind::release};
  scene.pointer.emplace();
  scene.pointer->spawns = {"ball"};
  scene.pointer->window = Bounds{{-5, -5}, {5, 5}};
  scene.bounds = Bounds{{-100, -100}, {100, 100}};
  scene.spawned_max = 7;
  return scene;
}

Error refusal(const std::function<void(Scene&)>& spoil) {
  Scene scene = whole_scene();
  spoil(scene);
  const Status status = check_scene(scene, "x.json");
  if (status) return Error{ErrorCode::io, "accepted", ""};
  return status.error();
}

constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("a scene that keeps every rule is accepted", "[engine][scene][analytic]") {
  const Status status = check_scene(whole_scene(), "x.json");
  CHECK(status);
  CHECK(refusal([](Scene&) {}).message == "accepted");
  CHECK(check_scene(test::everything_scene(), "x.json"));
}

TEST_CASE("each number of a scene is refused when it is not finite or beyond its limits", "[engine][scene][analytic]") {
  struct Case {
    const char* place;
    std::function<double&(Scene&)> field;
    bool zero_is_bad;
    bool negative_is_bad;
  };
  const std::vector<Case> cases{
      {"settings.dt", [](Scene& s) -> double& { return s.settings.dt; }, true, true},
      {"settings.restitution_threshold", [](Scene& s) -> double& { return s.settings.restitution_threshold; }, false,
       true},
      {"gravity[0]", [](Scene& s) -> double& { return s.gravity.x; }, false, false},
      {"gravity[1]", [](Scene& s) -> double& { return s.gravity.y; }, false, false},
      {"bodies[3].position[0]", [](Scene& s) -> double& { return s.bodies[3].position.x; }, false, false},
      {"bodies[3].angle", [](Scene& s) -> double& { return s.bodies[3].angle; }, false, false},
      {"bodies[3].velocity[1]", [](Scene& s) -> double& { return s.bodies[3].velocity.y; }, false, false},
      {"bodies[3].angular_velocity", [](Scene& s) -> double& { return s.bodies[3].angular_velocity; }, false, false},
      {"bodies[3].linear_damping", [](Scene& s) -> double& { return s.bodies[3].linear_damping; }, false, true},
      {"bodies[3].angular_damping", [](Scene& s) -> double& { return s.bodies[3].angular_damping; }, false, true},
      {"bodies[3].gravity_scale", [](Scene& s) -> double& { return s.bodies[3].gravity_scale; }, false, false},
      {"bodies[2].mass", [](Scene& s) -> double& { return s.bodies[2].mass->mass; }, true, true},
      {"bodies[2].inertia", [](Scene& s) -> double& { return *s.bodies[2].mass->inertia; }, true, true},
      {"bodies[2].center_of_mass[0]", [](Scene& s) -> double& { return s.bodies[2].mass->center->x; }, false, false},
      {"bodies[3].shapes[0].radius", [](Scene& s) -> double& { return s.bodies[3].shapes[0].radius; }, true, true},
      {"bodies[3].shapes[0].center[0]", [](Scene& s) -> double& { return s.bodies[3].shapes[0].center.x; }, false,
       false},
      {"bodies[3].shapes[1].vertices[2][1]", [](Scene& s) -> double& { return s.bodies[3].shapes[1].vertices[2].y; },
       false, false},
      {"bodies[3].shapes[2].half_size[0]", [](Scene& s) -> double& { return s.bodies[3].shapes[2].half_size.x; }, true,
       true},
      {"bodies[3].shapes[2].half_size[1]", [](Scene& s) -> double& { return s.bodies[3].shapes[2].half_size.y; }, true,
       true},
      {"bodies[3].shapes[2].angle", [](Scene& s) -> double& { return s.bodies[3].shapes[2].angle; }, false, false},
      {"bodies[3].shapes[0].density", [](Scene& s) -> double& { return s.bodies[3].shapes[0].density; }, true, true},
      {"bodies[3].shapes[0].friction", [](Scene& s) -> double& { return s.bodies[3].shapes[0].material.friction; },
       false, true},
      {"bodies[3].shapes[0].restitution",
       [](Scene& s) -> double& { return s.bodies[3].shapes[0].material.restitution; }, false, true},
      {"prototypes[0].shapes[0].radius", [](Scene& s) -> double& { return s.prototypes[0].shapes[0].radius; }, true,
       true},
      {"pointer.hertz", [](Scene& s) -> double& { return s.pointer->hertz; }, true, true},
      {"pointer.damping_ratio", [](Scene& s) -> double& { return s.pointer->damping_ratio; }, false, true},
      {"pointer.force_max_per_kg", [](Scene& s) -> double& { return s.pointer->force_max_per_kg; }, true, true},
      {"pointer.window.lower[0]", [](Scene& s) -> double& { return s.pointer->window->lower.x; }, false, false},
      {"bounds.lower[1]", [](Scene& s) -> double& { return s.bounds->lower.y; }, false, false},
      {"bounds.upper[0]", [](Scene& s) -> double& { return s.bounds->upper.x; }, false, false},
  };
  for (const Case& c : cases) {
    CAPTURE(c.place);
    const auto message_for = [&](double value) { return refusal([&](Scene& s) { c.field(s) = value; }).message; };
    for (const double value : {std::nan(""), infinity, -infinity}) {
      CHECK_THAT(message_for(value), StartsWith(std::string("x.json: ") + c.place + ": must be finite: found "));
      CHECK(refusal([&](Scene& s) { c.field(s) = value; }).code == ErrorCode::invalid_scene);
    }
    CHECK_THAT(message_for(1e300),
               StartsWith(std::string("x.json: ") + c.place + ": out of range: found 1e+300, expected "));
    if (c.zero_is_bad)
      CHECK_THAT(message_for(0), StartsWith(std::string("x.json: ") + c.place + ": must be > 0: found 0, expected "));
    if (c.negative_is_bad) CHECK_THAT(message_for(-1), Contains(": found -1, expected "));
  }
  CHECK(refusal([](Scene& s) { s.bodies[3].shapes[0].radius = -1; }).message ==
        "x.json: bodies[3].shapes[0].radius: must be > 0: found -1, expected 1e-06..1e+06");
}

TEST_CASE("scenes are refused for what no single number shows", "[engine][scene][analytic]") {
  struct Case {
    const char* message;
    std::function<void(Scene&)> spoil;
    ErrorCode code = ErrorCode::invalid_scene;
  };
  const std::vector<Case> cases{
      {"x.json: bodies: nothing to simulate", [](Scene& s) { s = Scene{}; }},
      {"x.json: name: too long: found 257 bytes, expected at most 256", [](Scene& s) { s.name.assign(257, 'x'); },
       ErrorCode::limit},
      {"x.json: bodies[1].name: must be UTF-8 without control characters", [](Scene& s) { s.bodies[1].name = "a\nb"; }},
      {"x.json: bodies[1].name: must be UTF-8 without control characters",
       [](Scene& s) { s.bodies[1].name = "\xc0\xaf"; }},
      {"x.json: bodies[3].name: must be unique: found \"body_1\", which bodies[1] has already",
       [](Scene& s) { s.bodies[3].name = "body_1"; }},
      {"x.json: prototypes[0].name: a prototype needs a name", [](Scene& s) { s.prototypes[0].name = ""; }},
      {"x.json: prototypes[0].position: is the input's to give", [](Scene& s) { s.prototypes[0].position.x = 1; }},
      {"x.json: prototypes[0].velocity: is the input's to give", [](Scene& s) { s.prototypes[0].velocity.x = 1; }},
      {"x.json: settings.substeps: out of range: found 257, expected 1..256",
       [](Scene& s) { s.settings.substeps = 257; }},
      {"x.json: settings.substeps: must be > 0: found 0, expected 1..256", [](Scene& s) { s.settings.substeps = 0; }},
      {"x.json: settings.solver: unknown: found number 9, expected free_flight, impulse, tgs_soft or pgs",
       [](Scene& s) { s.settings.solver = static_cast<SolverKind>(9); }},
      {"x.json: bodies[0].velocity: a static body never moves", [](Scene& s) { s.bodies[0].velocity.y = 1; }},
      {"x.json: bodies[0].angular_velocity: a static body never moves",
       [](Scene& s) { s.bodies[0].angular_velocity = 1; }},
      {"x.json: bodies[0].mass: only dynamic bodies have a mass: found 1 kg of a static body",
       [](Scene& s) { s.bodies[0].mass.emplace(); }},
      {"x.json: bodies[1].mass: only dynamic bodies have a mass: found 1 kg of a kinematic body",
       [](Scene& s) { s.bodies[1].mass.emplace(); }},
      {"x.json: bodies[3].shapes: a body needs a shape: found none", [](Scene& s) { s.bodies[3].shapes.clear(); }},
      {"x.json: bodies[3].shapes: too many: found 1025, expected at most 1024",
       [](Scene& s) { s.bodies[3].shapes.assign(1025, circle()); }, ErrorCode::limit},
      {"x.json: bodies[3].shapes[0].half_size: a circle has none",
       [](Scene& s) { s.bodies[3].shapes[0].half_size.x = 1; }},
      {"x.json: bodies[3].shapes[2].vertices: a box has none",
       [](Scene& s) {
         s.bodies[3].shapes[2].vertices = {{0, 0}};
       }},
      {"x.json: bodies[3].shapes[1].vertices: wrong number of vertices: found 2, expected 3..16",
       [](Scene& s) { s.bodies[3].shapes[1].vertices.resize(2); }},
      {"x.json: bodies[3].shapes[1].vertices: wrong number of vertices: found 17, expected 3..16",
       [](Scene& s) { s.bodies[3].shapes[1].vertices.resize(17); }},
      {"x.json: bodies[3].shapes[1].vertices: vertices 0 and 3 coincide",
       [](Scene& s) {
         s.bodies[3].shapes[1].vertices[3] = {0, 0};
       }},
      {"x.json: bodies[3].shapes[1].vertices: concave: found vertex 3 (0.6, 0.5)",
       [](Scene& s) {
         s.bodies[3].shapes[1].vertices[3] = {0.6, 0.5};
       }},
      {"x.json: bodies[3].shapes[1].vertices: all vertices lie on one line",
       [](Scene& s) {
         s.bodies[3].shapes[1].vertices = {{0, 0}, {1, 1}, {2, 2}};
       }},
      {"x.json: bodies[3].shapes[1].vertices: too small: found an extent of 1e-07 m",
       [](Scene& s) {
         s.bodies[3].shapes[1].vertices = {{0, 0}, {1e-7, 0}, {0, 1e-7}};
       }},
      {"x.json: bodies[3]: mass of its shapes out of range: found 3.14159",
       [](Scene& s) {
         s.bodies[3].shapes = {circle()};
         s.bodies[3].shapes[0].radius = 1e6;
         s.bodies[3].shapes[0].density = 1e6;
       }},
      {"x.json: inputs[1]: out of order: found spawn after impulse",
       [](Scene& s) { std::swap(s.inputs[0], s.inputs[1]); }},
      {"x.json: inputs[1]: declared twice: found spawn after spawn", [](Scene& s) { s.inputs[1] = InputKind::spawn; }},
      {"x.json: inputs[0]: unknown: found number 77", [](Scene& s) { s.inputs[0] = static_cast<InputKind>(77); }},
      {"x.json: inputs: a pointer presses, drags and releases: found no drag",
       [](Scene& s) {
         s.inputs = {InputKind::press, InputKind::release};
       }},
      {"x.json: pointer: missing: found press among the inputs", [](Scene& s) { s.pointer.reset(); }},
      {"x.json: inputs: spawn is declared, but there is nothing to spawn",
       [](Scene& s) {
         s.prototypes.clear();
         s.pointer->spawns.clear();
       }},
      {"x.json: pointer.spawns[0]: no prototype has this name: found \"bull\", expected one of ball",
       [](Scene& s) { s.pointer->spawns = {"bull"}; }},
      {"x.json: bounds.upper[0]: must be above lower: found -100, expected more than -100",
       [](Scene& s) { s.bounds->upper.x = -100; }},
      {"x.json: pointer.window.upper[1]: must be above lower", [](Scene& s) { s.pointer->window->upper.y = -9; }},
      {"x.json: spawned_max: must be > 0: found 0", [](Scene& s) { s.spawned_max = 0; }},
      {"x.json: settings.substeps: impulse does not substep: found 4, expected 1",
       [](Scene& s) { s.settings.solver = SolverKind::impulse; }, ErrorCode::incompatible},
      {"x.json: settings.solver: free_flight solves no contacts and moves nothing by a pointer: found bodies that may "
       "collide",
       [](Scene& s) { s.settings.solver = SolverKind::free_flight; }, ErrorCode::incompatible},
  };
  for (const Case& c : cases) {
    const Error error = refusal(c.spoil);
    CHECK_THAT(error.message, StartsWith(c.message));
    CHECK(error.code == c.code);
  }
  CHECK(refusal([](Scene& s) { s.settings.solver = SolverKind::free_flight; }).hint == "use impulse, tgs_soft or pgs");
}

TEST_CASE("joints, forces, lines and clocks that break a rule are refused with their place",
          "[engine][scene][analytic]") {
  struct Case {
    const char* message;
    std::function<void(Scene&)> spoil;
    ErrorCode code = ErrorCode::invalid_scene;
  };
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  // Joints and forces are in the order of their kinds. The shapes of body 0 are circle, box, polygon, capsule, segment,
  // chain.
  const std::vector<Case> cases{
      {"x.json: joints: too many: found 200001, expected at most 200000", [](Scene& s) { s.joints.resize(200'001); },
       ErrorCode::limit},
      {"x.json: forces: too many: found 4097, expected at most 4096", [](Scene& s) { s.forces.resize(4'097); },
       ErrorCode::limit},
      {"x.json: joints[0].type: unknown: found number 10, expected revolute, prismatic, ",
       [](Scene& s) { s.joints[0].kind = static_cast<JointKind>(10); }},
      {"x.json: joints[1].name: must be unique: found \"the revolute\", which joints[0] has already",
       [](Scene& s) { s.joints[1].name = "the revolute"; }},
      {"x.json: joints[1].name: must be UTF-8", [](Scene& s) { s.joints[1].name = "\x01"; }},
      {"x.json: joints[0].body_a: no body has this index: found 4, expected 0..3",
       [](Scene& s) { s.joints[0].body_a = 4; }},
      {"x.json: joints[7].body_b: no body has this index: found 4", [](Scene& s) { s.joints[7].body_b = 4; }},
      {"x.json: joints[0].body_b: joins a body with itself: found body 2 twice",
       [](Scene& s) { s.joints[0].body_a = 2; }},
      {"x.json: joints[0].body_b: one of the two bodies must be dynamic: found a static and a kinematic body",
       [](Scene& s) { s.bodies[2].type = BodyType::kinematic_body; }},
      {"x.json: joints[7].body_b: must be dynamic: found a static body", [](Scene& s) { s.joints[7].body_b = 1; }},
      {"x.json: joints[7].body_a: a target joint has none", [](Scene& s) { s.joints[7].body_a = 1; }},
      {"x.json: joints[0].axis: a revolute joint has none",
       [](Scene& s) {
         s.joints[0].axis = {0, 1};
       }},
      {"x.json: joints[5].anchor_b: a motor joint has none",
       [](Scene& s) {
         s.joints[5].anchor_b = {0, 1};
       }},
      {"x.json: joints[0].length: a revolute joint has none", [](Scene& s) { s.joints[0].length = 2; }},
      {"x.json: joints[3].motor: a weld joint has none", [](Scene& s) { s.joints[3].motor.emplace(); }},
      {"x.json: joints[6].spring: a friction joint has none", [](Scene& s) { s.joints[6].spring.emplace(); }},
      {"x.json: joints[0].linear_spring: a revolute joint has none",
       [](Scene& s) { s.joints[0].linear_spring.emplace(); }},
      {"x.json: joints[0].torque_max: a revolute joint has none", [](Scene& s) { s.joints[0].torque_max = 1; }},
      {"x.json: joints[7].collide_connected: a target joint has none",
       [](Scene& s) { s.joints[7].collide_connected = true; }},
      {"x.json: joints[0].anchor_a[1]: must be finite: found ", [=](Scene& s) { s.joints[0].anchor_a.y = nan; }},
      {"x.json: joints[1].axis: has no direction: found (0, 0), expected a length of at least 1e-06",
       [](Scene& s) {
         s.joints[1].axis = {0, 0};
       }},
      {"x.json: joints[4].axis[0]: must be finite: found ",
       [=](Scene& s) {
         s.joints[4].axis = {nan, 0};
       }},
      {"x.json: joints[0].reference_angle: out of range: found 2e+06",
       [](Scene& s) { s.joints[0].reference_angle = 2e6; }},
      {"x.json: joints[2].length: must be > 0: found 0, expected 1e-06..1e+07",
       [](Scene& s) {
         s.joints[2].length = 0;
         s.joints[2].spring.reset();
       }},
      {"x.json: joints[2].length: must be >= 0: found -1", [](Scene& s) { s.joints[2].length = -1; }},
      {"x.json: joints[0].limits: lower is above upper: found [1, 0.5], expected [lower, upper]",
       [](Scene& s) {
         s.joints[0].limits = Range{1, 0.5};
       }},
      {"x.json: joints[0].limits[1]: out of range: found 2e+06, expected -1e+06..1e+06",
       [](Scene& s) { s.joints[0].limits->upper = 2e6; }},
      {"x.json: joints[2].limits[0]: must be >= 0: found -1", [](Scene& s) { s.joints[2].limits->lower = -1; }},
      {"x.json: joints[1].limits[0]: must be finite", [=](Scene& s) { s.joints[1].limits->lower = nan; }},
      {"x.json: joints[0].motor.force_max: must be >= 0: found -1",
       [](Scene& s) { s.joints[0].motor->force_max = -1; }},
      {"x.json: joints[0].motor.speed: out of range: found 2e+09", [](Scene& s) { s.joints[0].motor->speed = 2e9; }},
      {"x.json: joints[0].spring.hertz: must be >= 0: found -1", [](Scene& s) { s.joints[0].spring->hertz = -1; }},
      {"x.json: joints[0].spring.damping_ratio: must be finite",
       [=](Scene& s) { s.joints[0].spring->damping_ratio = nan; }},
      {"x.json: joints[0].spring: must be one of two forms", [](Scene& s) { s.joints[0].spring->stiffness = 1; }},
      {"x.json: joints[3].linear_spring.stiffness: must be >= 0: found -1",
       [](Scene& s) { s.joints[3].linear_spring->stiffness = -1; }},
      {"x.json: joints[3].linear_spring.damping: must be finite",
       [=](Scene& s) { s.joints[3].linear_spring->damping = nan; }},
      {"x.json: joints[7].point[0]: must be finite", [=](Scene& s) { s.joints[7].offset.x = nan; }},
      {"x.json: joints[5].offset[1]: out of range: found 2e+07", [](Scene& s) { s.joints[5].offset.y = 2e7; }},
      {"x.json: joints[5].angle_offset: out of range", [](Scene& s) { s.joints[5].angle_offset = 2e6; }},
      {"x.json: joints[6].force_max: must be >= 0: found -1", [](Scene& s) { s.joints[6].force_max = -1; }},
      {"x.json: joints[6].torque_max: must be >= 0: found -1", [](Scene& s) { s.joints[6].torque_max = -1; }},

      {"x.json: forces[0].type: unknown: found number 9",
       [](Scene& s) { s.forces[0].kind = static_cast<ForceKind>(9); }},
      {"x.json: forces[1].name: must be unique: found \"constant\", which forces[0] has already",
       [](Scene& s) { s.forces[1].name = "constant"; }},
      {"x.json: forces[0].body: no body has this index: found 4, expected 0..3",
       [](Scene& s) { s.forces[0].body = 4; }},
      {"x.json: forces[2].other: no body has this index: found 4", [](Scene& s) { s.forces[2].other = 4; }},
      {"x.json: forces[2].other: joins a body with itself: found body 3 twice",
       [](Scene& s) { s.forces[2].other = 3; }},
      {"x.json: forces[2].body: missing: a spring needs a body", [](Scene& s) { s.forces[2].body.reset(); }},
      {"x.json: forces[0].body: must be dynamic: found a static body", [](Scene& s) { s.forces[0].body = 1; }},
      {"x.json: forces[3].body: a wind force has none", [](Scene& s) { s.forces[3].body = 3; }},
      {"x.json: forces[0].stiffness: a constant force has none", [](Scene& s) { s.forces[0].stiffness = 1; }},
      {"x.json: forces[4].exponent: a linear_drag force has none", [](Scene& s) { s.forces[4].exponent = 1; }},
      {"x.json: forces[0].force[0]: must be finite", [=](Scene& s) { s.forces[0].vector.x = nan; }},
      {"x.json: forces[3].velocity[1]: out of range: found 2e+09", [](Scene& s) { s.forces[3].vector.y = 2e9; }},
      {"x.json: forces[1].center[1]: must be finite", [=](Scene& s) { s.forces[1].point.y = nan; }},
      {"x.json: forces[1].exponent: must be whole: found 0.5, expected -3, -2, ... or 3",
       [](Scene& s) { s.forces[1].exponent = 0.5; }},
      {"x.json: forces[1].exponent: out of range: found 4, expected -3..3", [](Scene& s) { s.forces[1].exponent = 4; }},
      {"x.json: forces[2].stiffness: must be >= 0: found -1", [](Scene& s) { s.forces[2].stiffness = -1; }},
      {"x.json: forces[2].damping: must be >= 0: found -1", [](Scene& s) { s.forces[2].damping = -1; }},
      {"x.json: forces[2].rest_length: must be >= 0: found -1", [](Scene& s) { s.forces[2].rest_length = -1; }},
      {"x.json: forces[4].coefficient: must be >= 0: found -1", [](Scene& s) { s.forces[4].coefficient = -1; }},
      {"x.json: forces[5].angular_coefficient: must be >= 0", [](Scene& s) { s.forces[5].angular_coefficient = -1; }},

      {"x.json: bodies[0].shapes[1].radius: must be >= 0: found -1",
       [](Scene& s) { s.bodies[0].shapes[1].radius = -1; }},
      {"x.json: bodies[0].shapes[3].radius: must be > 0: found 0", [](Scene& s) { s.bodies[0].shapes[3].radius = 0; }},
      {"x.json: bodies[0].shapes[4].radius: a segment has none", [](Scene& s) { s.bodies[0].shapes[4].radius = 1; }},
      {"x.json: bodies[0].shapes[4].loop: a segment has none", [](Scene& s) { s.bodies[0].shapes[4].loop = true; }},
      {"x.json: bodies[0].shapes[3].center: a capsule has none", [](Scene& s) { s.bodies[0].shapes[3].center.x = 1; }},
      {"x.json: bodies[0].shapes[3].points: wrong number of points: found 3, expected 2",
       [](Scene& s) {
         s.bodies[0].shapes[3].vertices.push_back({5, 5});
       }},
      {"x.json: bodies[0].shapes[4].points: points 0 and 1 coincide: found less than 1e-06 m between them",
       [](Scene& s) { s.bodies[0].shapes[4].vertices[1] = s.bodies[0].shapes[4].vertices[0]; }},
      {"x.json: bodies[0].shapes[4].points[1][0]: must be finite",
       [=](Scene& s) { s.bodies[0].shapes[4].vertices[1].x = nan; }},
      {"x.json: bodies[0].shapes[5].points: wrong number of points: found 2, expected at least 3 of a loop",
       [](Scene& s) { s.bodies[0].shapes[5].vertices.pop_back(); }},
      {"x.json: bodies[0].shapes[5].points: wrong number of points: found 1, expected at least 2",
       [](Scene& s) {
         s.bodies[0].shapes[5].loop = false;
         s.bodies[0].shapes[5].vertices.resize(1);
       }},
      {"x.json: bodies[0].shapes[5].points: wrong number of points: found 16385, expected at most 16384",
       [](Scene& s) { s.bodies[0].shapes[5].vertices.resize(16'385); }, ErrorCode::limit},
      {"x.json: bodies[0].shapes[5].points: points 3 and 0 coincide",
       [](Scene& s) { s.bodies[0].shapes[5].vertices.push_back(s.bodies[0].shapes[5].vertices[0]); }},
      {"x.json: bodies[0].shapes[0].tangent_speed: must be finite",
       [=](Scene& s) { s.bodies[0].shapes[0].material.tangent_speed = nan; }},
      {"x.json: bodies[0].shapes[0].rolling_resistance: must be >= 0: found -1",
       [](Scene& s) { s.bodies[0].shapes[0].material.rolling_resistance = -1; }},
      {"x.json: bodies[2].mass: missing: found shapes without area only, expected a stated mass",
       [](Scene& s) { s.bodies[2].shapes = {s.bodies[0].shapes[5]}; }},
      {"x.json: bodies[2].inertia: missing: found shapes without area only, expected a stated inertia",
       [](Scene& s) {
         s.bodies[2].shapes = {s.bodies[0].shapes[4]};
         s.bodies[2].mass.emplace();
       }},

      {"x.json: settings.iterations: out of range: found 1001, expected 1..1000",
       [](Scene& s) { s.settings.iterations = 1001; }},
      {"x.json: settings.substeps.target_error: out of range: found 1e-07, expected 1e-06..0.1",
       [](Scene& s) { s.settings.auto_substeps->target_error = 1e-7; }},
      {"x.json: settings.substeps.most: must be a power of two: found 48",
       [](Scene& s) { s.settings.auto_substeps->substeps_max = 48; }},
      {"x.json: settings.substeps.most: out of range: found 512, expected 1..256",
       [](Scene& s) { s.settings.auto_substeps->substeps_max = 512; }},
      {"x.json: settings.substeps.least: must not be above most: found 65, expected at most 64",
       [](Scene& s) { s.settings.substeps = 65; }},
      {"x.json: settings.sleep.after: must be >= 0: found -1", [](Scene& s) { s.settings.sleep->after_s = -1; }},
      {"x.json: settings.sleep.speed_max: must be finite", [=](Scene& s) { s.settings.sleep->speed_max = nan; }},
      {"x.json: settings.clock: unknown: found number 9, expected fixed, ",
       [](Scene& s) { s.settings.clock.kind = static_cast<ClockKind>(9); }},
      {"x.json: settings.clock.tolerance: out of range: found 2, expected 1e-12..1",
       [](Scene& s) { s.settings.clock.tolerance = 2; }},
      {"x.json: settings.clock.dt_min: must be > 0: found 0", [](Scene& s) { s.settings.clock.dt_min = 0; }},
      {"x.json: settings.clock.dt_min: must not be above dt_max: found 0.5, expected at most 0.2",
       [](Scene& s) { s.settings.clock.dt_min = 0.5; }},
      {"x.json: settings.clock.dt_max: out of range: found 2", [](Scene& s) { s.settings.clock.dt_max = 2; }},
      {"x.json: settings.clock.ticks_per_frame_max: a clock of kind adaptive has none",
       [](Scene& s) { s.settings.clock.ticks_per_frame_max = 6; }},
      {"x.json: settings.clock.ticks_per_frame_max: out of range: found 1001, expected 1..1000",
       [](Scene& s) {
         s.settings.clock = ClockSettings{};
         s.settings.clock.kind = ClockKind::semi_fixed;
         s.settings.clock.ticks_per_frame_max = 1001;
       }},
      {"x.json: settings.clock.tolerance: a clock of kind fixed has none",
       [](Scene& s) { s.settings.clock.kind = ClockKind::fixed; }},

      {"x.json: inputs: set_motor is declared, but there is no motor to set: found no joint with one",
       [](Scene& s) {
         for (Joint& joint : s.joints) joint.motor.reset();
       }},
      {"x.json: settings.substeps: impulse does not substep: found auto, expected 1",
       [](Scene& s) {
         s.settings.solver = SolverKind::impulse;
         s.settings.substeps = 1;
       },
       ErrorCode::incompatible},
      {"x.json: settings.sleep: impulse has no islands: found sleep",
       [](Scene& s) {
         s.settings.solver = SolverKind::impulse;
         s.settings.substeps = 1;
         s.settings.auto_substeps.reset();
       },
       ErrorCode::incompatible},
      {"x.json: settings.events: impulse reports no contacts: found true, expected false",
       [](Scene& s) {
         s.settings.sleep.reset();
         s.settings.solver = SolverKind::impulse;
         s.settings.substeps = 1;
         s.settings.auto_substeps.reset();
       },
       ErrorCode::incompatible},
  };
  for (const Case& c : cases) {
    Scene scene = test::everything_scene();
    c.spoil(scene);
    const Status status = check_scene(scene, "x.json");
    CAPTURE(c.message);
    REQUIRE_FALSE(status);
    CHECK_THAT(status.error().message, StartsWith(c.message));
    CHECK(status.error().code == c.code);
  }
}

TEST_CASE("a body of lines alone moves where it states mass and inertia", "[engine][scene][analytic]") {
  Scene scene = test::everything_scene();
  scene.bodies[2].shapes = {scene.bodies[0].shapes[5]};
  scene.bodies[2].mass = ExplicitMass{2, 3.0, {}};
  CHECK(check_scene(scene, "x.json"));
  scene.bodies[2].mass->inertia.reset();
  scene.bodies[2].fixed_rotation = true;
  CHECK(check_scene(scene, "x.json"));
}

TEST_CASE("a spring of no length and limits that meet are accepted", "[engine][scene][analytic]") {
  Scene scene = test::everything_scene();
  scene.joints[2].length = 0;
  scene.joints[2].limits = Range{0.5, 0.5};
  CHECK(check_scene(scene, "x.json"));
}

TEST_CASE("a million bodies are over the limit", "[engine][scene][analytic]") {
  Scene scene;
  Body body;
  body.shapes = {circle()};
  scene.bodies.assign(limits::body_count_max + 1, body);
  const Status status = check_scene(scene, "x.json");
  REQUIRE_FALSE(status);
  CHECK(status.error().code == ErrorCode::limit);
  CHECK(status.error().message == "x.json: bodies: too many: found 200001, expected at most 200000");
  scene.bodies.pop_back();
  CHECK(check_scene(scene, "x.json"));
}

TEST_CASE("shapes can collide exactly if a dynamic body and another one can exist at once",
          "[engine][scene][analytic]") {
  Body ball;
  ball.name = "ball";
  ball.shapes = {circle()};
  Body ground = ball;
  ground.name = "ground";
  ground.type = BodyType::static_body;
  Body lift = ball;
  lift.name = "lift";
  lift.type = BodyType::kinematic_body;
  Scene scene;
  scene.bodies = {ball};
  CHECK_FALSE(can_collide(scene));
  scene.bodies = {ground, lift};
  CHECK_FALSE(can_collide(scene));
  scene.bodies = {ground, ball};
  CHECK(can_collide(scene));
  scene.bodies = {ball, ball};
  CHECK(can_collide(scene));

  scene.bodies = {ground};
  scene.prototypes = {ball, lift};
  CHECK_FALSE(can_collide(scene));  // no declared input can spawn the prototypes
  scene.inputs = {InputKind::press, InputKind::drag, InputKind::release};
  scene.pointer.emplace();
  CHECK_FALSE(can_collide(scene));
  scene.pointer->spawns = {"lift"};
  CHECK_FALSE(can_collide(scene));
  scene.pointer->spawns = {"lift", "ball"};
  CHECK(can_collide(scene));
  scene.pointer.reset();
  scene.inputs = {InputKind::spawn};
  CHECK(can_collide(scene));
  scene.bodies.clear();
  scene.prototypes = {ball};
  CHECK(can_collide(scene));  // a prototype can collide with another copy of itself
}

TEST_CASE("a pointer needs a solver that pulls, even where nothing collides", "[engine][scene][analytic]") {
  Scene scene;
  scene.bodies.resize(1);
  scene.bodies[0].shapes = {circle()};
  scene.settings.solver = SolverKind::free_flight;
  CHECK(check_scene(scene, "x.json"));
  scene.inputs = {InputKind::press, InputKind::drag, InputKind::release};
  scene.pointer.emplace();
  const Status status = check_scene(scene, "x.json");
  REQUIRE_FALSE(status);
  CHECK_THAT(status.error().message, Contains("found a pointer"));
}

TEST_CASE("a scene in binary comes back equal, byte for byte", "[engine][scene_binary][equivalence]") {
  const Scene scene = test::everything_scene();
  const Bytes bytes = encode_scene(scene);
  const Result<Scene> back = decode_scene(bytes);
  REQUIRE(back);
  CHECK(*back == scene);
  CHECK(encode_scene(*back) == bytes);
}

TEST_CASE("a scene in binary that is cut or has bytes left over is refused", "[engine][scene_binary][corruption]") {
  const Bytes bytes = encode_scene(test::everything_scene());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const Result<Scene> back = decode_scene(ByteView(bytes).first(size));
    CAPTURE(size);
    REQUIRE_FALSE(back);
    REQUIRE(back.error().code == ErrorCode::corrupt);
  }
  Bytes longer = bytes;
  longer.push_back(0);
  REQUIRE_FALSE(decode_scene(longer));
  CHECK_THAT(decode_scene(longer).error().message,
             Contains("left over: found 1") || Contains("after the scene: found 1"));
}

TEST_CASE("a changed byte of a scene in binary is refused or gives a scene that keeps every rule",
          "[engine][scene_binary][corruption]") {
  const Bytes bytes = encode_scene(test::everything_scene());
  int accepted = 0, refused = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i)
    for (const int mask : {0x01, 0x80, 0xff}) {
      Bytes changed = bytes;
      changed[i] = static_cast<std::uint8_t>(changed[i] ^ mask);
      const Result<Scene> back = decode_scene(changed);
      if (!back) {
        ++refused;
        continue;
      }
      ++accepted;
      REQUIRE(check_scene(*back, "x"));
      REQUIRE(encode_scene(*back) == changed);  // the encoding is canonical
    }
  CHECK(accepted > 0);
  CHECK(refused > 0);
}

TEST_CASE("a count that cannot be is refused before memory is taken", "[engine][scene_binary][corruption]") {
  const Bytes whole = encode_scene(whole_scene());
  // The count of bodies follows version, name (4 + 5) and 80 bytes of settings and gravity.
  const std::size_t offset = 2 + 4 + 5 + (1 + 8 + 4 + 1 + 4 + 5 + 8 + 4) + (1 + 4 + 3 * 8) + 16;
  Bytes changed = whole;
  REQUIRE(changed[offset] == 4);
  changed[offset] = 5;  // the bytes after the last body are read as a body
  CHECK_FALSE(decode_scene(changed));
  for (int i = 0; i < 4; ++i) changed[offset + i] = static_cast<std::uint8_t>(200'000 >> (8 * i));
  CHECK(decode_scene(changed).error().code == ErrorCode::corrupt);
  for (int i = 0; i < 4; ++i) changed[offset + i] = 0xff;
  CHECK(decode_scene(changed).error().code == ErrorCode::limit);
  changed = whole;
  changed[0] = 9;
  CHECK(decode_scene(changed).error().code == ErrorCode::incompatible);
}
