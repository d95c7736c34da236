// Joints of a R.U.B.E. file: one function for each type.
// SPDX-License-Identifier: MIT
// Source: Catto, Box2D manual 2.3 (the meaning of the values).
#include "tool/import/rube_joints.h"

#include <cstddef>
#include <utility>

#include "engine/json/number_text.h"
#include "engine/math/trig.h"
#include "engine/scene/hull.h"
#include "engine/scene/joint_kinds.h"

namespace ticktrue::tool {
namespace {

using engine::Body;
using engine::BodyType;
using engine::Joint;
using engine::JointKind;
using engine::JointSpring;
using engine::Point;
using engine::Range;

constexpr double default_correction = 0.3;  // share of a motor joint's error removed per step; Box2D's default

class RubeJoint {
 public:
  RubeJoint(RubeReader& in, const RubeIds& body_ids, RubeIds& joint_ids, RubeNames& names, engine::Scene& scene)
      : in_(in), body_ids_(body_ids), joint_ids_(joint_ids), names_(names), scene_(scene) {}

  void read(const RubePlace& at) {
    joint_ids_.emplace_back();
    const std::string type = in_.text(at, "type");
    if (type == "gear") return;
    Joint joint;
    const std::size_t body_count = body_ids_.size();
    for (const char* key : {"bodyA", "bodyB"})
      if (!at.has(key)) return in_.fail(ErrorCode::invalid_scene, at, "found no \"" + std::string(key) + "\"");
    if (body_count == 0)
      return in_.fail(ErrorCode::invalid_scene, at, "found a joint, expected none: there are no bodies");
    const auto last = static_cast<std::int64_t>(body_count) - 1;
    const auto place_a = static_cast<std::size_t>(in_.whole(at, "bodyA", 0, last, 0));
    const auto place_b = static_cast<std::size_t>(in_.whole(at, "bodyB", 0, last, 0));
    if (in_.has_failed()) return;
    if (type == "pulley") return in_.note("not imported: " + RubeReader::label(at) + ": " + type);
    const auto is_dynamic = [&](std::uint32_t body) { return scene_.bodies[body].type == BodyType::dynamic_body; };
    if (place_a == place_b)
      return in_.fail(ErrorCode::invalid_scene, at, "found body " + std::to_string(place_a) + " twice, expected two");
    if (!body_ids_[place_a] || !body_ids_[place_b])
      return in_.note("not imported: " + RubeReader::label(at) + ": one of its bodies is inactive");
    joint.body_a = *body_ids_[place_a];
    joint.body_b = *body_ids_[place_b];
    if (!is_dynamic(joint.body_b) && (type == "mouse" || !is_dynamic(joint.body_a)))
      return in_.note("not imported: " + RubeReader::label(at) + ": joins nothing that moves freely");
    joint.name = names_.take(in_.name_of(at));
    joint.collide_connected = in_.flag(at, "collideConnected");
    joint.anchor_a = in_.point(at, "anchorA");
    joint.anchor_b = in_.point(at, "anchorB");
    in_.use(at, "jointSpeed");  // the last speed of the joint is not a setting

    if (type == "revolute")
      read_revolute(at, joint);
    else if (type == "prismatic")
      read_prismatic(at, joint);
    else if (type == "distance")
      read_distance(at, joint);
    else if (type == "rope")
      read_rope(at, joint);
    else if (type == "wheel")
      read_wheel(at, joint);
    else if (type == "weld")
      read_weld(at, joint);
    else if (type == "motor")
      read_motor_joint(at, joint);
    else if (type == "friction")
      read_friction(at, joint);
    else if (type == "mouse")
      read_mouse(at, joint);
    else if (at.has("type"))
      in_.refuse(at.at("type"),
                 "revolute, prismatic, distance, rope, wheel, weld, motor, friction, mouse, gear or pulley");
    else
      in_.fail(ErrorCode::invalid_scene, at, "found no \"type\"");
    if (in_.has_failed()) return;
    in_.count_ignored(at, "joint");
    joint_ids_.back() = static_cast<std::uint32_t>(scene_.joints.size());
    scene_.joints.push_back(std::move(joint));
  }

