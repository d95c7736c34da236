// What a scene says about its joints, in the engine's precision.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "engine/math/vec2.h"
#include "engine/scene/scene.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Model;

/// A spring as described; exists if it pushes or damps at all.
struct SpringModel {
  bool exists = false;
  bool absolute = false;  // else relative to the row's effective mass
  double stiffness = 0;   // absolute: N/m or N m/rad; else 1/s^2
  double damping = 0;     // absolute: N s/m or N m s/rad; else 1/s
};

struct JointModel {
  JointKind kind = JointKind::revolute;
  bool is_plain_revolute = false;   // revolute without spring, limits and motor
  bool is_driven_revolute = false;  // revolute with one of them
  std::uint32_t body_a = 0;         // id; no_reference: the world
  std::uint32_t body_b = 0;         // id
  Vec2 anchor_a;                    // from A's centre of mass in its frame, m; target: the point of the world
  Vec2 anchor_b;                    // from B's centre of mass in its frame, m
  Vec2 axis{1, 0};                  // unit, in A's frame
  Rotation reference;               // of B relative to A
  Real length = 0;                  // m
  bool rigid = true;                // the rows that a linear spring (distance: anything soft) would replace
  bool rigid_angle = false;         // weld: has the row that an angular spring would replace
  bool holds_angle = false;         // by a rigid row
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
  Real ratio = 1;
  Real force_max = 0;   // N
  Real torque_max = 0;  // N m
};

/// Centres of mass of a joint's bodies in their frames, m. A, where the joint holds B to the world: its origin.
struct JointCenters {
  Vec2 a;
  Vec2 b;
};

/// An anchor from a body's origin, from its centre of mass.
Vec2 from_center(Point anchor, Vec2 center);
Rotation rotation_of(double angle_rad);
/// The axis and the reference angle of a scene's joint.
void describe_axis(JointModel& model, const Joint& joint, const JointCenters& centers);
void describe_reference(JointModel& model, const Joint& joint, const JointCenters& centers);

/// Two bodies that a joint keeps from touching, first < second.
struct SeparatedPair {
  std::uint32_t first;   // id
  std::uint32_t second;  // id
};

/// A light body that holds heavier ones together. A pass over its joints moves it back and forth and them hardly: they
/// need several before anything moves.
struct LightBody {
  std::uint32_t body;        // id
  std::uint32_t iterations;  // over the joints, in place of one
};

/// Fills model.joints, model.hubs and model.separated from model.scene. Requires: model.bodies.
void make_joints(Model& model);

/// Whether a joint of the scene keeps two bodies from touching, as long as both exist: a joint goes with its bodies.
bool are_separated(const Model& model, std::uint32_t id_a, std::uint32_t id_b);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
