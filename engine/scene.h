// Scene: the plain description of a world, in f64 and SI units, as people write it.
// SPDX-License-Identifier: MIT
//
// The same type is read from JSON (scene_json.h), built from parameters (builtin_scenes.h) and embedded in traces in
// binary (scene_binary.h). Engines of both precisions are made from it (engine.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "engine/choices.h"
#include "engine/input.h"

namespace ticktrue::engine {

/// A vector of the description, m. The engine's own vectors are of its precision (math/vec2.h).
struct Point {
  double x = 0;
  double y = 0;
  bool operator==(const Point&) const = default;
};

struct Material {
  double friction = 0.6;     // Coulomb coefficient, >= 0
  double restitution = 0.0;  // 0..1
  bool operator==(const Material&) const = default;
};

struct Shape {
  ShapeKind kind = ShapeKind::circle;
  Point center;                 // circle, box: in the body's frame, m
  double angle = 0;             // box: rad
  double radius = 0;            // circle: m
  Point half_size;              // box: m
  std::vector<Point> vertices;  // polygon: in the body's frame, m; any order, 3..16, strictly convex as a set
  double density = 1;           // kg/m^2; of no effect where the body states its mass
  Material material;
  bool operator==(const Shape&) const = default;
};

/// Replaces what the shapes' densities would give.
struct ExplicitMass {
  double mass = 1;                // kg, > 0
  std::optional<double> inertia;  // kg m^2 about the centre of mass, > 0; absent: that of the shapes, scaled to `mass`
  std::optional<Point> center;    // centre of mass in the body's frame, m; absent: that of the shapes
  bool operator==(const ExplicitMass&) const = default;
};

struct Body {
  std::string name;  // may be empty; unique otherwise
  BodyType type = BodyType::dynamic_body;
  Point position;               // of the body's origin, m
  double angle = 0;             // rad
  Point velocity;               // of the centre of mass, m/s
  double angular_velocity = 0;  // rad/s
  double linear_damping = 0;    // 1/s
  double angular_damping = 0;   // 1/s
  double gravity_scale = 1;
  bool fixed_rotation = false;
  std::optional<ExplicitMass> mass;
  std::vector<Shape> shapes;  // at least one
  bool operator==(const Body&) const = default;
};

struct Bounds {
  Point lower;  // m
  Point upper;  // m
  bool operator==(const Bounds&) const = default;
};

/// A pointer (mouse, finger) that presses, drags and releases.
struct PointerSettings {
  std::vector<std::string> spawns;  // prototypes that a press on empty space spawns, in turn; empty: nothing is spawned
  double hertz = 5;                 // stiffness of the pull
  double damping_ratio = 0.7;
  double force_max_per_kg = 1000;  // N per kg of the pulled body
  std::optional<Bounds> window;    // what the pointer's screen shows (imports, pictures); absent: the scene's bounds
  bool operator==(const PointerSettings&) const = default;
};

struct Settings {
  Precision precision = Precision::f32;
  double dt = 1.0 / 60.0;  // s
  int substeps = 4;        // 1..256; 1 where the solver does not substep
  SolverKind solver = SolverKind::tgs_soft;
  IntegratorKind integrator = IntegratorKind::semi_implicit_euler;
  BroadPhaseKind broad_phase = BroadPhaseKind::sweep_and_prune;
  MixRule friction_mix = MixRule::geometric_mean;
  MixRule restitution_mix = MixRule::maximum;
  double restitution_threshold = 1.0;  // m/s: slower approaches do not bounce
  bool operator==(const Settings&) const = default;
};

struct Scene {
  std::string name = "scene";
  Settings settings;
  Point gravity{0, -10};          // m/s^2
  std::vector<Body> bodies;       // ids 0, 1, 2, ... in this order
  std::vector<Body> prototypes;   // named bodies that inputs may spawn; position, angle, velocity are the input's
  std::vector<InputKind> inputs;  // kinds that may come, ascending; an input of another kind is refused
  std::optional<PointerSettings> pointer;    // present if press, drag and release may come
  std::optional<Bounds> bounds;              // a body whose centre of mass leaves them is removed
  std::optional<std::uint32_t> spawned_max;  // more spawned bodies than this: the oldest goes
  bool operator==(const Scene&) const = default;
};

/// Whether two shapes can ever meet: there is, or inputs may spawn, a dynamic body and another one that it may touch.
/// Decides what the pipeline needs and what check_scene refuses, so that both mean the same.
bool can_collide(const Scene& scene);

/// Every rule that a scene must keep, whoever made it: ranges, names, hulls, masses, limits, declared inputs.
/// `source` is the place an error names first (a file name). Messages carry the JSON path.
/// Errors: invalid_scene, limit, incompatible (choices that do not go together; the message names what would work).
Status check_scene(const Scene& scene, const std::string& source);

}  // namespace ticktrue::engine
