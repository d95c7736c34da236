// The rules of joints and forces.
// SPDX-License-Identifier: MIT
#include "engine/scene/scene_rules.h"

namespace ticktrue::engine {

bool SceneRules::check_joints() {
  Names names;
  list_ = "joints";
  for (item_index_ = 0; item_index_ < scene_.joints.size(); ++item_index_) {
    const Joint& joint = scene_.joints[item_index_];
    if (!check_fields(joint) || !unique(joint.name, names) || !row("type", joint_kinds, joint.kind) ||
        !check_joint(joint))
      return false;
  }
  list_ = nullptr;
  return true;
}

bool SceneRules::check_joint(const Joint& joint) {
  return check_own_fields(joint, info_of(joint_kinds, joint.kind), "a ", " joint",
                          [&](const auto& field, std::string_view key, const auto& value, FieldRange range) {
                            if (field.own == JointField::body_b) return check_joint_bodies(joint);
                            if (field.own == JointField::joint_b) return check_gear(joint);
                            if (field.is_body || field.is_joint) return true;  // checked with the field above
                            if (field.own == JointField::length) return check_length(joint, range);
                            if (field.own == JointField::limits) return !joint.limits || check_limits(joint);
                            return check_value(key, value, range, field.hint) &&
                                   (field.own != JointField::axis || check_axis(joint.axis));
                          });
}

bool SceneRules::check_body_index(const char* key, std::uint32_t index) {
  if (index < scene_.bodies.size()) return true;
  return refuse(key, "no body has this index: found " + std::to_string(index) + ", expected " +
                         (scene_.bodies.empty() ? "none: the scene has no bodies"
                                                : "0.." + std::to_string(scene_.bodies.size() - 1)));
}

bool SceneRules::check_joint_bodies(const Joint& joint) {
  const bool has_a = has_body_a(joint.kind);
  if ((has_a && !check_body_index("body_a", joint.body_a)) || !check_body_index("body_b", joint.body_b)) return false;
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

bool SceneRules::check_gear(const Joint& joint) {
  constexpr double ratio_least = 1e-3;
  for (const auto& [key, index] : {std::pair{"joint_a", joint.joint_a}, std::pair{"joint_b", joint.joint_b}}) {
    if (index >= item_index_)
      return refuse(key,
                    "no joint before this one has this index: found " + std::to_string(index) + ", expected " +
                        (item_index_ == 0 ? "none: it is the first joint" : "0.." + std::to_string(item_index_ - 1)),
                    "list a gear after its two joints");
    const JointKindInfo& kind = info_of(joint_kinds, scene_.joints[index].kind);
    if (!kind.traits.has_coordinate)
      return refuse(key, "must be a revolute or prismatic joint: found a " + std::string(kind.name) + " joint");
  }
  if (joint.joint_a == joint.joint_b)
    return refuse("joint_b", "couples a joint with itself: found joint " + std::to_string(joint.joint_b) + " twice");
  const std::uint32_t body = scene_.joints[joint.joint_b].body_b;
  if (scene_.joints[joint.joint_a].body_b == body)
    return refuse("joint_b", "the two joints have the same body_b: found body " + std::to_string(body) + " twice",
                  "exchange body_a and body_b of one of the joints, with its anchors; its coordinate changes the sign");
  return joint.ratio >= ratio_least || joint.ratio <= -ratio_least ||
         refuse("ratio",
                "out of range: found " + number_text(joint.ratio) + ", expected at most -0.001 or at least 0.001");
}

bool SceneRules::check_axis(const Point& axis) {
  const double x = axis.x < 0 ? -axis.x : axis.x;
  const double y = axis.y < 0 ? -axis.y : axis.y;
  return (x > y ? x : y) >= limits::size_min_m ||
         refuse("axis", "has no direction: found (" + number_text(axis.x) + ", " + number_text(axis.y) +
                            "), expected a length of at least " + number_text(limits::size_min_m));
}

bool SceneRules::check_length(const Joint& joint, FieldRange range) {
  const bool is_rigid = traits_of(joint.kind).is_rod && !joint.spring;
  return number("length", joint.length, {is_rigid ? limits::size_min_m : range.min, range.max}, -1,
                is_rigid && has_field(joint.kind, JointField::spring)
                    ? "a revolute joint keeps two anchors together; a spring may have no length"
                    : "");
}

bool SceneRules::check_limits(const Joint& joint) {
  const JointLimits bounded = traits_of(joint.kind).limits;
  const double max = bounded == JointLimits::angle ? angle_max_rad : limits::coordinate_max_m;
  const double min = bounded == JointLimits::distance ? 0 : -max;
  const Range& range = *joint.limits;
  if (!number("limits", range.lower, {min, max}, 0) || !number("limits", range.upper, {min, max}, 1)) return false;
  return range.lower <= range.upper ||
         refuse("limits", "lower is above upper: found [" + number_text(range.lower) + ", " + number_text(range.upper) +
                              "], expected [lower, upper]");
}

bool SceneRules::check_value(std::string_view key, const JointSpring& spring, FieldRange, const char*) {
  bool good = true;
  visit_own_fields(
      [&](const auto& field, double value) { good = good && (field.own == spring.absolute || value == 0); }, spring);
  if (!good)
    return refuse(std::string(key),
                  "must be one of two forms: found keys of both, expected hertz and damping_ratio, or stiffness "
                  "and damping");
  visit_own_fields(
      [&](const auto& field, double value) {
        good = good && number(std::string(key) + "." + std::string(field.name), value, field.range);
      },
      spring);
  return good;
}

bool SceneRules::check_forces() {
  Names names;
  list_ = "forces";
  for (item_index_ = 0; item_index_ < scene_.forces.size(); ++item_index_) {
    const Force& force = scene_.forces[item_index_];
    if (!check_fields(force) || !unique(force.name, names) || !row("type", force_kinds, force.kind) ||
        !check_force(force))
      return false;
  }
  list_ = nullptr;
  return true;
}

bool SceneRules::check_force(const Force& force) {
  return check_own_fields(force, info_of(force_kinds, force.kind), "a ", " force",
                          [&](const auto& field, std::string_view key, const auto& value, FieldRange range) {
                            if (field.own == ForceField::body) return check_force_bodies(force);
                            if (field.is_body) return true;  // checked above
                            return check_value(key, value, range, field.hint) &&
                                   (field.own != ForceField::exponent || check_exponent(force));
                          });
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
  return static_cast<double>(static_cast<int>(force.exponent)) == force.exponent ||
         refuse("exponent", "must be whole: found " + number_text(force.exponent) + ", expected -3, -2, ... or 3");
}

}  // namespace ticktrue::engine
