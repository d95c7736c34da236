// Gives a world of Box2D the joints of the scene.
// SPDX-License-Identifier: MIT
#if defined(TICKTRUE_HAS_BOX2D)

#include "tool/box2d/box2d_joints.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/math/trig.h"

namespace ticktrue::verifier {
namespace {

using engine::JointKind;

// Masses and arms of a joint's two bodies, Box2D units.
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
  // Of a row along a direction through two points of the world, as ours has it (joint_rows.h), 1/kg.
  double mobility(const b2Vec2& axis, const b2Vec2& at_a, const b2Vec2& at_b) const {
    const double lever_a = static_cast<double>(b2Cross(at_a - a->GetWorldCenter(), axis));
    const double lever_b = static_cast<double>(b2Cross(at_b - b->GetWorldCenter(), axis));
    return inv_mass() + inv_inertia(a) * lever_a * lever_a + inv_inertia(b) * lever_b * lever_b;
  }
  // Of the angle while the bodies are pinned at a point of the world, as ours has it, 1/(kg m^2).
  double pinned_mobility(const b2Vec2& pin) const {
    const b2Vec2 arm_a = pin - a->GetWorldCenter();
    const b2Vec2 arm_b = pin - b->GetWorldCenter();
    const double m = inv_mass(), i = inv_inertia(a), j = inv_inertia(b);
    const double xa = static_cast<double>(arm_a.x), ya = static_cast<double>(arm_a.y);
    const double xb = static_cast<double>(arm_b.x), yb = static_cast<double>(arm_b.y);
    // Schur complement of the point's mobility in that of point and angle.
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
/// Requires: `mobility` > 0 of the sprung row, where the scene gives hertz. `unit`: of absolute values.
Stiffness stiffness_of(const engine::JointSpring& spring, double mobility, double unit) {
  if (spring.absolute) return {static_cast<float>(spring.stiffness * unit), static_cast<float>(spring.damping * unit)};
  const double omega = 2 * engine::pi * spring.hertz;
  return {static_cast<float>(omega * omega / mobility),
          static_cast<float>(2 * spring.damping_ratio * omega / mobility)};
}

// Box2D adds angles up where ours repeat every turn: the reference from which B starts less than half a turn away.
float reference_of(double reference, const Pair& pair) {
  const double start = static_cast<double>(pair.b->GetAngle() - pair.a->GetAngle()) - reference;
  return static_cast<float>(reference + (start - std::remainder(start, 2 * engine::pi)));
}

}  // namespace

template <typename Definition>
void Box2dJoints::set_limits(Definition& definition, const engine::Joint& joint) const {
  if (!joint.limits) return;
  definition.enableLimit = true;
  definition.lowerTranslation = static_cast<float>(joint.limits->lower * units_.scale);
  definition.upperTranslation = static_cast<float>(joint.limits->upper * units_.scale);
}

// Errors: unsupported, for what Box2D 2.4.1 has no notion of.
Status Box2dJoints::check_known(const engine::Joint& joint, const std::string& place) const {
  const auto refuse = [&](const char* what) {
    return Error{ErrorCode::unsupported, fmt::format("{}: {}", place, what), {}};
  };
  for (const auto& spring : {joint.spring, joint.linear_spring}) {
    if (!spring) continue;
    const bool is_stiff = spring->absolute ? spring->stiffness > 0 : spring->hertz > 0;
    if (!is_stiff && spring->absolute && spring->damping > 0) return refuse("Box2D 2.4.1 has no damper alone");
  }
  switch (joint.kind) {
    case JointKind::revolute:
    case JointKind::prismatic:
      if (joint.spring) return refuse("Box2D 2.4.1 has no springs in revolute and prismatic joints");
      break;
    case JointKind::distance:
      if (joint.motor) return refuse("Box2D 2.4.1 has no motors in distance joints");
      if (!joint.limits && !joint.spring && joint.length * units_.scale < static_cast<double>(b2_linearSlop))
        return refuse("Box2D 2.4.1 has no rods shorter than its slop");
      break;
    case JointKind::weld:
      if (joint.linear_spring) return refuse("Box2D 2.4.1 has no springs for the point of weld joints");
      break;
    case JointKind::motor:
      if (joint.spring && !(joint.spring->absolute ? joint.spring->damping > 0 : joint.spring->damping_ratio >= 1))
        return refuse("Box2D 2.4.1 has no motor joints that swing");
      break;
    case JointKind::target:
      if (!joint.spring) return refuse("Box2D 2.4.1 has no rigid mouse joints");
      break;
    case JointKind::wheel:
    case JointKind::friction:
      break;
  }
  return {};
}

void Box2dJoints::set_stiffness(const Sprung& sprung) const {
  const engine::Joint& joint = *sprung.description;
  if (!joint.spring) return;
  const Pair pair{sprung.joint->GetBodyA(), sprung.joint->GetBodyB()};
  const b2Vec2 at_a = sprung.joint->GetAnchorA();
  const b2Vec2 at_b = sprung.joint->GetAnchorB();
  const auto set = [](auto* target, const Stiffness& soft) {
    target->SetStiffness(soft.stiffness);
    target->SetDamping(soft.damping);
  };
  if (joint.kind == JointKind::weld) {
    const double mobility = pair.pinned_mobility(0.5f * (at_a + at_b));
    set(static_cast<b2WeldJoint*>(sprung.joint), stiffness_of(*joint.spring, mobility, units_.scale * units_.scale));
    return;
  }
  if (joint.kind == JointKind::wheel) {  // ours acts at B's anchor on both bodies
    b2Vec2 axis = units_.scaled(joint.axis);
    axis.Normalize();
    const double mobility = pair.mobility(pair.a->GetWorldVector(axis), at_b, at_b);
    set(static_cast<b2WheelJoint*>(sprung.joint), stiffness_of(*joint.spring, mobility, 1));
    return;
  }
  b2Vec2 along = at_b - at_a;
  if (along.Normalize() < b2_epsilon) along = {1, 0};
  set(static_cast<b2DistanceJoint*>(sprung.joint), stiffness_of(*joint.spring, pair.mobility(along, at_a, at_b), 1));
}

void Box2dJoints::set_stiffness() const {
  for (const Sprung& sprung : sprung_) set_stiffness(sprung);
}

void Box2dJoints::forget(const b2Body* body) {
  const auto is_gone = [&](const Sprung& sprung) {
    return sprung.joint->GetBodyA() == body || sprung.joint->GetBodyB() == body;
  };
  sprung_.erase(std::remove_if(sprung_.begin(), sprung_.end(), is_gone), sprung_.end());
}

Status Box2dJoints::add(const engine::Joint& joint, b2Body* a, b2Body* b, const std::string& place) {
  if (Status known = check_known(joint, place); !known) return known;
  const bool to_world = joint.kind == JointKind::target;
  if (to_world && !anchorage_) {
    const b2BodyDef definition;
    anchorage_ = world_.CreateBody(&definition);
  }
  const Pair pair{to_world ? anchorage_ : a, b};
  const b2Vec2 anchor_a = units_.scaled(joint.anchor_a);
  const b2Vec2 anchor_b = units_.scaled(joint.anchor_b);
  const b2Vec2 at_b = pair.b->GetWorldPoint(anchor_b);
  b2Vec2 axis = units_.scaled(joint.axis);
  axis.Normalize();
  const auto attach = [&](b2JointDef& definition) {
    definition.bodyA = pair.a;
    definition.bodyB = pair.b;
    definition.collideConnected = joint.collide_connected || to_world;
    return world_.CreateJoint(&definition);
  };
  const auto force = [&](double newton) { return static_cast<float>(newton * units_.scale); };
  const auto torque = [&](double newton_m) { return static_cast<float>(newton_m * units_.scale * units_.scale); };
  switch (joint.kind) {
    case JointKind::revolute: {
      b2RevoluteJointDef definition;
      definition.localAnchorA = anchor_a;
      definition.localAnchorB = anchor_b;
      definition.referenceAngle = reference_of(joint.reference_angle, pair);
      if (joint.limits) {
        definition.enableLimit = true;
        definition.lowerAngle = static_cast<float>(joint.limits->lower);
        definition.upperAngle = static_cast<float>(joint.limits->upper);
      }
      if (joint.motor) {
        definition.enableMotor = true;
        definition.motorSpeed = static_cast<float>(joint.motor->speed);
        definition.maxMotorTorque = torque(joint.motor->force_max);
      }
      attach(definition);
      break;
    }
    case JointKind::prismatic: {
      b2PrismaticJointDef definition;
      definition.localAnchorA = anchor_a;
      definition.localAnchorB = anchor_b;
      definition.localAxisA = axis;
      definition.referenceAngle = reference_of(joint.reference_angle, pair);
      set_limits(definition, joint);
      if (joint.motor) {
        definition.enableMotor = true;
        definition.motorSpeed = static_cast<float>(joint.motor->speed * units_.scale);
        definition.maxMotorForce = force(joint.motor->force_max);
      }
      attach(definition);
      break;
    }
    case JointKind::wheel: {
      b2WheelJointDef definition;
      definition.localAnchorA = anchor_a;
      definition.localAnchorB = anchor_b;
      definition.localAxisA = axis;
      set_limits(definition, joint);
      if (joint.motor) {
        definition.enableMotor = true;
        definition.motorSpeed = static_cast<float>(joint.motor->speed);
        definition.maxMotorTorque = torque(joint.motor->force_max);
      }
      sprung_.push_back({attach(definition), &joint});
      break;
    }
    case JointKind::distance: {
      b2DistanceJointDef definition;
      definition.localAnchorA = anchor_a;
      definition.localAnchorB = anchor_b;
      definition.length = static_cast<float>(joint.length * units_.scale);
      if (!joint.limits && !joint.spring) definition.minLength = definition.maxLength = definition.length;
      if (joint.limits) {
        definition.minLength = static_cast<float>(joint.limits->lower * units_.scale);
        definition.maxLength = static_cast<float>(joint.limits->upper * units_.scale);
      }
      sprung_.push_back({attach(definition), &joint});
      break;
    }
    case JointKind::weld: {
      b2WeldJointDef definition;
      definition.localAnchorA = anchor_a;
      definition.localAnchorB = anchor_b;
      definition.referenceAngle = reference_of(joint.reference_angle, pair);
      sprung_.push_back({attach(definition), &joint});
      break;
    }
    case JointKind::motor: {
      b2MotorJointDef definition;
      definition.linearOffset = units_.scaled(joint.offset);
      definition.angularOffset = reference_of(joint.angle_offset, pair);
      definition.maxForce = force(joint.force_max);
      definition.maxTorque = torque(joint.torque_max);
      if (joint.spring) {
        // What is overdamped creeps back at stiffness / damping; Box2D takes this share of the error out each step.
        const double rate = joint.spring->absolute
                                ? joint.spring->stiffness / joint.spring->damping
                                : engine::pi * joint.spring->hertz / joint.spring->damping_ratio;  // 1/s
        definition.correctionFactor = std::min(1.0f, static_cast<float>(rate) * dt_);
      }
      attach(definition);
      break;
    }
    case JointKind::friction: {
      b2FrictionJointDef definition;  // ours acts at B's centre of mass
      definition.localAnchorA = pair.a->GetLocalPoint(pair.b->GetWorldCenter());
      definition.localAnchorB = pair.b->GetLocalCenter();
      definition.maxForce = force(joint.force_max);
      definition.maxTorque = torque(joint.torque_max);
      attach(definition);
      break;
    }
    case JointKind::target: {
      b2MouseJointDef definition;
      definition.target = at_b;  // where B is held; where to comes after
      definition.maxForce = force(joint.force_max);
      const Stiffness soft = stiffness_of(*joint.spring, pair.inv_mass(), 1);
      definition.stiffness = soft.stiffness;
      definition.damping = soft.damping;
      static_cast<b2MouseJoint*>(attach(definition))->SetTarget(units_.scaled(joint.offset));
      break;
    }
  }
  return {};
}

}  // namespace ticktrue::verifier

#endif
