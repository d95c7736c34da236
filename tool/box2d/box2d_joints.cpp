// Creates the joints of a scene in a Box2D world.
// SPDX-License-Identifier: MIT
#if defined(TICKTRUE_HAS_BOX2D)

#include "tool/box2d/box2d_joints.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/math/trig.h"

namespace ticktrue::tool {
namespace {

using engine::JointKind;

// The two bodies of a joint, with their masses and lever arms in Box2D units.
struct Pair {
  b2Body* a;
  b2Body* b;
  double inv_mass() const {
    return inverse(static_cast<double>(a->GetMass())) + inverse(static_cast<double>(b->GetMass()));
  }
  double inv_inertia(const b2Body* body) const {
    const double mass = static_cast<double>(body->GetMass());
    const double arm = static_cast<double>(body->GetLocalCenter().LengthSquared());
    return body->IsFixedRotation() ? 0 : inverse(static_cast<double>(body->GetInertia()) - mass * arm);
  }
  static double inverse(double value) { return value > 0 ? 1 / value : 0; }
  // Inverse effective mass along an axis through two points of the world, as in engine/joints/joint_rows.h, 1/kg.
  double mobility(const b2Vec2& axis, const b2Vec2& at_a, const b2Vec2& at_b) const {
    const double lever_a = static_cast<double>(b2Cross(at_a - a->GetWorldCenter(), axis));
    const double lever_b = static_cast<double>(b2Cross(at_b - b->GetWorldCenter(), axis));
    return inv_mass() + inv_inertia(a) * lever_a * lever_a + inv_inertia(b) * lever_b * lever_b;
  }
  // Inverse effective inertia of the angle while a point of the world joins the bodies, as in the engine, 1/(kg m^2).
  double pinned_mobility(const b2Vec2& pin) const {
    const b2Vec2 arm_a = pin - a->GetWorldCenter();
    const b2Vec2 arm_b = pin - b->GetWorldCenter();
    const double m = inv_mass(), i = inv_inertia(a), j = inv_inertia(b);
    const double xa = static_cast<double>(arm_a.x), ya = static_cast<double>(arm_a.y);
    const double xb = static_cast<double>(arm_b.x), yb = static_cast<double>(arm_b.y);
    // Schur complement of the point's matrix in the matrix of point and angle.
    const double k11 = m + i * ya * ya + j * yb * yb;
    const double k12 = -(i * xa * ya + j * xb * yb);
    const double k22 = m + i * xa * xa + j * xb * xb;
    const double c1 = -(i * ya + j * yb), c2 = i * xa + j * xb;
    const double determinant = k11 * k22 - k12 * k12;
    return i + j - (k22 * c1 * c1 - 2 * k12 * c1 * c2 + k11 * c2 * c2) / determinant;
  }
};

struct Stiffness {
  float stiffness = 0;
  float damping = 0;
};
/// Requires: if the scene gives hertz, `mobility` of the spring's constraint is > 0. `unit` scales absolute values.
Stiffness stiffness_of(const engine::JointSpring& spring, double mobility, double unit) {
  if (spring.absolute) return {static_cast<float>(spring.stiffness * unit), static_cast<float>(spring.damping * unit)};
  const double omega = 2 * engine::pi * spring.hertz;
  return {static_cast<float>(omega * omega / mobility),
          static_cast<float>(2 * spring.damping_ratio * omega / mobility)};
}

// Box2D counts full turns in its angles; the engine repeats every turn. The returned reference is less than half a turn
// from the start.
float reference_of(double reference, const Pair& pair) {
  const double start = static_cast<double>(pair.b->GetAngle() - pair.a->GetAngle()) - reference;
  return static_cast<float>(reference + (start - std::remainder(start, 2 * engine::pi)));
}

template <typename B2Joint>
void set(b2Joint* joint, const Stiffness& soft) {
  static_cast<B2Joint*>(joint)->SetStiffness(soft.stiffness);
  static_cast<B2Joint*>(joint)->SetDamping(soft.damping);
}

// A joint under construction.
struct Making {
  const engine::Joint& joint;
  const Box2dUnits& units;
  float dt;
  b2World& world;
  Pair pair;
  const std::vector<b2Joint*>& earlier;  // [joint of the scene]

