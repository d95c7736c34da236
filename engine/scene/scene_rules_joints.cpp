// The rules of joints and forces.
// SPDX-License-Identifier: MIT
#include <type_traits>

#include "base/bytes.h"
#include "engine/scene/scene_rules.h"

namespace ticktrue::engine {
namespace {

constexpr double force_max = scene_force_max;  // N, N m
constexpr double stiffness_max = 1e18;         // N/m, N s/m, N m/rad, N m s/rad
constexpr double exponent_max = 3;             // of central forces, either sign

bool same(double a, double b) {
  return bits_of(a) == bits_of(b);
}

bool same(const Point& a, const Point& b) {
  return same(a.x, b.x) && same(a.y, b.y);
}

template <typename Value>
bool same(const Value& a, const Value& b) {
  return a == b;
}

}  // namespace

bool SceneRules::check_joints() {
  Names names;
  list_ = "joints";
  for (item_index_ = 0; item_index_ < scene_.joints.size(); ++item_index_) {
    const Joint& joint = scene_.joints[item_index_];
    if (!name("name", joint.name) || !unique(joint.name, names) || !row("type", joint_kinds, joint.kind) ||
        !check_joint(joint))
      return false;
  }
  list_ = nullptr;
  return true;
}

bool SceneRules::check_joint(const Joint& joint) {
  const Joint unset;
  const JointKindInfo& info = info_of(joint_kinds, joint.kind);
  const bool has_a = has_body_a(joint.kind);
  bool good = true;
  for_each_joint_field([&](JointField field, const char* field_name, auto member, const FieldRange&) {
    good =
        good && unused(info, field, field_name, same(joint.*member, unset.*member), std::string(info.name) + " joint");
  });
  good = good && (!has_a || check_body_index("body_a", joint.body_a)) && check_body_index("body_b", joint.body_b) &&
         check_pair(joint, has_a);
  for_each_joint_field([&](JointField field, const char*, auto member, const FieldRange& range) {
    const std::string_view key = key_of(info, field);
    good = good && (key.empty() || check_field(joint, field, std::string(key).c_str(), joint.*member, range));
  });
  return good;
}

template <typename Value>
bool SceneRules::check_field(const Joint& joint, JointField field, const char* key, const Value& value,
                             const FieldRange& range) {
  if constexpr (std::is_same_v<Value, Point>) {
    return point(key, value, range.max) && (field != JointField::axis || check_axis(value));
  } else if constexpr (std::is_same_v<Value, double>) {
    return field == JointField::length ? check_length(joint, range) : number(key, value, range.min, range.max);
  } else if constexpr (std::is_same_v<Value, std::optional<Range>>) {
    return !value || check_limits(joint);
  } else if constexpr (std::is_same_v<Value, std::optional<JointMotor>>) {
    return !value || check_motor(*value);
  } else if constexpr (std::is_same_v<Value, std::optional<JointSpring>>) {
    return !value || check_spring(key, *value);
  } else {
    return true;  // bodies: check_joint; flags
  }
}

bool SceneRules::check_body_index(const char* key, std::uint32_t index) {
  if (index < scene_.bodies.size()) return true;
  return refuse(key, "no body has this index: found " + std::to_string(index) + ", expected " +
                         (scene_.bodies.empty() ? "none: the scene has no bodies"
                                                : "0.." + std::to_string(scene_.bodies.size() - 1)));
}

bool SceneRules::check_pair(const Joint& joint, bool has_a) {
  const BodyType type_b = scene_.bodies[joint.body_b].type;
  if (!has_a)
    return type_b == BodyType::dynamic_body ||
           refuse("body_b", "must be dynamic: found a " + std::string(info_of(body_types, type_b).name) + " body");
  if (joint.body_a == joint.body_b)
    return refuse("body_b", "joins a body with itself: found body " + std::to_string(joint.body_b) + " twice");
  const BodyType type_a = scene_.bodies[joint.body_a].type;
  return type_a == BodyType::dynamic_body || type_b == BodyType::dynamic_body ||
         refuse("body_b", "one of the two bodies must be dynamic: found a " +
                              std::string(info_of(body_types, type_a).name) + " and a " +
                              std::string(info_of(body_types, type_b).name) + " body");
}

bool SceneRules::check_axis(const Point& axis) {
  const double x = axis.x < 0 ? -axis.x : axis.x;
  const double y = axis.y < 0 ? -axis.y : axis.y;
  return (x > y ? x : y) >= limits::size_min_m ||
         refuse("axis", "has no direction: found (" + number_text(axis.x) + ", " + number_text(axis.y) +
                            "), expected a length of at least " + number_text(limits::size_min_m));
}

bool SceneRules::check_length(const Joint& joint, const FieldRange& range) {
  const bool is_rigid = traits_of(joint.kind).is_rod && !joint.spring;
  return number("length", joint.length, is_rigid ? limits::size_min_m : range.min, range.max, -1,
                is_rigid && has_field(joint.kind, JointField::spring)
                    ? "a revolute joint keeps two anchors together; a spring may have no length"
                    : "");
}

bool SceneRules::check_limits(const Joint& joint) {
  const JointLimits bounded = traits_of(joint.kind).limits;
  const double max = bounded == JointLimits::angle ? angle_max_rad : limits::coordinate_max_m;
  const double min = bounded == JointLimits::distance ? 0 : -max;
  const Range& range = *joint.limits;
  if (!number("limits", range.lower, min, max, 0) || !number("limits", range.upper, min, max, 1)) return false;
  return range.lower <= range.upper ||
         refuse("limits", "lower is above upper: found [" + number_text(range.lower) + ", " + number_text(range.upper) +
                              "], expected [lower, upper]");
}

bool SceneRules::check_motor(const JointMotor& motor) {
  return number("motor.speed", motor.speed, -limits::speed_max, limits::speed_max) &&
         number("motor.force_max", motor.force_max, 0, force_max);
}

bool SceneRules::check_spring(const std::string& key, const JointSpring& spring) {
  const bool mixed =
      spring.absolute ? spring.hertz != 0 || spring.damping_ratio != 0 : spring.stiffness != 0 || spring.damping != 0;
  if (mixed)
    return refuse(key,
                  "must be one of two forms: found keys of both, expected hertz and damping_ratio, or stiffness "
                  "and damping");
  return number((key + ".hertz").c_str(), spring.hertz, 0, coefficient_max) &&
         number((key + ".damping_ratio").c_str(), spring.damping_ratio, 0, coefficient_max) &&
         number((key + ".stiffness").c_str(), spring.stiffness, 0, stiffness_max) &&
         number((key + ".damping").c_str(), spring.damping, 0, stiffness_max);
}

bool SceneRules::check_forces() {
  Names names;
  list_ = "forces";
  for (item_index_ = 0; item_index_ < scene_.forces.size(); ++item_index_) {
    const Force& force = scene_.forces[item_index_];
    if (!name("name", force.name) || !unique(force.name, names) || !row("type", force_kinds, force.kind) ||
        !check_force(force))
      return false;
  }
  list_ = nullptr;
  return true;
}

bool SceneRules::check_force(const Force& force) {
  const Force unset;
  const auto& fields = info_of(force_fields, force.kind);
  const auto has_no = [&](ForceField field, const char* key, bool is_unset) {
    return unused(fields, field, key, is_unset, std::string(info_of(force_kinds, force.kind).name) + " force");
  };
  if (!has_no(ForceField::body, "body", !force.body) || !has_no(ForceField::other, "other", !force.other) ||
      !has_no(ForceField::anchor, "anchor", same(force.anchor, unset.anchor)) ||
      !has_no(ForceField::point, "point", same(force.point, unset.point)) ||
      !has_no(ForceField::vector, "vector", same(force.vector, unset.vector)) ||
      !has_no(ForceField::torque, "torque", same(force.torque, unset.torque)) ||
      !has_no(ForceField::coefficient, "coefficient", same(force.coefficient, unset.coefficient)) ||
      !has_no(ForceField::angular_coefficient, "angular_coefficient",
              same(force.angular_coefficient, unset.angular_coefficient)) ||
      !has_no(ForceField::exponent, "exponent", same(force.exponent, unset.exponent)) ||
      !has_no(ForceField::stiffness, "stiffness", same(force.stiffness, unset.stiffness)) ||
      !has_no(ForceField::damping, "damping", same(force.damping, unset.damping)) ||
      !has_no(ForceField::rest_length, "rest_length", same(force.rest_length, unset.rest_length)))
    return false;

  // Drags slow down; what a central force does depends on its sign.
  const double coefficient_min = force.kind == ForceKind::central ? -stiffness_max : 0;
  const double vector_max = force.kind == ForceKind::wind ? limits::speed_max : force_max;
  const std::string vector_key(key_of(fields, ForceField::vector));
  const std::string point_key(key_of(fields, ForceField::point));
  return check_force_bodies(force) && point("anchor", force.anchor, limits::size_max_m) &&
         point(point_key.c_str(), force.point, limits::coordinate_max_m) &&
         point(vector_key.c_str(), force.vector, vector_max) && number("torque", force.torque, -force_max, force_max) &&
         number("coefficient", force.coefficient, coefficient_min, stiffness_max) &&
         number("angular_coefficient", force.angular_coefficient, 0, stiffness_max) && check_exponent(force) &&
         number("stiffness", force.stiffness, 0, stiffness_max) && number("damping", force.damping, 0, stiffness_max) &&
         number("rest_length", force.rest_length, 0, limits::coordinate_max_m);
}

bool SceneRules::check_force_bodies(const Force& force) {
  if (force.kind == ForceKind::spring && !force.body)
    return refuse("body", "missing: a spring needs a body: found none, expected one");
  if (force.body && !check_body_index("body", *force.body)) return false;
  if (force.other && !check_body_index("other", *force.other)) return false;
  if (!force.body) return true;
  if (force.other && *force.other == *force.body)
    return refuse("other", "joins a body with itself: found body " + std::to_string(*force.other) + " twice");
  const bool moves = scene_.bodies[*force.body].type == BodyType::dynamic_body ||
                     (force.other && scene_.bodies[*force.other].type == BodyType::dynamic_body);
  return moves || refuse("body",
                         "must be dynamic: found a " +
                             std::string(info_of(body_types, scene_.bodies[*force.body].type).name) + " body",
                         "forces move dynamic bodies only");
}

bool SceneRules::check_exponent(const Force& force) {
  if (!number("exponent", force.exponent, -exponent_max, exponent_max)) return false;
  return static_cast<double>(static_cast<int>(force.exponent)) == force.exponent ||
         refuse("exponent", "must be whole: found " + number_text(force.exponent) + ", expected -3, -2, ... or 3");
}

}  // namespace ticktrue::engine
