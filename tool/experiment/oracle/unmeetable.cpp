// Pairs and bodies that the law of soft constraints does not judge.
// SPDX-License-Identifier: MIT
#include "tool/experiment/oracle/unmeetable.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "engine/scene/hull.h"
#include "tool/study/measures.h"

namespace ticktrue::soak {
namespace {

using engine::BodyReport;
using engine::BodyType;
using engine::ContactReport;
using engine::Joint;
using engine::JointKind;
using engine::Point;
using engine::Shape;

constexpr double opposite = -0.5;  // cosine of two normals between which a body is squeezed

/// A point in a shape.
struct PinDepth {
  double least = 0;   // m, how deep it lies inside; at most 0 outside
  double corner = 0;  // m, to the farther corner of the nearest edge
};
PinDepth depth_inside(const Shape& shape, const Point& at) {
  if (engine::is_line(shape.kind)) return {};
  const std::vector<Point> core = engine::core_of(shape);
  double inside = infinite, outside = infinite, corner = 0;
  for (std::size_t i = 0; i < core.size(); ++i) {
    const Point& p = core[i];
    const Point& q = core[(i + 1) % core.size()];
    const Point edge{q.x - p.x, q.y - p.y};
    const double length = std::hypot(edge.x, edge.y);
    const double along = length > 0 ? ((at.x - p.x) * edge.x + (at.y - p.y) * edge.y) / (length * length) : 0;
    const double share = std::clamp(along, 0.0, 1.0);
    outside = std::min(outside, std::hypot(at.x - p.x - share * edge.x, at.y - p.y - share * edge.y));
    const double depth = length > 0 ? (edge.x * (at.y - p.y) - edge.y * (at.x - p.x)) / length : infinite;
    if (depth >= inside) continue;
    inside = depth;
    corner = std::max(std::hypot(at.x - p.x, at.y - p.y), std::hypot(at.x - q.x, at.y - q.y));
  }
  if (core.size() >= 3 && inside > 0) return {shape.radius + inside, shape.radius + corner};
  return {shape.radius - outside, shape.radius - outside};
}

/// Pairs of bodies that a joint without springs holds together.
std::set<BodyIds> find_held(const TickView& view) {
  std::set<BodyIds> held;
  for (std::uint32_t i = 0; i < view.joints.row_count(); ++i) {
    const Joint& joint = view.scene.joints[view.joints.whole(i, "joint")];
    if (!engine::has_body_a(joint.kind) || !engine::traits_of(joint.kind).is_rigid) continue;
    const bool is_held =
        joint.kind == JointKind::weld ? !joint.linear_spring : joint.kind == JointKind::revolute || !joint.spring;
    if (is_held) held.insert(std::minmax(view.index.at(joint.body_a), view.index.at(joint.body_b)));
  }
  return held;
}

}  // namespace

std::set<BodyIds> find_welded(const TickView& view) {
  std::set<BodyIds> welded;
  for (std::uint32_t i = 0; i < view.joints.row_count(); ++i) {
    const Joint& joint = view.scene.joints[view.joints.whole(i, "joint")];
    if (joint.kind == JointKind::weld && !joint.spring && !joint.linear_spring)
      welded.insert(std::minmax(joint.body_a, joint.body_b));
  }
  return welded;
}

std::map<BodyIds, double> find_pinned(const TickView& view) {
  std::map<BodyIds, double> pinned;
  for (std::uint32_t i = 0; i < view.joints.row_count(); ++i) {
    const Joint& joint = view.scene.joints[view.joints.whole(i, "joint")];
    const bool is_pin = joint.kind == JointKind::revolute || (joint.kind == JointKind::weld && !joint.linear_spring);
    if (!is_pin || !joint.collide_connected) continue;
    const auto depth = [&](std::uint32_t id, const Point& anchor) {
      PinDepth most;
      for (const Shape& shape : *view.bodies[view.index.at(id)].shapes)
        if (const PinDepth of_shape = depth_inside(shape, anchor); of_shape.least > most.least) most = of_shape;
      return most;
    };
    const PinDepth a = depth(joint.body_a, joint.anchor_a), b = depth(joint.body_b, joint.anchor_b);
    if (!(std::min(a.least, b.least) > 0)) continue;
    double& most = pinned[std::minmax(joint.body_a, joint.body_b)];
    most = std::max(most, std::min(a.least + b.corner, a.corner + b.least));
  }
  return pinned;
}

void find_squeezed(const TickView& view, std::vector<std::uint8_t>& is_crushed) {
  struct Side {
    std::uint32_t other;
    Point normal;
  };
  const auto held = find_held(view);
  std::vector<std::vector<Side>> sides(view.bodies.size());
  for (const ContactReport& contact : view.contacts) {
    if (!overlaps(contact)) continue;
    const std::uint32_t a = view.index.at(contact.body_a), b = view.index.at(contact.body_b);
    sides[a].push_back({b, contact.normal});
    sides[b].push_back({a, {-contact.normal.x, -contact.normal.y}});
  }
  for (std::uint32_t i = 0; i < view.bodies.size(); ++i) {
    if (!is_dynamic(view.bodies[i])) continue;
    for (const Side& one : sides[i])
      for (const Side& two : sides[i])
        if (one.normal.x * two.normal.x + one.normal.y * two.normal.y < opposite &&
            (one.other == two.other || view.is_fixed(one.other, two.other) ||
             held.contains(std::minmax(one.other, two.other))))
          is_crushed[i] = 1;
  }
}

void find_driven(const TickView& view, std::vector<std::uint8_t>& is_crushed) {
  const auto count = static_cast<std::uint32_t>(view.bodies.size());
  Groups groups(count);
  const auto tie = [&](std::uint32_t a, std::uint32_t b) { groups.tie(a, b); };
  tie_touching(view, tie);
  tie_joined(view, tie);
  struct Hold {
    std::optional<std::uint32_t> first;  // immovable body
    bool is_driven = false;
    bool has_two = false;
  };
  std::vector<Hold> holds(count);
  const auto hold = [&](std::uint32_t wall, std::uint32_t body, bool is_driven) {
    Hold& at = holds[groups.of(body)];
    at.has_two |= at.first && *at.first != wall;
    if (!at.first) at.first = wall;
    at.is_driven |= is_driven;
  };
  for (const ContactReport& contact : view.contacts) {
    const std::uint32_t a = view.index.at(contact.body_a), b = view.index.at(contact.body_b);
    if (!overlaps(contact) || is_dynamic(view.bodies[a]) == is_dynamic(view.bodies[b])) continue;
    const std::uint32_t wall = is_dynamic(view.bodies[a]) ? b : a;
    bool is_driven = false;
    for (int i = 0; i < contact.point_count; ++i) {
      const Point v = velocity_at(view.bodies[wall], contact.point[i]);
      is_driven |= (wall == a ? 1 : -1) * (v.x * contact.normal.x + v.y * contact.normal.y) > 0;
    }
    hold(wall, wall == a ? b : a, is_driven);
  }
  const auto drives = [&](std::uint32_t wall) {
    const BodyReport& body = view.bodies[wall];
    return body.type == BodyType::kinematic_body && (tool::speed_of(body) != 0 || body.angular_velocity != 0);
  };
  for (std::uint32_t i = 0; i < view.joints.row_count(); ++i) {
    const Joint& joint = view.scene.joints[view.joints.whole(i, "joint")];
    if (!engine::has_body_a(joint.kind)) continue;
    const std::uint32_t a = view.index.at(joint.body_a), b = view.index.at(joint.body_b);
    if (drives(a) && is_dynamic(view.bodies[b])) hold(a, b, true);
    if (drives(b) && is_dynamic(view.bodies[a])) hold(b, a, true);
  }
  // Between impacts, bodies need not touch what drives them at the end of a tick.
  for (std::uint32_t wall = 0; wall < count; ++wall) {
    const BodyReport& body = view.bodies[wall];
    if (!drives(wall)) continue;
    for (std::uint32_t i = 0; i < count; ++i) {
      const BodyReport& other = view.bodies[i];
      if (!is_dynamic(other)) continue;
      const double way = std::hypot(other.velocity.x - body.velocity.x, other.velocity.y - body.velocity.y) * view.dt;
      const double distance = std::hypot(other.center.x - body.center.x, other.center.y - body.center.y);
      if (distance <= view.extents[i].reach + view.extents[wall].reach + way) hold(wall, i, true);
    }
  }
  for (std::uint32_t i = 0; i < count; ++i)
    if (is_dynamic(view.bodies[i]) && holds[groups.of(i)].is_driven && holds[groups.of(i)].has_two) is_crushed[i] = 1;
}

}  // namespace ticktrue::soak