  float length(double meters) const { return static_cast<float>(meters * units.scale); }
  float force(double newton) const { return static_cast<float>(newton * units.scale); }
  float torque(double newton_m) const { return static_cast<float>(newton_m * units.scale * units.scale); }
  b2Vec2 axis() const {
    b2Vec2 axis = units.scaled(joint.axis);
    axis.Normalize();
    return axis;
  }
  template <typename Definition>
  void set_anchors(Definition& definition) const {
    definition.localAnchorA = units.scaled(joint.anchor_a);
    definition.localAnchorB = units.scaled(joint.anchor_b);
  }
  template <typename Definition>
  void set_limits(Definition& definition) const {
    if (!joint.limits) return;
    definition.enableLimit = true;
    definition.lowerTranslation = length(joint.limits->lower);
    definition.upperTranslation = length(joint.limits->upper);
  }
  b2Joint* attach(b2JointDef& definition) const {
    definition.bodyA = pair.a;
    definition.bodyB = pair.b;
    const bool to_world = !engine::has_body_a(joint.kind) && !engine::joins_joints(joint.kind);
    definition.collideConnected = joint.collide_connected || to_world;
    return world.CreateJoint(&definition);
  }
};

// The reason why Box2D 2.4.1 cannot represent a joint, or null.
const char* knows_all(const engine::Joint&, const Box2dUnits&) {
  return nullptr;
}

// ---- Revolute ----

const char* refuse_spring(const engine::Joint& joint, const Box2dUnits&) {
  return joint.spring ? "Box2D 2.4.1 has no springs in revolute and prismatic joints" : nullptr;
}

b2Joint* make_revolute(const Making& making) {
  const engine::Joint& joint = making.joint;
  b2RevoluteJointDef definition;
  making.set_anchors(definition);
  definition.referenceAngle = reference_of(joint.reference_angle, making.pair);
  if (joint.limits) {
    definition.enableLimit = true;
    definition.lowerAngle = static_cast<float>(joint.limits->lower);
    definition.upperAngle = static_cast<float>(joint.limits->upper);
  }
  if (joint.motor) {
    definition.enableMotor = true;
    definition.motorSpeed = static_cast<float>(joint.motor->speed);
    definition.maxMotorTorque = making.torque(joint.motor->force_max);
  }
  return making.attach(definition);
}

// ---- Prismatic ----

b2Joint* make_prismatic(const Making& making) {
  const engine::Joint& joint = making.joint;
  b2PrismaticJointDef definition;
  making.set_anchors(definition);
  definition.localAxisA = making.axis();
  definition.referenceAngle = reference_of(joint.reference_angle, making.pair);
  making.set_limits(definition);
  if (joint.motor) {
    definition.enableMotor = true;
    definition.motorSpeed = making.length(joint.motor->speed);
    definition.maxMotorForce = making.force(joint.motor->force_max);
  }
  return making.attach(definition);
}

// ---- Wheel ----

b2Joint* make_wheel(const Making& making) {
  const engine::Joint& joint = making.joint;
  b2WheelJointDef definition;
  making.set_anchors(definition);
  definition.localAxisA = making.axis();
  making.set_limits(definition);
  if (joint.motor) {
    definition.enableMotor = true;
    definition.motorSpeed = static_cast<float>(joint.motor->speed);
    definition.maxMotorTorque = making.torque(joint.motor->force_max);
  }
  return making.attach(definition);
}

void stiffen_wheel(b2Joint* made, const engine::Joint& joint, const Box2dUnits& units) {
  const Pair pair{made->GetBodyA(), made->GetBodyB()};
  b2Vec2 axis = units.scaled(joint.axis);
  axis.Normalize();
  const b2Vec2 at_b = made->GetAnchorB();  // the engine acts at B's anchor on both bodies
  const double mobility = pair.mobility(pair.a->GetWorldVector(axis), at_b, at_b);
  set<b2WheelJoint>(made, stiffness_of(*joint.spring, mobility, 1));
}

// ---- Distance ----

const char* refuse_distance(const engine::Joint& joint, const Box2dUnits& units) {
  if (joint.motor) return "Box2D 2.4.1 has no motors in distance joints";
  if (!joint.limits && !joint.spring && joint.length * units.scale < static_cast<double>(b2_linearSlop))
    return "Box2D 2.4.1 has no rods shorter than its slop";
  return nullptr;
}

b2Joint* make_distance(const Making& making) {
  const engine::Joint& joint = making.joint;
  b2DistanceJointDef definition;
  making.set_anchors(definition);
  definition.length = making.length(joint.length);
  if (!joint.limits && !joint.spring) definition.minLength = definition.maxLength = definition.length;
  if (joint.limits) {
    definition.minLength = making.length(joint.limits->lower);
    definition.maxLength = making.length(joint.limits->upper);
  }
  return making.attach(definition);
}

void stiffen_distance(b2Joint* made, const engine::Joint& joint, const Box2dUnits&) {
  const Pair pair{made->GetBodyA(), made->GetBodyB()};
  const b2Vec2 at_a = made->GetAnchorA();
  const b2Vec2 at_b = made->GetAnchorB();
  b2Vec2 along = at_b - at_a;
  if (along.Normalize() < b2_epsilon) along = {1, 0};
  set<b2DistanceJoint>(made, stiffness_of(*joint.spring, pair.mobility(along, at_a, at_b), 1));
}

// ---- Weld ----

const char* refuse_weld(const engine::Joint& joint, const Box2dUnits&) {
  return joint.linear_spring ? "Box2D 2.4.1 has no springs for the point of weld joints" : nullptr;
}

b2Joint* make_weld(const Making& making) {
  b2WeldJointDef definition;
  making.set_anchors(definition);
  definition.referenceAngle = reference_of(making.joint.reference_angle, making.pair);
  return making.attach(definition);
}

void stiffen_weld(b2Joint* made, const engine::Joint& joint, const Box2dUnits& units) {
  const Pair pair{made->GetBodyA(), made->GetBodyB()};
  const double mobility = pair.pinned_mobility(0.5f * (made->GetAnchorA() + made->GetAnchorB()));
  set<b2WeldJoint>(made, stiffness_of(*joint.spring, mobility, units.scale * units.scale));
}

// ---- Motor, friction, target ----

const char* refuse_motor(const engine::Joint& joint, const Box2dUnits&) {
  const auto& spring = joint.spring;
  const bool swings = spring && !(spring->absolute ? spring->damping > 0 : spring->damping_ratio >= 1);
  return swings ? "Box2D 2.4.1 has no motor joints that swing" : nullptr;
}

b2Joint* make_motor(const Making& making) {
  const engine::Joint& joint = making.joint;
  b2MotorJointDef definition;
  definition.linearOffset = making.units.scaled(joint.offset);
  definition.angularOffset = reference_of(joint.angle_offset, making.pair);
  definition.maxForce = making.force(joint.force_max);
  definition.maxTorque = making.torque(joint.torque_max);
  if (joint.spring) {
    // An overdamped spring returns at the rate stiffness / damping. Box2D removes the share rate * dt in each step.
    const double rate = joint.spring->absolute ? joint.spring->stiffness / joint.spring->damping
                                               : engine::pi * joint.spring->hertz / joint.spring->damping_ratio;  // 1/s
    definition.correctionFactor = std::min(1.0f, static_cast<float>(rate) * making.dt);
  }
  return making.attach(definition);
}

b2Joint* make_friction(const Making& making) {
  const Pair& pair = making.pair;
  b2FrictionJointDef definition;  // the engine's friction joint acts at B's centre of mass
  definition.localAnchorA = pair.a->GetLocalPoint(pair.b->GetWorldCenter());
  definition.localAnchorB = pair.b->GetLocalCenter();
  definition.maxForce = making.force(making.joint.force_max);
  definition.maxTorque = making.torque(making.joint.torque_max);
  return making.attach(definition);
}

const char* refuse_target(const engine::Joint& joint, const Box2dUnits&) {
  return joint.spring ? nullptr : "Box2D 2.4.1 has no rigid mouse joints";
}

b2Joint* make_target(const Making& making) {
  const engine::Joint& joint = making.joint;
  b2MouseJointDef definition;
  // The point where B is held now. The place to move to is set below.
  definition.target = making.pair.b->GetWorldPoint(making.units.scaled(joint.anchor_b));
  definition.maxForce = making.force(joint.force_max);
  const Stiffness soft = stiffness_of(*joint.spring, making.pair.inv_mass(), 1);
  definition.stiffness = soft.stiffness;
  definition.damping = soft.damping;
  b2Joint* made = making.attach(definition);
  static_cast<b2MouseJoint*>(made)->SetTarget(making.units.scaled(joint.offset));
  return made;
}

// ---- Pulley ----

b2Joint* make_pulley(const Making& making) {
  const engine::Joint& joint = making.joint;
  b2PulleyJointDef definition;
  making.set_anchors(definition);
  definition.groundAnchorA = making.units.scaled(joint.ground_anchor_a);
  definition.groundAnchorB = making.units.scaled(joint.ground_anchor_b);
  definition.lengthA = making.length(joint.length);  // only the sum of lengthA and ratio times lengthB matters
  definition.lengthB = 0;
  definition.ratio = static_cast<float>(joint.ratio);
  return making.attach(definition);
}

// ---- Gear ----

// Box2D 2.4.1 loads the velocities of the four bodies, and stores the velocity of a body that comes twice only once.
const char* refuse_gear(b2Joint* first, b2Joint* second) {
  const b2Body* const bodies[2][2] = {{first->GetBodyA(), first->GetBodyB()}, {second->GetBodyA(), second->GetBodyB()}};
  for (const b2Body* a : bodies[0])
    for (const b2Body* b : bodies[1])
      if (a == b && a->GetType() == b2_dynamicBody) return "Box2D 2.4.1 has no gears whose joints share a moving body";
  return nullptr;
}

b2Joint* make_gear(const Making& making) {
  const engine::Joint& joint = making.joint;
  b2GearJointDef definition;
  definition.joint1 = making.earlier[joint.joint_a];
  definition.joint2 = making.earlier[joint.joint_b];
  // The ratio of a length and an angle has the unit of length.
  double ratio = joint.ratio;
  const bool is_length_a = definition.joint1->GetType() == e_prismaticJoint;
  const bool is_length_b = definition.joint2->GetType() == e_prismaticJoint;
  if (is_length_a && !is_length_b) ratio *= making.units.scale;
  if (!is_length_a && is_length_b) ratio /= making.units.scale;
  definition.ratio = static_cast<float>(ratio);
  return making.attach(definition);
}

// ---- The kinds ----

struct PeerJoint {
  JointKind kind;
  const char* (*refusal)(const engine::Joint& joint, const Box2dUnits& units);
  b2Joint* (*make)(const Making& making);
  // Called before a step for a joint whose spring stiffness depends on the bodies; null: the kind has no such spring.
  void (*stiffen)(b2Joint* made, const engine::Joint& joint, const Box2dUnits& units) = nullptr;
};
constexpr std::array<PeerJoint, engine::joint_kinds.size()> peer_joints{{
    {JointKind::revolute, refuse_spring, make_revolute},
    {JointKind::prismatic, refuse_spring, make_prismatic},
    {JointKind::distance, refuse_distance, make_distance, stiffen_distance},
    {JointKind::weld, refuse_weld, make_weld, stiffen_weld},
    {JointKind::wheel, knows_all, make_wheel, stiffen_wheel},
    {JointKind::motor, refuse_motor, make_motor},
    {JointKind::friction, knows_all, make_friction},
    {JointKind::target, refuse_target, make_target},
    {JointKind::pulley, knows_all, make_pulley},
    {JointKind::gear, knows_all, make_gear},
}};
static_assert(engine::rows_are_in_order(peer_joints));

// The check for every kind of joint.
const char* refuse_damper(const engine::Joint& joint) {
  for (const auto& spring : {joint.spring, joint.linear_spring})
    if (spring && spring->absolute && spring->damping > 0 && !(spring->stiffness > 0))
      return "Box2D 2.4.1 has no damper alone";
  return nullptr;
}

}  // namespace

void Box2dJoints::set_stiffness() const {
  for (const SoftJoint& soft_joint : soft_joints_)
    info_of(peer_joints, soft_joint.description->kind).stiffen(soft_joint.joint, *soft_joint.description, units_);
}

void Box2dJoints::forget(const b2Body* body) {
  const auto is_gone = [&](const SoftJoint& soft_joint) {
    return soft_joint.joint->GetBodyA() == body || soft_joint.joint->GetBodyB() == body;
  };
  soft_joints_.erase(std::remove_if(soft_joints_.begin(), soft_joints_.end(), is_gone), soft_joints_.end());
  const auto loses_body = [body](b2GearJoint* gear) {
    for (b2Joint* part : {gear->GetJoint1(), gear->GetJoint2()})
      if (part->GetBodyA() == body || part->GetBodyB() == body) return true;
    return false;
  };
  const auto destroys = [&](b2GearJoint* gear) {
    const bool is_lost = loses_body(gear);
    if (is_lost) world_.DestroyJoint(gear);
    return is_lost;
  };
  gears_.erase(std::remove_if(gears_.begin(), gears_.end(), destroys), gears_.end());
}

Status Box2dJoints::add(const engine::Joint& joint, b2Body* a, b2Body* b, const std::string& place) {
  const PeerJoint& kind = info_of(peer_joints, joint.kind);
  const char* refusal = refuse_damper(joint);
  if (refusal == nullptr) refusal = kind.refusal(joint, units_);
  const bool is_gear = engine::joins_joints(joint.kind);
  if (is_gear) {
    a = made_[joint.joint_a]->GetBodyB();
    b = made_[joint.joint_b]->GetBodyB();
    if (refusal == nullptr) refusal = refuse_gear(made_[joint.joint_a], made_[joint.joint_b]);
  }
  if (refusal != nullptr) return Error{ErrorCode::unsupported, fmt::format("{}: {}", place, refusal), {}};
  const bool to_world = !is_gear && !engine::has_body_a(joint.kind);
  if (to_world && !anchorage_) {
    const b2BodyDef definition;
    anchorage_ = world_.CreateBody(&definition);
  }
  b2Joint* made = kind.make({joint, units_, dt_, world_, {to_world ? anchorage_ : a, b}, made_});
  made_.push_back(made);
  if (is_gear) gears_.push_back(static_cast<b2GearJoint*>(made));
  if (joint.spring && kind.stiffen != nullptr) soft_joints_.push_back({made, &joint});
  return {};
}

}  // namespace ticktrue::tool

#endif
