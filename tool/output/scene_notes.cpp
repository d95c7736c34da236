// Notes on a scene: bounces that lose energy, places that f32 rounds too coarsely, and joints that turn their bodies.
// SPDX-License-Identifier: MIT
#include "tool/output/scene_notes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/math/trig.h"
#include "engine/scene/hull.h"
#include "engine/scene/joint_kinds.h"
#include "engine/scene/scene_rules.h"

namespace ticktrue::tool {
namespace {

using engine::Body;
using engine::BodyType;
using engine::Point;
using engine::Scene;
using engine::Shape;

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

// How far from the origin something moves, and the size of the smallest moving shape, m. HUGE_VAL: none has a size.
struct SceneReach {
  double extent = 0;
  double smallest = HUGE_VAL;
};

SceneReach reach_of(const Scene& scene) {
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
  return {extent, smallest};
}

void add_f32_note(const Scene& scene, std::vector<std::string>& notes) {
  if (scene.settings.precision != engine::Precision::f32) return;
  const auto [extent, smallest] = reach_of(scene);
  if (!(extent > f32_extent_max * smallest)) return;
  const double rounding = std::ldexp(1.0, std::ilogb(extent) - 23);
  notes.push_back(
      fmt::format("f32 rounds places {:.3g} m from the origin to {:.2g} m, and the smallest moving shape has "
                  "{:.2g} m: contacts shake there; use \"precision\": \"f64\", or move the scene to the origin",
                  extent, rounding, smallest));
}

constexpr double turned_least = 0.1;  // rad

// How far the bodies of a joint with a rigid angle start from that angle, rad, -pi..pi; 0 of other joints.
double turned(const Scene& scene, const engine::Joint& joint) {
  const bool holds_angle =
      joint.kind == engine::JointKind::prismatic || (joint.kind == engine::JointKind::weld && !joint.spring);
  if (!holds_angle) return 0;
  const double angle = scene.bodies[joint.body_b].angle - scene.bodies[joint.body_a].angle;
  return std::remainder(angle - joint.reference_angle, 2 * engine::pi);
}

void add_turned_note(const Scene& scene, std::vector<std::string>& notes) {
  std::size_t count = 0;
  std::size_t first = 0;
  for (std::size_t i = scene.joints.size(); i-- > 0;) {
    if (!(std::fabs(turned(scene, scene.joints[i])) > turned_least)) continue;
    ++count;
    first = i;
  }
  if (count == 0) return;
  const engine::Joint& joint = scene.joints[first];
  const std::string others = count == 1 ? "" : fmt::format(", as {} more", count - 1);
  notes.push_back(fmt::format(
      "joints[{}] ({}) turns its bodies by {:.3g} rad in the first ticks{}; with \"reference_angle\": {:.6g} they stay "
      "as they are placed",
      first, engine::info_of(engine::joint_kinds, joint.kind).name, std::fabs(turned(scene, joint)), others,
      joint.reference_angle + turned(scene, joint)));
}

}  // namespace

std::string budget_text(const std::optional<engine::BudgetReport>& report, std::uint64_t tick_count) {
  if (!report || (report->cut_ticks == 0 && report->limited_ticks == 0)) return {};
  return fmt::format("of {} ticks, {} left a shock unsettled and {} had fewer substeps than wanted", tick_count,
                     report->cut_ticks, report->limited_ticks);
}

Status check_f32_reach(const Scene& scene, const std::string& source) {
  if (scene.settings.precision != engine::Precision::f32) return {};
  const auto [extent, smallest] = reach_of(scene);
  if (!(extent > f32_extent_refused * smallest)) return {};
  return Error{ErrorCode::incompatible,
               fmt::format("{}: settings.precision: f32 is too coarse so far from the origin: found a body that moves "
                           "{:.3g} m out and a shape of {:.2g} m, expected at most {:.3g} m for that shape",
                           source, extent, smallest, f32_extent_refused * smallest),
               "use \"precision\": \"f64\", or move the scene to the origin"};
}

std::vector<std::string> scene_notes(const Scene& scene) {
  std::vector<std::string> notes;
  if (!scene.settings.locate_impacts && engine::largest_restitution(scene) >= 1) {
    const bool has_cure = engine::locates_bounces(scene);
    notes.push_back(std::string("restitution 1 loses energy where impacts are not located in time") +
                    (has_cure ? "; \"locate_impacts\": \"auto\" keeps it" : ""));
  }
  add_f32_note(scene, notes);
  add_turned_note(scene, notes);
  return notes;
}

}  // namespace ticktrue::tool
