// Position errors of joints: anchors, axes and angles from poses in f64.
// SPDX-License-Identifier: MIT
// Source: Catto, "Modeling and Solving Constraints", GDC 2009 (the constraints; definitions only).
#include "tests/support/joint_gaps.h"

#include <algorithm>
#include <cmath>

#include "engine/math/trig.h"
#include "engine/scene/hull.h"

namespace ticktrue::test {
namespace {

using engine::BodyReport;
using engine::BodyType;
using engine::Joint;
using engine::JointKind;
using engine::Point;
using engine::Shape;

Point turned(double angle, const Point& p) {
  const engine::SinCos turn = engine::sin_cos(angle);
  return {turn.cos * p.x - turn.sin * p.y, turn.sin * p.x + turn.cos * p.y};
}

Point place_of(const BodyReport& body, const Point& anchor) {
  const Point arm = turned(body.angle, anchor);
  return {body.origin.x + arm.x, body.origin.y + arm.y};
}

double diameter_of(const engine::Body& body) {
  struct Disc {
    Point center;
    double radius;
  };
  std::vector<Disc> discs;
  for (const Shape& shape : body.shapes)
    for (const Point& p : engine::core_of(shape)) discs.push_back({p, shape.radius});
  double diameter = 0;
  for (const Disc& a : discs)
    for (const Disc& b : discs)
      diameter = std::max(diameter, std::hypot(a.center.x - b.center.x, a.center.y - b.center.y) + a.radius + b.radius);
  return diameter;
}

double beyond(const engine::Range& limits, double value) {
  return std::max({0.0, limits.lower - value, value - limits.upper});
}

JointGap gap_of(const Joint& joint, const BodyReport& a, const BodyReport& b, double size) {
  JointGap out;
  out.size = size;
  const Point at_a = place_of(a, joint.anchor_a);
  const Point at_b = place_of(b, joint.anchor_b);
  const Point d{at_b.x - at_a.x, at_b.y - at_a.y};
  const double distance = std::hypot(d.x, d.y);
  const double angle = std::remainder(b.angle - a.angle - joint.reference_angle, 2 * engine::pi);
  const Point axis = turned(a.angle, joint.axis);
  const double axis_length = std::hypot(axis.x, axis.y);
  const double along = (d.x * axis.x + d.y * axis.y) / axis_length;
  const double across = std::fabs(d.y * axis.x - d.x * axis.y) / axis_length;
  switch (joint.kind) {
    case JointKind::revolute:
      out.gap = distance;
      if (joint.limits) out.beyond = size * beyond(*joint.limits, angle);
      break;
    case JointKind::weld:
      if (!joint.linear_spring) out.gap = distance;
      if (!joint.spring) out.gap = std::max(out.gap, size * std::fabs(angle));
      break;
    case JointKind::prismatic:
      out.gap = std::max(across, size * std::fabs(angle));
      if (joint.limits) out.beyond = beyond(*joint.limits, along);
      break;
    case JointKind::wheel:
      out.gap = across;
      if (joint.limits) out.beyond = beyond(*joint.limits, along);
      break;
    case JointKind::distance:
      if (!joint.spring && !joint.limits && !joint.motor) out.gap = std::fabs(distance - joint.length);
      if (joint.limits) out.beyond = beyond(*joint.limits, distance);
      break;
    case JointKind::pulley:
      out.gap = std::fabs(std::hypot(at_a.x - joint.ground_anchor_a.x, at_a.y - joint.ground_anchor_a.y) +
                          joint.ratio * std::hypot(at_b.x - joint.ground_anchor_b.x, at_b.y - joint.ground_anchor_b.y) -
                          joint.length);
      break;
    case JointKind::motor:
    case JointKind::friction:
    case JointKind::target:
      break;  // constrains nothing, only applies a force
    case JointKind::gear:
      break;  // its coordinates are columns of the state
  }
  return out;
}

}  // namespace

std::vector<JointGap> joint_gaps(const engine::Scene& scene, const std::vector<BodyReport>& bodies) {
  std::vector<const BodyReport*> by_id(scene.bodies.size(), nullptr);
  for (const BodyReport& body : bodies)
    if (body.id < by_id.size()) by_id[body.id] = &body;
  std::vector<JointGap> gaps;
  for (const Joint& joint : scene.joints) {
    const BodyReport* a = joint.kind == JointKind::target ? by_id[joint.body_b] : by_id[joint.body_a];
    const BodyReport* b = by_id[joint.body_b];
    if (!a || !b) {
      gaps.push_back({0, 0, 0, false});
      continue;
    }
    double size = HUGE_VAL;
    for (const BodyReport* body : {a, b})
      if (body->type == BodyType::dynamic_body) size = std::min(size, diameter_of(scene.bodies[body->id]));
    gaps.push_back(gap_of(joint, *a, *b, size));
  }
  return gaps;
}

}  // namespace ticktrue::test