 private:
  void read_limits(const RubePlace& at, Joint& joint) {
    const double lower = in_.number(at, "lowerLimit");
    const double upper = in_.number(at, "upperLimit");
    if (!in_.flag(at, "enableLimit")) return;
    // A limit that is missing in the file is 0.
    if (lower > upper && at.has("lowerLimit"))
      in_.refuse(at.at("lowerLimit"), "at most upperLimit: " + engine::number_text(upper));
    else if (lower > upper)
      in_.refuse(at.at("upperLimit"), "at least 0, since there is no lowerLimit");
    joint.limits = Range{lower, upper};
  }
  void read_motor(const RubePlace& at, const char* force_key, Joint& joint) {
    const double speed = in_.number(at, "motorSpeed");
    const double force_max = in_.number(at, force_key);
    if (in_.flag(at, "enableMotor")) joint.motor = engine::JointMotor{speed, force_max};
  }
  void read_axis(const RubePlace& at, Joint& joint) {
    in_.use(at, "localAxisA");
    const char* key = at.has("localAxisA") ? "localAxisA" : "localAxis1";  // the older name
    joint.axis = in_.point(at, key);
    const bool has_length = joint.axis.x * joint.axis.x + joint.axis.y * joint.axis.y > 0;
    if (!in_.has_failed() && !has_length) in_.fail(ErrorCode::invalid_scene, at, "found no axis of a length");
  }
  /// In Box2D, a frequency of 0 means no spring.
  void read_spring(const RubePlace& at, const char* frequency_key, const char* ratio_key, Joint& joint) {
    JointSpring spring;
    spring.hertz = in_.number(at, frequency_key);
    spring.damping_ratio = in_.number(at, ratio_key);
    if (spring.hertz > 0) joint.spring = spring;
  }

  /// Box2D derives the stiffness of this spring from masses and inertias. `hertz` in a scene also depends on the
  /// distance of the anchor from the centre of mass, so the spring gets absolute values.
  JointSpring absolute_spring(const JointSpring& spring, double inertia) const {
    const double omega = 2 * engine::pi * spring.hertz;
    return {true, 0, 0, inertia * omega * omega, 2 * spring.damping_ratio * omega * inertia};
  }
  double inertia_of(std::uint32_t body) const { return engine::body_mass(scene_.bodies[body]).inertia; }

  void read_revolute(const RubePlace& at, Joint& joint) {
    joint.kind = JointKind::revolute;
    joint.reference_angle = in_.number(at, "refAngle");
    read_limits(at, joint);
    read_motor(at, "maxMotorTorque", joint);
  }
  void read_prismatic(const RubePlace& at, Joint& joint) {
    joint.kind = JointKind::prismatic;
    joint.reference_angle = in_.number(at, "refAngle");
    read_axis(at, joint);
    read_limits(at, joint);
    read_motor(at, "maxMotorForce", joint);
  }
  void read_distance(const RubePlace& at, Joint& joint) {
    joint.kind = JointKind::distance;
    joint.length = in_.number(at, "length");
    read_spring(at, "frequency", "dampingRatio", joint);
  }
  void read_rope(const RubePlace& at, Joint& joint) {
    joint.kind = JointKind::distance;
    joint.length = in_.number(at, "maxLength");
    joint.limits = Range{0, joint.length};
    joint.spring.emplace().absolute = true;  // without stiffness
  }
  void read_wheel(const RubePlace& at, Joint& joint) {
    joint.kind = JointKind::wheel;
    read_axis(at, joint);
    read_motor(at, "maxMotorTorque", joint);
    read_spring(at, "springFrequency", "springDampingRatio", joint);
  }
  void read_weld(const RubePlace& at, Joint& joint) {
    joint.kind = JointKind::weld;
    joint.reference_angle = in_.number(at, "refAngle");
    read_spring(at, "frequency", "dampingRatio", joint);
    const double inertia_a = inertia_of(joint.body_a), inertia_b = inertia_of(joint.body_b);
    const double inverse = (inertia_a > 0 ? 1 / inertia_a : 0) + (inertia_b > 0 ? 1 / inertia_b : 0);
    if (joint.spring && inverse > 0) joint.spring = absolute_spring(*joint.spring, 1 / inverse);
  }
  void read_motor_joint(const RubePlace& at, Joint& joint) {
    joint.kind = JointKind::motor;
    joint.offset = std::exchange(joint.anchor_a, {});  // the format stores the offset under this key
    joint.anchor_b = {};
    joint.angle_offset = in_.number(at, "refAngle");
    joint.force_max = in_.number(at, "maxForce");
    joint.torque_max = in_.number(at, "maxTorque");
    const double factor = in_.number(at, "correctionFactor", default_correction);
    if (in_.has_failed()) return;
    if (!(factor > 0 && factor <= 1)) return in_.refuse(at.at("correctionFactor"), "above 0, at most 1");
    // Each step removes the share `factor` of the error. An overdamped spring returns at the rate omega / (2
    // damping_ratio), which is set to factor / dt.
    const double hertz = 1 / scene_.settings.dt;
    joint.spring = JointSpring{false, hertz, engine::pi / factor, 0, 0};
  }
  void read_friction(const RubePlace& at, Joint& joint) {
    joint.kind = JointKind::friction;
    if (joint.anchor_b != Point{})
      in_.note("not imported: " + RubeReader::label(at) +
               ": anchors; it acts at the centre of mass of its second body");
    joint.anchor_a = joint.anchor_b = {};
    joint.force_max = in_.number(at, "maxForce");
    joint.torque_max = in_.number(at, "maxTorque");
  }
  /// Box2D grips B at the point where the target is when the joint is created.
  void read_mouse(const RubePlace& at, Joint& joint) {
    const Body& body = scene_.bodies[joint.body_b];
    joint.kind = JointKind::target;
    joint.body_a = 0;
    joint.anchor_a = {};
    joint.collide_connected = false;
    joint.offset = in_.point(at, "target");
    joint.anchor_b = rotated_point(-body.angle, {joint.offset.x - body.position.x, joint.offset.y - body.position.y});
    joint.force_max = in_.number(at, "maxForce");
    read_spring(at, "frequency", "dampingRatio", joint);
    if (joint.spring) joint.spring = absolute_spring(*joint.spring, engine::body_mass(body).mass);
  }

