// Joints and force elements of random worlds. The tables of kinds list the fields of each kind.
// SPDX-License-Identifier: MIT
#include <algorithm>

#include "base/hash.h"
#include "engine/math/trig.h"
#include "engine/random_worlds/world_builder.h"
#include "engine/scene/hull.h"
#include "engine/scene/scene_binary.h"

namespace ticktrue::engine {
namespace {

bool is_dynamic(const Body& body) {
  return body.type == BodyType::dynamic_body;
}

/// A point of the world in a body's frame.
Point in_frame(const Body& body, Point p) {
  const SinCos rotation = pose_sin_cos(body.angle);
  const Point d{p.x - body.position.x, p.y - body.position.y};
  return {rotation.cos * d.x + rotation.sin * d.y, rotation.cos * d.y - rotation.sin * d.x};
}

/// The least mass (kg) or inertia (kg m^2) above zero of the dynamic bodies.
double least_of(const Scene& scene, double MassProperties::*property) {
  double least = 0;
  for (const Body& body : scene.bodies) {
    if (!is_dynamic(body)) continue;
    const double value = body_mass(body).*property;
    if (value > 0 && (least == 0 || value < least)) least = value;
  }
  return least > 0 ? least : 1;
}

std::vector<std::uint32_t> dynamic_bodies(const Scene& scene) {
  std::vector<std::uint32_t> list;
  for (std::uint32_t i = 0; i < scene.bodies.size(); ++i)
    if (is_dynamic(scene.bodies[i])) list.push_back(i);
  return list;
}

class JointMaker {
 public:
  JointMaker(Draw& draw, const WorldPlan& plan, double size, Scene& scene)
      : draw_(draw), plan_(plan), size_(size), scene_(scene) {}

  /// Requires: `b` is dynamic, `a` is another body. A second joint of a pair is rare, since joints that contradict each
  /// other only blow up.
  void add(JointKind kind, std::uint32_t a, std::uint32_t b) {
    if (is_joined(a, b) && !draw_.chance(5)) return;
    kind_ = kind;
    joint_ = Joint{};
    joint_.kind = kind;
    joint_.body_b = b;
    const Body& body_a = scene_.bodies[a];
    const Body& body_b = scene_.bodies[b];
    mass_ = body_mass(body_b).mass;
    // Long arms of light bodies would only blow up.
    const bool far = is_far(body_a.position, body_b.position);
    if (far && is_dynamic(body_a) && !draw_.chance(5)) return;
    if (has(JointField::ground_anchor_a)) {
      joint_.body_a = a;
      add_rope(body_a, body_b);
      add_options();
      scene_.joints.push_back(joint_);
      return;
    }
    const Point middle{(body_a.position.x + body_b.position.x) / 2, (body_a.position.y + body_b.position.y) / 2};
    const Point between = far ? body_b.position : middle;
    const bool apart = has(JointField::length) && draw_.half();
    if (has(JointField::body_a)) joint_.body_a = a;
    if (has(JointField::anchor_a)) joint_.anchor_a = apart ? Point{} : in_frame(body_a, between);
    if (has(JointField::anchor_b) && !apart && has(JointField::body_a)) joint_.anchor_b = in_frame(body_b, between);
    if (has(JointField::axis))
      joint_.axis = draw_.half() ? Point{0, 1} : Point{draw_.part(1, 4, 1), draw_.part(-4, 4, 1)};
    if (has(JointField::reference_angle) && draw_.chance(80)) joint_.reference_angle = body_b.angle - body_a.angle;
    if (has(JointField::offset))
      joint_.offset = has(JointField::body_a) ? in_frame(body_a, body_b.position) : body_b.position;
    if (has(JointField::offset) && draw_.half()) joint_.offset.x += plan_.body_count % 2 == 0 ? 0.5 : -0.25;
    if (has(JointField::force_max)) joint_.force_max = mass_ * draw_.one_of({0, 4, 32, 256});
    if (has(JointField::torque_max)) joint_.torque_max = mass_ * draw_.one_of({0, 1, 8});
    if (has(JointField::length)) add_length(apart, body_a, body_b);
    add_options();
    scene_.joints.push_back(joint_);
  }

 private:
  bool has(JointField field) const { return !key_of(info_of(joint_kinds, kind_), field).empty(); }
  bool wants(JointField field, WorldFeature feature) { return has(field) && plan_.has(feature) && draw_.chance(60); }

  bool is_joined(std::uint32_t a, std::uint32_t b) const {
    for (const Joint& joint : scene_.joints)
      if ((joint.body_a == a && joint.body_b == b) || (joint.body_a == b && joint.body_b == a)) return true;
    return false;
  }

  bool is_far(Point a, Point b) const {
    const double x = a.x - b.x, y = a.y - b.y;
    return x * x + y * y > 9 * size_ * size_;
  }

