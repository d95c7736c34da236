// Notes on a scene: bounces that lose energy, and places that f32 rounds too coarsely.
// SPDX-License-Identifier: MIT
#include "tool/output/scene_notes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/scene/hull.h"

namespace ticktrue::verifier {
namespace {

using engine::Body;
using engine::BodyType;
using engine::MixRule;
using engine::Point;
using engine::Scene;
using engine::Shape;

double mixed(MixRule rule, double a, double b) {
  switch (rule) {
    case MixRule::geometric_mean:
      return std::sqrt(a * b);
    case MixRule::maximum:
      return std::max(a, b);
    case MixRule::minimum:
      return std::min(a, b);
    case MixRule::average:
      break;
  }
  return (a + b) / 2;
}

// The largest restitution of a pair that may meet; filters and joints do not count.
double largest_restitution(const Scene& scene) {
  if (!engine::can_collide(scene)) return 0;
  double moving[2]{-1, -1};  // the two bodies that bounce most; below 0: there is none
  double fixed = -1;         // of those that do not move by themselves
  const auto add = [&](const Body& body) {
    double value = -1;
    for (const Shape& shape : body.shapes)
      if (!shape.sensor) value = std::max(value, shape.material.restitution);
    if (body.type != BodyType::dynamic_body) {
      fixed = std::max(fixed, value);
    } else {
      moving[1] = std::max(moving[1], std::min(value, moving[0]));
      moving[0] = std::max(moving[0], value);
    }
  };
  for (const Body& body : scene.bodies) add(body);
  for (const Body& body : scene.prototypes) {
    add(body);
    add(body);  // two of them may meet
  }
  double most = 0;
  for (const double other : {moving[1], fixed})
    if (moving[0] >= 0 && other >= 0) most = std::max(most, mixed(scene.settings.restitution_mix, moving[0], other));
  return most;
}

// Twice the radius of the largest circle about its centroid inside a shape, m; 0 for lines.
double size_of(const Shape& shape) {
  const std::vector<Point> core = engine::core_of(shape);
  if (shape.kind == engine::ShapeKind::segment || shape.kind == engine::ShapeKind::chain) return 0;
  if (core.size() < 3) return 2 * shape.radius;
  const Point center = engine::shape_mass(shape).center;
  double least = HUGE_VAL;
  for (std::size_t i = 0; i < core.size(); ++i) {
    const Point& a = core[i];
    const Point& b = core[(i + 1) % core.size()];
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    least = std::min(least, std::fabs((b.x - a.x) * (center.y - a.y) - (b.y - a.y) * (center.x - a.x)) / length);
  }
  return 2 * (least + shape.radius);
}

void add_f32_note(const Scene& scene, std::vector<std::string>& notes) {
  if (scene.settings.precision != engine::Precision::f32) return;
  double extent = 0, smallest = HUGE_VAL;
  const auto add_sizes = [&](const Body& body) {
    if (body.type != BodyType::dynamic_body) return;
    for (const Shape& shape : body.shapes)
      if (const double size = size_of(shape); size > 0) smallest = std::min(smallest, size);
  };
  for (const Body& body : scene.bodies) {
    add_sizes(body);
    if (body.type != BodyType::static_body)
      extent = std::max({extent, std::fabs(body.position.x), std::fabs(body.position.y)});
  }
  for (const Body& body : scene.prototypes) add_sizes(body);
  if (!(extent > f32_extent_max * smallest)) return;
  const double rounding = std::ldexp(1.0, std::ilogb(extent) - 23);
  notes.push_back(
      fmt::format("f32 rounds places {:.3g} m from the origin to {:.2g} m, and the smallest moving shape has "
                  "{:.2g} m: contacts shake there; use \"precision\": \"f64\", or move the scene to the origin",
                  extent, rounding, smallest));
}

}  // namespace

std::vector<std::string> scene_notes(const Scene& scene) {
  std::vector<std::string> notes;
  if (!scene.settings.locate_impacts && largest_restitution(scene) >= 1) {
    Scene located = scene;
    located.settings.locate_impacts = true;
    const bool has_cure = engine::check_scene(located, "scene").has_value();
    notes.push_back(std::string("restitution 1 loses energy where impacts are not located in time") +
                    (has_cure ? "; \"locate_impacts\": true keeps it" : ""));
  }
  add_f32_note(scene, notes);
  return notes;
}

}  // namespace ticktrue::verifier
