// Turns the joints of a scene into the constants of a run.
// SPDX-License-Identifier: MIT
#include "engine/constraints/joint_model.h"

#include "base/state_view.h"
#include "engine/math/trig.h"
#include "engine/model.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

Vec2 from_center(Point anchor, Vec2 center) {
  return {static_cast<Real>(anchor.x - static_cast<double>(center.x)),
          static_cast<Real>(anchor.y - static_cast<double>(center.y))};
}

Rotation rotation_of(double angle_rad) {
  const SinCos turn = sin_cos(angle_rad);
  return {static_cast<Real>(turn.cos), static_cast<Real>(turn.sin)};
}

SpringModel make_spring(const std::optional<JointSpring>& spring) {
  SpringModel out;
  if (!spring) return out;
  out.absolute = spring->absolute;
  const double omega = 2 * pi * spring->hertz;  // rad/s
  out.stiffness = spring->absolute ? spring->stiffness : omega * omega;
  out.damping = spring->absolute ? spring->damping : 2 * spring->damping_ratio * omega;
  out.exists = out.stiffness > 0 || out.damping > 0;
  return out;
}

bool comes_before(const SeparatedPair& a, const SeparatedPair& b) {
  return a.first != b.first ? a.first < b.first : a.second < b.second;
}

/// Merge sort: stable, and the same on every platform.
void sort_pairs(std::vector<SeparatedPair>& pairs) {
  std::vector<SeparatedPair> merged(pairs.size());
  for (std::size_t width = 1; width < pairs.size(); width *= 2) {
    for (std::size_t begin = 0; begin < pairs.size(); begin += 2 * width) {
      const std::size_t middle = begin + width < pairs.size() ? begin + width : pairs.size();
      const std::size_t end = begin + 2 * width < pairs.size() ? begin + 2 * width : pairs.size();
      std::size_t left = begin;
      std::size_t right = middle;
      for (std::size_t i = begin; i < end; ++i) {
        const bool take_right = left == middle || (right < end && comes_before(pairs[right], pairs[left]));
        merged[i] = take_right ? pairs[right++] : pairs[left++];
      }
    }
    pairs.swap(merged);
  }
}

JointModel make_joint(const Model& model, const Joint& joint) {
  const bool to_world = joint.kind == JointKind::target;
  const Vec2 center_a = to_world ? Vec2{} : model.bodies[joint.body_a].center;
  const Vec2 center_b = model.bodies[joint.body_b].center;
  JointModel out;
  out.kind = joint.kind;
  out.body_a = to_world ? no_reference : joint.body_a;
  out.body_b = joint.body_b;
  out.anchor_a = from_center(joint.anchor_a, center_a);
  out.anchor_b = from_center(joint.anchor_b, center_b);
  out.spring = make_spring(joint.spring);
  out.linear_spring = make_spring(joint.linear_spring);
  if (joint.limits) {
    out.has_limits = true;
    out.lower = static_cast<Real>(joint.limits->lower);
    out.upper = static_cast<Real>(joint.limits->upper);
  }
  if (joint.motor) {
    out.has_motor = true;
    out.motor_speed = static_cast<Real>(joint.motor->speed);
    out.motor_force_max = static_cast<Real>(joint.motor->force_max);
  }
  const bool is_plain = !out.spring.exists && !out.has_limits && !out.has_motor;
  out.is_pin = joint.kind == JointKind::revolute && is_plain;
  out.is_hinge = joint.kind == JointKind::revolute && !is_plain;
  out.length = static_cast<Real>(joint.length);
  out.force_max = static_cast<Real>(joint.force_max);
  out.torque_max = static_cast<Real>(joint.torque_max);
  switch (joint.kind) {
    case JointKind::revolute:
      out.reference = rotation_of(joint.reference_angle);
      break;
    case JointKind::prismatic:
    case JointKind::wheel: {
      const double size = __builtin_sqrt(joint.axis.x * joint.axis.x + joint.axis.y * joint.axis.y);
      out.axis = {static_cast<Real>(joint.axis.x / size), static_cast<Real>(joint.axis.y / size)};
      out.reference = rotation_of(joint.reference_angle);
      break;
    }
    case JointKind::distance:
      out.rigid = !joint.spring && !joint.limits && !joint.motor;
      break;
    case JointKind::weld:
      out.reference = rotation_of(joint.reference_angle);
      out.rigid = !joint.linear_spring;
      out.rigid_angle = !joint.spring;
      break;
    case JointKind::motor:
      out.anchor_a = from_center(joint.offset, center_a);
      out.anchor_b = from_center({}, center_b);
      out.reference = rotation_of(joint.angle_offset);
      out.rigid = !joint.spring;
      break;
    case JointKind::friction:
      out.anchor_a = {};
      out.anchor_b = {};
      break;
    case JointKind::target:
      out.anchor_a = {static_cast<Real>(joint.offset.x), static_cast<Real>(joint.offset.y)};
      out.rigid = !joint.spring;
      break;
  }
  return out;
}

}  // namespace

void make_joints(Model& model) {
  for (const Joint& joint : model.scene.joints) {
    model.joints.push_back(make_joint(model, joint));
    for (const std::uint32_t id : {joint.body_a, joint.body_b})
      if (id != no_reference && id > model.last_joined) model.last_joined = id;
    if (joint.collide_connected || joint.kind == JointKind::target) continue;
    const bool ascending = joint.body_a < joint.body_b;
    model.separated.push_back({ascending ? joint.body_a : joint.body_b, ascending ? joint.body_b : joint.body_a});
  }
  sort_pairs(model.separated);
}

bool are_separated(const std::vector<SeparatedPair>& pairs, std::uint32_t id_a, std::uint32_t id_b) {
  const SeparatedPair wanted{id_a < id_b ? id_a : id_b, id_a < id_b ? id_b : id_a};
  std::size_t low = 0;
  std::size_t high = pairs.size();
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (comes_before(pairs[middle], wanted))
      low = middle + 1;
    else
      high = middle;
  }
  return low < pairs.size() && !comes_before(wanted, pairs[low]);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