  /// The distance of the bodies' origins, or a small length for anchors at one place.
  void add_length(bool apart, const Body& a, const Body& b) {
    const double x = b.position.x - a.position.x, y = b.position.y - a.position.y;
    const double length = apart ? __builtin_sqrt(x * x + y * y) : 0.0625;
    joint_.length = length >= 0.0625 ? length : 0.0625;
  }

  /// Ground anchors above the bodies, sometimes at them: a side without a direction.
  void add_rope(const Body& a, const Body& b) {
    const auto above = [this](Point p) {
      const double aside = size_ * draw_.part(-1, 1, 2);
      return Point{p.x + aside, p.y + size_ * draw_.one_of({0, 1, 2, 4})};
    };
    const auto apart = [](Point p, Point q) {
      const double x = p.x - q.x, y = p.y - q.y;
      return __builtin_sqrt(x * x + y * y);
    };
    const Point at_b{b.position.x + (draw_.half() ? size_ / 8 : 0), b.position.y};
    joint_.anchor_b = in_frame(b, at_b);
    joint_.ground_anchor_a = above(a.position);
    joint_.ground_anchor_b = above(at_b);
    joint_.ratio = draw_.one_of({0.5, 1, 1, 2});
    const double length =
        apart(joint_.ground_anchor_a, a.position) + joint_.ratio * apart(joint_.ground_anchor_b, at_b);
    joint_.length = length >= 0.0625 ? length : 0.0625;
  }

  JointSpring draw_spring() {
    JointSpring spring;
    spring.absolute =
        plan_.has(WorldFeature::absolute_springs) && (!plan_.has(WorldFeature::joint_springs) || draw_.half());
    if (spring.absolute) {
      spring.stiffness = mass_ * draw_.one_of({0, 16, 64, 256});
      spring.damping = mass_ * draw_.one_of({0, 0.5, 4});
    } else {
      spring.hertz = draw_.one_of({0.5, 1, 2, 5, 10});
      spring.damping_ratio = draw_.one_of({0, 0.125, 0.7, 1, 2});
    }
    return spring;
  }

  void add_options() {
    if (wants(JointField::limits, WorldFeature::joint_limits)) {
      const double width = draw_.one_of({0.0625, 0.25, 0.5, 1});
      const double middle = has(JointField::length) ? joint_.length : 0;
      joint_.limits = Range{middle > width ? middle - width : has(JointField::length) ? 0 : -width, middle + width};
    }
    if (wants(JointField::motor, WorldFeature::joint_motors))
      joint_.motor = JointMotor{draw_.part(-16, 16, 4), mass_ * draw_.one_of({0, 2, 16, 128})};
    const bool has_springs = plan_.has(WorldFeature::joint_springs) || plan_.has(WorldFeature::absolute_springs);
    if (has(JointField::spring) && has_springs && draw_.chance(60)) joint_.spring = draw_spring();
    if (wants(JointField::linear_spring, WorldFeature::linear_springs)) joint_.linear_spring = draw_spring();
    // Contacts against limits that hold bodies together would only blow up.
    if (!joint_.limits && wants(JointField::collide_connected, WorldFeature::collide_connected))
      joint_.collide_connected = true;
  }

