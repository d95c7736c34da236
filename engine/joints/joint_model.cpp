// Makes the constants of a run from the joints of a scene.
// SPDX-License-Identifier: MIT
#include "engine/joints/joint_model.h"

#include <algorithm>

#include "base/state/state_view.h"
#include "engine/joints/joint_rows.h"
#include "engine/math/trig.h"
#include "engine/model/model.h"
#include "engine/model/state.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

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

/// The coordinate of a revolute or prismatic joint at the start of the scene, rad or m.
double start_coordinate(const Scene& scene, const Joint& joint) {
  const Body& a = scene.bodies[joint.body_a];
  const Body& b = scene.bodies[joint.body_b];
  if (joint.kind == JointKind::revolute) return b.angle - a.angle - joint.reference_angle;
  const SinCos of_a = pose_sin_cos(a.angle);
  const SinCos of_b = pose_sin_cos(b.angle);
  const auto rotated = [](const SinCos& by, Point p) -> Point {
    return {by.cos * p.x - by.sin * p.y, by.sin * p.x + by.cos * p.y};
  };
  const Point arm_a = rotated(of_a, joint.anchor_a);
  const Point arm_b = rotated(of_b, joint.anchor_b);
  const Point axis = rotated(of_a, joint.axis);
  const Point gap{(b.position.x - a.position.x) + (arm_b.x - arm_a.x),
                  (b.position.y - a.position.y) + (arm_b.y - arm_a.y)};
  return (axis.x * gap.x + axis.y * gap.y) / __builtin_sqrt(axis.x * axis.x + axis.y * axis.y);
}

GearModel make_gear(const Model& model, const Joint& joint) {
  GearModel gear{};
  for (std::size_t i = 0; i < 2; ++i) {
    gear.joints[i] = i == 0 ? joint.joint_a : joint.joint_b;
    const Joint& part = model.scene.joints[gear.joints[i]];
    gear.bodies[2 * i] = part.body_a;
    gear.bodies[2 * i + 1] = part.body_b;
    gear.start[i] = start_coordinate(model.scene, part);
  }
  gear.ratio = joint.ratio;
  gear.constant = gear.start[0] + gear.ratio * gear.start[1];
  return gear;
}

JointModel make_gear_joint(Model& model, const Joint& joint) {
  JointModel out;
  out.kind = joint.kind;
  out.gear = static_cast<std::uint32_t>(model.gears.size());
  const GearModel& gear = model.gears.emplace_back(make_gear(model, joint));
  out.body_a = gear.bodies[1];
  out.body_b = gear.bodies[3];
  out.ratio = static_cast<Real>(joint.ratio);
  return out;
}

JointModel make_joint(Model& model, const Joint& joint) {
  if (joins_joints(joint.kind)) return make_gear_joint(model, joint);
  const bool to_world = !has_body_a(joint.kind);
  const JointCenters centers{to_world ? Vec2{} : model.bodies[joint.body_a].center, model.bodies[joint.body_b].center};
  JointModel out;
  out.kind = joint.kind;
  out.body_a = to_world ? no_reference : joint.body_a;
  out.body_b = joint.body_b;
  out.anchor_a = from_center(joint.anchor_a, centers.a);
  out.anchor_b = from_center(joint.anchor_b, centers.b);
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
  out.length = static_cast<Real>(joint.length);
  out.force_max = static_cast<Real>(joint.force_max);
  out.torque_max = static_cast<Real>(joint.torque_max);
  functions_of(joint.kind).describe(out, joint, centers);
  return out;
}

/// Adds the shares of bodies A and B in the mobility of a joint's point or angle: 1 if the other body is much heavier.
void add_shares(const JointModel& joint, const BodyModel& a, const BodyModel& b, std::vector<double>& sums) {
  const auto mobility = [](const BodyModel& of, Vec2 arm) {
    return static_cast<double>(of.inv_mass) +
           static_cast<double>(of.inv_inertia) * static_cast<double>(length_squared(arm));
  };
  const auto part = [](double own, double other) { return own + other > 0 ? own / (own + other) : 0.0; };
  const double ratio = joint.kind == JointKind::pulley ? static_cast<double>(joint.ratio) : 1;
  const double of_a = mobility(a, joint.anchor_a), of_b = ratio * ratio * mobility(b, joint.anchor_b);
  const double turn_a = joint.holds_angle ? static_cast<double>(a.inv_inertia) : 0;
  const double turn_b = joint.holds_angle ? static_cast<double>(b.inv_inertia) : 0;
  sums[joint.body_a] += std::max(part(of_a, of_b), part(turn_a, turn_b));
  sums[joint.body_b] += std::max(part(of_b, of_a), part(turn_b, turn_a));
}

/// The mobility of a body in the coordinate of a joint: an angle, or a way along an axis with this arm.
double coordinate_mobility(const BodyModel& body, JointKind kind, Vec2 arm) {
  const auto inv_inertia = static_cast<double>(body.inv_inertia);
  if (kind == JointKind::revolute) return inv_inertia;
  return static_cast<double>(body.inv_mass) + inv_inertia * static_cast<double>(length_squared(arm));
}

