// Gaps and drawn lines of joints, in world coordinates.
// SPDX-License-Identifier: MIT
#include "tool/drawing/joint_geometry.h"

#include <cmath>

#include "engine/math/trig.h"

namespace ticktrue::tool {

using engine::BodyReport;
using engine::Joint;
using engine::JointKind;
using engine::Point;

namespace {

double between_anchors(const Joint&, const JointPlaces& places) {
  return std::hypot(places.anchor_b.x - places.anchor_a.x, places.anchor_b.y - places.anchor_a.y);
}

double of_weld(const Joint& joint, const JointPlaces& places) {
  return joint.linear_spring ? 0 : between_anchors(joint, places);
}

double across_axis(const Joint&, const JointPlaces& places) {
  const Point d{places.anchor_b.x - places.anchor_a.x, places.anchor_b.y - places.anchor_a.y};
  const Point axis = places.axis;
  return std::fabs(d.y * axis.x - d.x * axis.y) / std::hypot(axis.x, axis.y);
}

double of_rod(const Joint& joint, const JointPlaces& places) {
  const bool is_rod = !joint.spring && !joint.limits && !joint.motor;
  return is_rod ? std::fabs(between_anchors(joint, places) - joint.length) : 0;
}

double of_pulley(const Joint& joint, const JointPlaces& places) {
  const auto distance = [](Point a, Point b) { return std::hypot(b.x - a.x, b.y - a.y); };
  return std::fabs(distance(joint.ground_anchor_a, places.anchor_a) +
                   joint.ratio * distance(joint.ground_anchor_b, places.anchor_b) - joint.length);
}

double nothing(const Joint&, const JointPlaces&) {
  return 0;
}

JointLines one_line(const Joint&, const JointPlaces& places) {
  return {1, {{{places.anchor_a, places.anchor_b}}}};
}

JointLines over_the_ground_anchors(const Joint& joint, const JointPlaces& places) {
  return {3,
          {{{joint.ground_anchor_a, places.anchor_a},
            {joint.ground_anchor_b, places.anchor_b},
            {joint.ground_anchor_a, joint.ground_anchor_b}}}};
}

struct JointGeometry {
  JointKind kind;
  double (*gap)(const Joint& joint, const JointPlaces& places);
  JointLines (*lines)(const Joint& joint, const JointPlaces& places);
};
constexpr std::array<JointGeometry, engine::joint_kinds.size()> table{{
    {JointKind::revolute, between_anchors, one_line},
    {JointKind::prismatic, across_axis, one_line},
    {JointKind::distance, of_rod, one_line},
    {JointKind::weld, of_weld, one_line},
    {JointKind::wheel, across_axis, one_line},
    {JointKind::motor, nothing, one_line},
    {JointKind::friction, nothing, one_line},
    {JointKind::target, nothing, one_line},
    {JointKind::pulley, of_pulley, over_the_ground_anchors},
    {JointKind::gear, nothing, one_line},
}};
static_assert(engine::rows_are_in_order(table));

}  // namespace

Joint shown_joint(const engine::Scene& scene, const Joint& joint) {
  Joint shown = joint;
  if (!engine::joins_joints(joint.kind)) return shown;
  const Joint& first = scene.joints[joint.joint_a];
  const Joint& second = scene.joints[joint.joint_b];
  shown.body_a = first.body_b;
  shown.anchor_a = first.anchor_b;
  shown.body_b = second.body_b;
  shown.anchor_b = second.anchor_b;
  return shown;
}

double joint_gap(const Joint& joint, const JointPlaces& places) {
  return info_of(table, joint.kind).gap(joint, places);
}

JointLines joint_lines(const Joint& joint, const JointPlaces& places) {
  return info_of(table, joint.kind).lines(joint, places);
}

namespace {

Point turned(double angle, const Point& p) {
  const engine::SinCos turn = engine::sin_cos(angle);
  return {turn.cos * p.x - turn.sin * p.y, turn.sin * p.x + turn.cos * p.y};
}

Point place_of(const BodyReport& body, const Point& anchor) {
  const Point arm = turned(body.angle, anchor);
  return {body.origin.x + arm.x, body.origin.y + arm.y};
}

JointPlaces places_of(const Joint& joint, const BodyReport& a, const BodyReport& b) {
  return {place_of(a, joint.anchor_a), place_of(b, joint.anchor_b), turned(a.angle, joint.axis)};
}

}  // namespace

std::vector<double> joint_gaps(const engine::Scene& scene, const std::vector<BodyReport>& bodies) {
  std::vector<const BodyReport*> by_id(scene.bodies.size(), nullptr);
  for (const BodyReport& body : bodies)
    if (body.id < by_id.size()) by_id[body.id] = &body;
  std::vector<double> gaps;
  for (const Joint& joint : scene.joints) {
    const BodyReport* b = by_id[joint.body_b];
    const BodyReport* a = engine::has_body_a(joint.kind) ? by_id[joint.body_a] : b;
    gaps.push_back(a && b ? joint_gap(joint, places_of(joint, *a, *b)) : 0);
  }
  return gaps;
}

}  // namespace ticktrue::tool