  RubeReader& in_;
  const RubeIds& body_ids_;
  RubeIds& joint_ids_;
  RubeNames& names_;
  engine::Scene& scene_;
};

}  // namespace

void read_rube_joint(RubeReader& in, const RubePlace& at, const RubeIds& body_ids, RubeIds& joint_ids, RubeNames& names,
                     engine::Scene& scene) {
  RubeJoint(in, body_ids, joint_ids, names, scene).read(at);
}

void read_rube_gear(RubeReader& in, const RubePlace& at, const RubeIds& joint_ids, RubeNames& names,
                    engine::Scene& scene) {
  if (in.text(at, "type") != "gear") return;
  const auto leave_out = [&](const std::string& why) {
    in.note("not imported: " + RubeReader::label(at) + ": gear, " + why);
  };
  Joint gear;
  gear.kind = JointKind::gear;
  std::uint32_t* const parts[] = {&gear.joint_a, &gear.joint_b};
  const char* const keys[] = {"joint1", "joint2"};
  for (std::size_t i = 0; i < 2; ++i) {
    if (!at.has(keys[i])) return leave_out("which names no " + std::string(keys[i]));
    const auto last = static_cast<std::int64_t>(joint_ids.size()) - 1;
    const auto place = static_cast<std::size_t>(in.whole(at, keys[i], 0, last, 0));
    if (in.has_failed()) return;
    if (!joint_ids[place]) return leave_out("a joint of which was not imported");
    *parts[i] = *joint_ids[place];
    if (!traits_of(scene.joints[*parts[i]].kind).has_coordinate)
      return leave_out("a joint of which is neither revolute nor prismatic");
  }
  if (scene.joints[gear.joint_a].body_b == scene.joints[gear.joint_b].body_b)
    return leave_out("both joints of which have the same bodyB");
  gear.ratio = at.has("ratio") ? in.number(at, "ratio") : 1;
  const double size = gear.ratio < 0 ? -gear.ratio : gear.ratio;
  if (in.has_failed()) return;
  if (!(size >= 1e-3 && size <= 1e3)) return leave_out("the ratio of which is 0 or extreme");
  gear.name = names.take(in.name_of(at));
  gear.collide_connected = in.flag(at, "collideConnected");
  for (const char* key : {"bodyA", "bodyB", "anchorA", "anchorB", "jointSpeed"}) in.use(at, key);  // of its joints
  in.count_ignored(at, "joint");
  scene.joints.push_back(std::move(gear));
}

}  // namespace ticktrue::tool
