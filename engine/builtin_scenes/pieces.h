// Shared parts of the builders of built-in scenes: arguments, and shapes and bodies in one line.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/assert.h"
#include "engine/builtin_scenes/builtin_scenes.h"

namespace ticktrue::engine {

/// The requested arguments: a value for each of the scene's own parameters, and the settings that were named.
struct SceneArguments {
  std::span<const SceneParameter> parameters;
  std::vector<double> values;  // [parameter]
  std::optional<Precision> precision;
  std::optional<double> dt;
  std::optional<int> substeps;
  bool auto_substeps = false;
  std::optional<int> sleep;  // 0 or 1, as the next two
  std::optional<int> locate_impacts;
  std::optional<int> continuous;
  std::optional<SolverKind> solver;
  std::optional<IntegratorKind> integrator;
  std::optional<BroadPhaseKind> broad_phase;
  std::optional<ClockKind> clock;
  std::optional<JointSolverKind> joints;
  std::optional<SubstepLoads> substep_loads;
  std::optional<int> substep_budget;
  std::optional<double> gravity;

  double real(std::string_view name) const {
    for (std::size_t i = 0; i < parameters.size(); ++i)
      if (parameters[i].name == name) return values[i];
    TICKTRUE_ASSERT(false && "a builder asks for a parameter that its row does not list");
    return 0;
  }
  int whole(std::string_view name) const { return static_cast<int>(real(name)); }
  /// Seeds are whole numbers up to 2^53.
  std::uint64_t seed() const { return static_cast<std::uint64_t>(real("seed")); }
};

inline constexpr double seed_max = 9007199254740991;  // 2^53 - 1: doubles hold all whole numbers up to it

inline Shape circle(double radius, Point center = {}) {
  Shape shape;
  shape.kind = ShapeKind::circle;
  shape.radius = radius;
  shape.center = center;
  return shape;
}

inline Shape box(double half_width, double half_height, Point center = {}) {
  Shape shape;
  shape.kind = ShapeKind::box;
  shape.half_size = {half_width, half_height};
  shape.center = center;
  return shape;
}

inline Shape polygon(std::vector<Point> vertices) {
  Shape shape;
  shape.kind = ShapeKind::polygon;
  shape.vertices = std::move(vertices);
  return shape;
}

inline Shape with(Shape shape, double friction, double restitution) {
  shape.material = {friction, restitution};
  return shape;
}

inline Body body(std::string name, BodyType type, Point position, Shape shape) {
  Body result;
  result.name = std::move(name);
  result.type = type;
  result.position = position;
  result.shapes.push_back(std::move(shape));
  return result;
}

inline Body dynamic_body(const char* kind, std::size_t number, Point position, Shape shape) {
  return body(kind + ("_" + std::to_string(number)), BodyType::dynamic_body, position, std::move(shape));
}

inline Body static_body(std::string name, Point position, Shape shape) {
  return body(std::move(name), BodyType::static_body, position, std::move(shape));
}

inline Shape line(ShapeKind kind, std::vector<Point> points, double radius = 0) {
  Shape shape;
  shape.kind = kind;
  shape.vertices = std::move(points);
  shape.radius = radius;
  return shape;
}

/// Joins `b` to `a` by a revolute joint at anchors in their frames. Bodies are indices.
inline Joint& pin(Scene& scene, std::size_t a, Point anchor_a, std::size_t b, Point anchor_b) {
  Joint joint;
  joint.kind = JointKind::revolute;
  joint.body_a = static_cast<std::uint32_t>(a);
  joint.body_b = static_cast<std::uint32_t>(b);
  joint.anchor_a = anchor_a;
  joint.anchor_b = anchor_b;
  scene.joints.push_back(std::move(joint));
  return scene.joints.back();
}

}  // namespace ticktrue::engine