  Draw& draw_;
  const WorldPlan& plan_;
  double size_;
  Scene& scene_;
  Joint joint_;
  JointKind kind_ = JointKind::revolute;
  double mass_ = 1;  // kg, of body B
};

/// r^p for a whole p.
double whole_power(double r, int exponent) {
  double value = 1;
  for (; exponent > 0; --exponent) value *= r;
  for (; exponent < 0; ++exponent) value /= r;
  return value;
}

/// Adds gears between joints that the scene has, to three in five of the worlds with two such joints.
void add_gears(Draw& draw, const WorldPlan& plan, Scene& scene) {
  std::vector<std::uint32_t> parts;
  for (std::uint32_t i = 0; i < scene.joints.size(); ++i)
    if (traits_of(scene.joints[i].kind).has_coordinate) parts.push_back(i);
  if (parts.size() < 2 || !draw.chance(60)) return;
  for (std::uint32_t left = 1 + draw.below(3); left > 0; --left) {
    Joint gear;
    gear.kind = JointKind::gear;
    gear.joint_a = draw.any(parts);
    gear.joint_b = draw.any(parts);
    gear.ratio = draw.one_of({-2, -1, -0.5, 0.5, 1, 3});
    gear.collide_connected = plan.has(WorldFeature::collide_connected) && draw.half();
    if (scene.joints[gear.joint_a].body_b != scene.joints[gear.joint_b].body_b) scene.joints.push_back(gear);
  }
}

/// Adds joints of the kinds in the plan.
void add_planned_joints(Draw& draw, const WorldPlan& plan, const std::vector<std::uint32_t>& dynamic, double size,
                        Scene& scene) {
  JointMaker maker(draw, plan, size, scene);
  const auto count = static_cast<std::uint32_t>(scene.bodies.size());
  // A body's neighbour in the list is most often its neighbour in the world.
  const auto neighbour = [&](std::uint32_t b) {
    if (draw.chance(15)) return (b + 1 + draw.below(count - 1)) % count;
    return b == 0 ? 1 : b - 1;
  };
  for (const JointKind kind : plan.joints) {
    const std::size_t wanted = scene.joints.size() + 1 + draw.below(3);
    for (int tries = 0; tries < 12 && scene.joints.size() < wanted; ++tries) {
      const std::uint32_t b = draw.any(dynamic);
      maker.add(kind, neighbour(b), b);
    }
  }
  if (draw.chance(70)) return;
  // Adds a chain of joints.
  const std::uint32_t chained = 2 + draw.below(dynamic.size() < 40 ? static_cast<std::uint32_t>(dynamic.size()) : 40);
  const std::uint32_t first = draw.below(static_cast<std::uint32_t>(dynamic.size()));
  for (std::uint32_t i = first; i < first + chained && i < dynamic.size(); ++i) {
    const std::uint32_t b = dynamic[i];
    maker.add(draw.any(plan.joints), b == 0 ? 1 : b - 1, b);
  }
}

}  // namespace

void add_joints(Draw& draw, const WorldPlan& plan, double size, Scene& scene) {
  const std::vector<std::uint32_t> dynamic = dynamic_bodies(scene);
  if (dynamic.empty() || scene.bodies.size() < 2 || plan.joints.empty()) return;
  add_planned_joints(draw, plan, dynamic, size, scene);
  // Kinds that were added later have draws from a hash of the scene so far, so that worlds without them stay the same.
  for (std::size_t kind = static_cast<std::size_t>(JointKind::pulley); kind < joint_kinds.size(); ++kind) {
    Draw own(hash64(encode_scene(scene), kind));
    if (joins_joints(joint_kinds[kind].kind)) {
      add_gears(own, plan, scene);
      continue;
    }
    if (own.half()) continue;
    JointMaker maker(own, plan, size, scene);
    for (std::uint32_t left = 1 + own.below(3); left > 0; --left) {
      const std::uint32_t b = own.any(dynamic);
      maker.add(joint_kinds[kind].kind, b == 0 ? 1 : b - 1, b);
    }
  }
}

void add_forces(Draw& draw, const WorldPlan& plan, Scene& scene) {
  const std::vector<std::uint32_t> dynamic = dynamic_bodies(scene);
  if (dynamic.empty()) return;
  const double least_mass = least_of(scene, &MassProperties::mass);
  const double least_inertia = least_of(scene, &MassProperties::inertia);
  for (const ForceKind kind : plan.forces) {
    const auto has = [&](ForceField field) { return !key_of(info_of(force_kinds, kind), field).empty(); };
    Force force;
    force.kind = kind;
    const std::uint32_t body = draw.any(dynamic);
    double mass = least_mass, inertia = least_inertia;
    if (has(ForceField::stiffness) || (has(ForceField::body) && draw.half())) {
      force.body = body;
      mass = body_mass(scene.bodies[body]).mass;
      inertia = body_mass(scene.bodies[body]).inertia;
    }
    const Point at = scene.bodies[body].position;
    if (has(ForceField::other) && scene.bodies.size() > 1 && draw.half()) {
      force.other = body == 0 ? 1 : body - 1;
      // The lighter end decides which spring explicit steps can follow.
      const Body& other = scene.bodies[*force.other];
      if (is_dynamic(other)) {
        mass = std::min(mass, body_mass(other).mass);
        inertia = std::min(inertia, body_mass(other).inertia);
      }
    }
    // Far from every body, since a central force is unbounded near its centre.
    const double away = 64 + 4.0 * static_cast<double>(scene.bodies.size());
    if (has(ForceField::exponent)) {
      force.exponent = draw.between(-3, 3);
      force.point = {at.x + (draw.half() ? away : -away), at.y};
      force.coefficient = draw.one_of({-2, 1, 4}) / whole_power(away, static_cast<int>(force.exponent));
    } else if (has(ForceField::point) && !force.other) {
      force.point = {at.x + draw.part(-8, 8, 4), at.y + draw.part(0, 8, 4)};
    }
    if (has(ForceField::vector)) {
      const double scale = has(ForceField::body) ? mass : 1;
      force.vector = {scale * draw.part(-16, 16, 4), scale * draw.part(-16, 16, 4)};
    }
    if (has(ForceField::torque) && draw.half()) force.torque = inertia * draw.part(-8, 8, 2);
    if (has(ForceField::coefficient) && !has(ForceField::exponent))
      force.coefficient = mass * draw.one_of({0.015625, 0.125, 1});
    if (has(ForceField::angular_coefficient) && draw.half()) force.angular_coefficient = inertia / 4;
    if (has(ForceField::stiffness)) force.stiffness = mass * draw.one_of({1, 4, 16, 64});
    if (has(ForceField::damping) && draw.half()) force.damping = mass * draw.one_of({0.0625, 0.5, 2});
    if (has(ForceField::rest_length)) force.rest_length = draw.part(0, 8, 4);
    scene.forces.push_back(force);
  }
}

}  // namespace ticktrue::engine
