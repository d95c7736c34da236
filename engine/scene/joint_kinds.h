// Kinds of joints: one row for each, with its name, its fields with their JSON keys, and its traits for a scene. The
// solvers' data of a kind is a row of joint_rows.h.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "engine/scene/choices.h"
#include "engine/scene/field_keys.h"

namespace ticktrue::engine {

enum class JointKind : std::uint8_t {
  revolute,
  prismatic,
  distance,
  weld,
  wheel,
  motor,
  friction,
  target,
  pulley,
  gear
};

/// Fields of Joint, except name and kind.
enum class JointField : std::uint8_t {
  body_a,
  body_b,
  anchor_a,
  anchor_b,
  axis,
  reference_angle,
  length,
  limits,
  motor,
  spring,
  linear_spring,
  offset,
  angle_offset,
  force_max,
  torque_max,
  collide_connected,
  ground_anchor_a,
  ground_anchor_b,
  ratio,
  joint_a,
  joint_b,
};

/// The quantity that the limits of a joint bound: an angle, a translation along an axis, or a distance, which is never
/// negative.
enum class JointLimits : std::uint8_t { angle, way, distance };

struct JointTraits {
  JointLimits limits = JointLimits::way;
  bool has_one_anchor = true;       // the anchors start at one point of the world: the key `anchor` may give it
  bool is_rod = false;              // without a spring, its length must be above 0
  bool is_rigid = false;            // rigid rows hold it together, unless a spring replaces them
  bool is_driven = false;           // adds energy, like a spring
  bool conserves_momentum = true;   // its impulses on A and B are opposite
  bool offset_is_of_world = false;  // the field `offset` is a point of the world
  bool has_coordinate = false;      // one angle or translation says how B is placed against A: gears may couple it
  std::uint16_t since = 0;          // version of the binary form that has the kind; 0: every version
};

struct JointKindInfo : Choice<JointKind> {
  std::array<FieldKey<JointField>, 11> keys;  // in the order of the printer
  JointTraits traits;
};

inline constexpr std::array<JointKindInfo, 10> joint_kinds{{
    {{JointKind::revolute, "revolute", "a pin: the anchors stay together, the bodies turn"},
     {{{JointField::body_a, "body_a", true},
       {JointField::body_b, "body_b", true},
       {JointField::anchor_a, "anchor_a"},
       {JointField::anchor_b, "anchor_b"},
       {JointField::reference_angle, "reference_angle"},
       {JointField::limits, "limits"},
       {JointField::motor, "motor"},
       {JointField::spring, "spring"},
       {JointField::collide_connected, "collide_connected"}}},
     {.limits = JointLimits::angle, .is_rigid = true, .has_coordinate = true}},
    {{JointKind::prismatic, "prismatic", "a slider: body B moves along an axis of body A and does not turn"},
     {{{JointField::body_a, "body_a", true},
       {JointField::body_b, "body_b", true},
       {JointField::anchor_a, "anchor_a"},
       {JointField::anchor_b, "anchor_b"},
       {JointField::axis, "axis", true},
       {JointField::reference_angle, "reference_angle"},
       {JointField::limits, "limits"},
       {JointField::motor, "motor"},
       {JointField::spring, "spring"},
       {JointField::collide_connected, "collide_connected"}}},
     {.is_rigid = true, .has_coordinate = true}},
    {{JointKind::distance, "distance", "the anchors keep their distance: a rod, a spring, or a rope with limits"},
     {{{JointField::body_a, "body_a", true},
       {JointField::body_b, "body_b", true},
       {JointField::anchor_a, "anchor_a"},
       {JointField::anchor_b, "anchor_b"},
       {JointField::length, "length", true},
       {JointField::limits, "limits"},
       {JointField::motor, "motor"},
       {JointField::spring, "spring"},
       {JointField::collide_connected, "collide_connected"}}},
     {.limits = JointLimits::distance, .has_one_anchor = false, .is_rod = true, .is_rigid = true}},
    {{JointKind::weld, "weld", "the bodies move as one"},
     {{{JointField::body_a, "body_a", true},
       {JointField::body_b, "body_b", true},
       {JointField::anchor_a, "anchor_a"},
       {JointField::anchor_b, "anchor_b"},
       {JointField::reference_angle, "reference_angle"},
       {JointField::spring, "spring"},
       {JointField::linear_spring, "linear_spring"},
       {JointField::collide_connected, "collide_connected"}}},
     {.is_rigid = true}},
    {{JointKind::wheel, "wheel", "body B turns freely and moves along an axis of body A, sprung"},
     {{{JointField::body_a, "body_a", true},
       {JointField::body_b, "body_b", true},
       {JointField::anchor_a, "anchor_a"},
       {JointField::anchor_b, "anchor_b"},
       {JointField::axis, "axis", true},
       {JointField::limits, "limits"},
       {JointField::motor, "motor"},
       {JointField::spring, "spring"},
       {JointField::collide_connected, "collide_connected"}}},
     {.is_rigid = true}},
    {{JointKind::motor, "motor", "drives body B to an offset from body A, with bounded force and torque"},
     {{{JointField::body_a, "body_a", true},
       {JointField::body_b, "body_b", true},
       {JointField::offset, "offset"},
       {JointField::angle_offset, "angle_offset"},
       {JointField::force_max, "force_max", true},
       {JointField::torque_max, "torque_max", true},
       {JointField::spring, "spring"},
       {JointField::collide_connected, "collide_connected"}}},
     {.is_driven = true}},
    {{JointKind::friction, "friction", "slows relative motion, with bounded force and torque"},
     {{{JointField::body_a, "body_a", true},
       {JointField::body_b, "body_b", true},
       {JointField::force_max, "force_max", true},
       {JointField::torque_max, "torque_max", true},
       {JointField::collide_connected, "collide_connected"}}},
     {}},
    {{JointKind::target, "target", "pulls an anchor of body B to a point of the world"},
     {{{JointField::body_b, "body_b", true},
       {JointField::anchor_b, "anchor_b"},
       {JointField::offset, "point", true},
       {JointField::force_max, "force_max", true},
       {JointField::spring, "spring"}}},
     {.is_driven = true, .conserves_momentum = false, .offset_is_of_world = true}},
    {{JointKind::pulley, "pulley", "a rope from body A over two points of the world to body B, with a ratio"},
     {{{JointField::body_a, "body_a", true},
       {JointField::body_b, "body_b", true},
       {JointField::anchor_a, "anchor_a"},
       {JointField::anchor_b, "anchor_b"},
       {JointField::ground_anchor_a, "ground_anchor_a", true},
       {JointField::ground_anchor_b, "ground_anchor_b", true},
       {JointField::length, "length", true},
       {JointField::ratio, "ratio"},
       {JointField::collide_connected, "collide_connected"}}},
     {.has_one_anchor = false, .is_rod = true, .is_rigid = true, .conserves_momentum = false}},
    {{JointKind::gear, "gear", "couples the coordinates of two earlier revolute or prismatic joints, with a ratio"},
     {{{JointField::joint_a, "joint_a", true},
       {JointField::joint_b, "joint_b", true},
       {JointField::ratio, "ratio", false, {-1e3, 1e3}},
       {JointField::collide_connected, "collide_connected"}}},
     {.has_one_anchor = false, .since = 5}},
}};
static_assert(rows_are_in_order(joint_kinds));

/// Requires: a kind of the table; so do the functions below.
constexpr const JointTraits& traits_of(JointKind kind) {
  return info_of(joint_kinds, kind).traits;
}
constexpr bool has_field(JointKind kind, JointField field) {
  return !key_of(info_of(joint_kinds, kind), field).empty();
}
/// False: the joint connects body B to the world.
constexpr bool has_body_a(JointKind kind) {
  return has_field(kind, JointField::body_a);
}
/// True: the bodies of the joint are those of two other joints.
constexpr bool joins_joints(JointKind kind) {
  return has_field(kind, JointField::joint_a);
}

}  // namespace ticktrue::engine
