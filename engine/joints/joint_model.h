// The joints of a scene in the engine's precision.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "engine/math/vec2.h"
#include "engine/scene/scene.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Model;
struct State;

/// A spring of the scene. `exists`: it has stiffness or damping.
struct SpringModel {
  bool exists = false;
  bool absolute = false;  // otherwise relative to the row's effective mass
  double stiffness = 0;   // absolute: N/m or N m/rad; otherwise 1/s^2
  double damping = 0;     // absolute: N s/m or N m s/rad; otherwise 1/s
};

inline constexpr std::uint32_t no_gear = 0xffffffff;

struct JointModel {
  JointKind kind = JointKind::revolute;
  bool is_plain_revolute = false;   // revolute without spring, limits and motor
  bool is_driven_revolute = false;  // revolute with a spring, limits or a motor
  std::uint32_t body_a = 0;         // id; no_reference: the world; gear: body B of its first joint
  std::uint32_t body_b = 0;         // id; gear: body B of its second joint
  Vec2 anchor_a;                    // from A's centre of mass in its frame, m; target: the point of the world
  Vec2 anchor_b;                    // from B's centre of mass in its frame, m
  Vec2 axis{1, 0};                  // unit, in A's frame
  Rotation reference;               // of B relative to A
  Real length = 0;                  // m
  bool rigid = true;                // the rows that a linear spring (distance: anything soft) would replace
  bool rigid_angle = false;         // weld: has the row that an angular spring would replace
  bool holds_angle = false;         // a rigid row holds it
  bool has_limits = false;
  Real lower = 0;  // m or rad
  Real upper = 0;
  bool has_motor = false;
  Real motor_speed = 0;      // m/s or rad/s, at the start
  Real motor_force_max = 0;  // N or N m, at the start
  SpringModel spring;        // along the axis or of the angle; motor, target: of the point (motor: of the angle too)
  SpringModel linear_spring;
  Vec2 ground_a;  // pulley: points of the world, m
  Vec2 ground_b;
  Real ratio = 1;                // pulley, gear
  std::uint32_t gear = no_gear;  // in Model::gears
  Real force_max = 0;            // N
  Real torque_max = 0;           // N m
};

/// The constants that only gears have. The coordinate of a joint is the angle of B relative to A and the reference,
/// with all turns, or the translation of B along the axis.
struct GearModel {
  std::uint32_t joints[2];  // in Model::joints
  std::uint32_t bodies[4];  // ids: A and B of the first joint, A and B of the second joint
  double start[2];          // coordinates at the start, rad or m
  double ratio;             // r
  double constant;          // of coordinate + r * coordinate
};

/// Centres of mass of a joint's bodies in their frames, m. For a joint to the world, `a` is the origin.
struct JointCenters {
  Vec2 a;
  Vec2 b;
};

/// Converts an anchor from the body's origin to its centre of mass.
Vec2 from_center(Point anchor, Vec2 center);
Rotation rotation_of(double angle_rad);
/// The axis and the reference angle of a scene's joint.
void describe_axis(JointModel& model, const Joint& joint, const JointCenters& centers);
void describe_reference(JointModel& model, const Joint& joint, const JointCenters& centers);

/// Two bodies whose collision a joint disables, first < second.
struct SeparatedPair {
  std::uint32_t first;   // id
  std::uint32_t second;  // id
  std::uint32_t gear;    // in Model::gears, of a gear; it is removed with any of its four bodies
};

/// A light body that joins heavier ones. Gauss-Seidel converges slowly here: an iteration moves the light body and
/// barely the heavy ones. Extra iterations compensate.
struct LightBody {
  std::uint32_t body;        // id
  std::uint32_t iterations;  // over the joints, instead of one
};

/// Fills model.joints, model.gears, model.light_bodies and model.separated from model.scene. Requires: model.bodies.
void make_joints(Model& model);

/// Whether a joint of the scene disables the collision of two bodies that both exist. A joint is removed with its
/// bodies, and a gear with any of its bodies.
bool are_separated(const Model& model, const State& state, std::uint32_t id_a, std::uint32_t id_b);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