/// Adds the shares of bodies in the mobilities of gears.
void add_gear_shares(const Model& model, std::vector<double>& sums) {
  for (const GearModel& gear : model.gears) {
    double mobilities[4];
    double all = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const JointModel& joint = model.joints[gear.joints[i / 2]];
      const Vec2 arm = i % 2 == 0 ? joint.anchor_a : joint.anchor_b;
      const double scale = i < 2 ? 1 : gear.ratio * gear.ratio;
      mobilities[i] = scale * coordinate_mobility(model.bodies[gear.bodies[i]], joint.kind, arm);
      all += mobilities[i];
    }
    for (std::size_t i = 0; i < 4; ++i)
      if (all > 0) sums[gear.bodies[i]] += mobilities[i] / all;
  }
}

// Measured on light bodies of 1, 0.01 and 0.0001 kg with 3 to 24 rods of 1 kg, with revolutes and welds. k rods need at
// most k^2 / 4 iterations, and the sum of their shares is k. In chains and nets the sum is 2 at most.
constexpr double share_sum_max = 2.5;
constexpr double iterations_per_share2 = 0.25;
constexpr double joint_visits_max = 1 << 14;  // in all iterations over the joints of the scene

void find_light_bodies(Model& model) {
  std::vector<double> sums(model.scene.bodies.size(), 0);
  for (const JointModel& joint : model.joints) {
    if (!traits_of(joint.kind).is_rigid || !joint.rigid) continue;
    const BodyModel& a = model.bodies[joint.body_a];
    const BodyModel& b = model.bodies[joint.body_b];
    if (a.type != BodyType::dynamic_body || b.type != BodyType::dynamic_body) continue;
    add_shares(joint, a, b, sums);
  }
  add_gear_shares(model, sums);
  const double most = joint_visits_max / static_cast<double>(model.joints.size() + 1);
  for (std::uint32_t body = 0; body < sums.size(); ++body) {
    if (!(sums[body] > share_sum_max)) continue;
    const double wanted = iterations_per_share2 * sums[body] * sums[body];
    const double iterations = wanted < most ? wanted : most;
    if (iterations > 1) model.light_bodies.push_back({body, 1 + static_cast<std::uint32_t>(iterations)});
  }
}

bool has_all_bodies(const State& state, const GearModel& gear) {
  for (const std::uint32_t id : gear.bodies)
    if (state.find_body(id) == state.bodies.size()) return false;
  return true;
}

}  // namespace

Vec2 from_center(Point anchor, Vec2 center) {
  return {static_cast<Real>(anchor.x - static_cast<double>(center.x)),
          static_cast<Real>(anchor.y - static_cast<double>(center.y))};
}

Rotation rotation_of(double angle_rad) {
  const SinCos rotation = pose_sin_cos(angle_rad);
  return {static_cast<Real>(rotation.cos), static_cast<Real>(rotation.sin)};
}

void describe_axis(JointModel& model, const Joint& joint, const JointCenters&) {
  const double size = __builtin_sqrt(joint.axis.x * joint.axis.x + joint.axis.y * joint.axis.y);
  model.axis = {static_cast<Real>(joint.axis.x / size), static_cast<Real>(joint.axis.y / size)};
  model.reference = rotation_of(joint.reference_angle);
}

void describe_reference(JointModel& model, const Joint& joint, const JointCenters&) {
  model.reference = rotation_of(joint.reference_angle);
}

void make_joints(Model& model) {
  for (const Joint& joint : model.scene.joints) {
    const JointModel made = make_joint(model, joint);
    model.joints.push_back(made);
    for_each_body(model, made, [&model](std::uint32_t id) { model.bodies[id].is_jointed = true; });
    for (const std::uint32_t id : {made.body_a, made.body_b})
      if (id != no_reference && id > model.last_joined) model.last_joined = id;
    if (joint.collide_connected || made.body_a == no_reference) continue;
    const std::uint32_t first = std::min(made.body_a, made.body_b), second = std::max(made.body_a, made.body_b);
    model.separated.push_back({first, second, made.gear});
    model.separated_span = std::max(model.separated_span, second - first);
  }
  sort_pairs(model.separated);
  find_light_bodies(model);
}

bool are_separated(const Model& model, const State& state, std::uint32_t id_a, std::uint32_t id_b) {
  const SeparatedPair wanted{id_a < id_b ? id_a : id_b, id_a < id_b ? id_b : id_a, no_gear};
  if (wanted.second - wanted.first > model.separated_span) return false;
  const std::vector<SeparatedPair>& pairs = model.separated;
  std::size_t low = 0;
  std::size_t high = pairs.size();
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (comes_before(pairs[middle], wanted))
      low = middle + 1;
    else
      high = middle;
  }
  for (; low < pairs.size() && !comes_before(wanted, pairs[low]); ++low)
    if (pairs[low].gear == no_gear || has_all_bodies(state, model.gears[pairs[low].gear])) return true;
  return false;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
