// Which fields of joints, forces and clocks count, by kind, with their JSON keys: one table each, which reader, printer
// and checker go through.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "engine/scene/choices.h"

namespace ticktrue::engine {

/// Fields of Joint; all but name and kind.
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
};
inline constexpr std::size_t joint_field_count = 16;

/// Fields of Force; all but name and kind.
enum class ForceField : std::uint8_t {
  body,
  other,
  anchor,
  point,
  vector,
  torque,
  coefficient,
  angular_coefficient,
  exponent,
  stiffness,
  damping,
  rest_length,
};
inline constexpr std::size_t force_field_count = 12;

/// Fields of ClockSettings; all but kind.
enum class ClockField : std::uint8_t { ticks_per_frame_max, tolerance, dt_min, dt_max };
inline constexpr std::size_t clock_field_count = 4;

template <typename Field>
struct FieldKey {
  Field field{};
  std::string_view key;  // empty: ends the row
  bool required = false;
};
template <typename Kind, typename Field, std::size_t count_max>
struct KindFields {
  Kind kind;
  std::array<FieldKey<Field>, count_max + 1> keys;
};

inline constexpr std::array<KindFields<JointKind, JointField, 10>, joint_kinds.size()> joint_fields{{
    {JointKind::revolute,
     {{{JointField::body_a, "body_a", true},
       {JointField::body_b, "body_b", true},
       {JointField::anchor_a, "anchor_a"},
       {JointField::anchor_b, "anchor_b"},
       {JointField::reference_angle, "reference_angle"},
       {JointField::limits, "limits"},
       {JointField::motor, "motor"},
       {JointField::spring, "spring"},
       {JointField::collide_connected, "collide_connected"}}}},
    {JointKind::prismatic,
     {{{JointField::body_a, "body_a", true},
       {JointField::body_b, "body_b", true},
       {JointField::anchor_a, "anchor_a"},
       {JointField::anchor_b, "anchor_b"},
       {JointField::axis, "axis", true},
       {JointField::reference_angle, "reference_angle"},
       {JointField::limits, "limits"},
       {JointField::motor, "motor"},
       {JointField::spring, "spring"},
       {JointField::collide_connected, "collide_connected"}}}},
    {JointKind::distance,
     {{{JointField::body_a, "body_a", true},
       {JointField::body_b, "body_b", true},
       {JointField::anchor_a, "anchor_a"},
       {JointField::anchor_b, "anchor_b"},
       {JointField::length, "length", true},
       {JointField::limits, "limits"},
       {JointField::motor, "motor"},
       {JointField::spring, "spring"},
       {JointField::collide_connected, "collide_connected"}}}},
    {JointKind::weld,
     {{{JointField::body_a, "body_a", true},
       {JointField::body_b, "body_b", true},
       {JointField::anchor_a, "anchor_a"},
       {JointField::anchor_b, "anchor_b"},
       {JointField::reference_angle, "reference_angle"},
       {JointField::spring, "spring"},
       {JointField::linear_spring, "linear_spring"},
       {JointField::collide_connected, "collide_connected"}}}},
    {JointKind::wheel,
     {{{JointField::body_a, "body_a", true},
       {JointField::body_b, "body_b", true},
       {JointField::anchor_a, "anchor_a"},
       {JointField::anchor_b, "anchor_b"},
       {JointField::axis, "axis", true},
       {JointField::limits, "limits"},
       {JointField::motor, "motor"},
       {JointField::spring, "spring"},
       {JointField::collide_connected, "collide_connected"}}}},
    {JointKind::motor,
     {{{JointField::body_a, "body_a", true},
       {JointField::body_b, "body_b", true},
       {JointField::offset, "offset"},
       {JointField::angle_offset, "angle_offset"},
       {JointField::force_max, "force_max", true},
       {JointField::torque_max, "torque_max", true},
       {JointField::spring, "spring"},
       {JointField::collide_connected, "collide_connected"}}}},
    {JointKind::friction,
     {{{JointField::body_a, "body_a", true},
       {JointField::body_b, "body_b", true},
       {JointField::force_max, "force_max", true},
       {JointField::torque_max, "torque_max", true},
       {JointField::collide_connected, "collide_connected"}}}},
    {JointKind::target,
     {{{JointField::body_b, "body_b", true},
       {JointField::anchor_b, "anchor_b"},
       {JointField::offset, "point", true},
       {JointField::force_max, "force_max", true},
       {JointField::spring, "spring"}}}},
}};

inline constexpr std::array<KindFields<ForceKind, ForceField, 7>, force_kinds.size()> force_fields{{
    {ForceKind::constant,
     {{{ForceField::body, "body"}, {ForceField::vector, "force"}, {ForceField::torque, "torque"}}}},
    {ForceKind::central,
     {{{ForceField::body, "body"},
       {ForceField::point, "center"},
       {ForceField::coefficient, "coefficient", true},
       {ForceField::exponent, "exponent"}}}},
    {ForceKind::spring,
     {{{ForceField::body, "body", true},
       {ForceField::other, "other"},
       {ForceField::anchor, "anchor"},
       {ForceField::point, "point"},
       {ForceField::stiffness, "stiffness", true},
       {ForceField::damping, "damping"},
       {ForceField::rest_length, "rest_length"}}}},
    {ForceKind::wind, {{{ForceField::vector, "velocity", true}}}},
    {ForceKind::linear_drag,
     {{{ForceField::body, "body"},
       {ForceField::coefficient, "coefficient", true},
       {ForceField::angular_coefficient, "angular_coefficient"}}}},
    {ForceKind::quadratic_drag,
     {{{ForceField::body, "body"},
       {ForceField::coefficient, "coefficient", true},
       {ForceField::angular_coefficient, "angular_coefficient"}}}},
}};

inline constexpr std::array<KindFields<ClockKind, ClockField, 3>, clock_kinds.size()> clock_fields{{
    {ClockKind::fixed, {}},
    {ClockKind::semi_fixed, {{{ClockField::ticks_per_frame_max, "ticks_per_frame_max"}}}},
    {ClockKind::variable, {{{ClockField::dt_max, "dt_max"}}}},
    {ClockKind::adaptive,
     {{{ClockField::tolerance, "tolerance"}, {ClockField::dt_min, "dt_min"}, {ClockField::dt_max, "dt_max"}}}},
}};

/// The key of a field in a row of these tables; empty where the kind has no such field.
template <typename Row, typename Field>
constexpr std::string_view key_of(const Row& row, Field field) {
  for (const auto& entry : row.keys)
    if (!entry.key.empty() && entry.field == field) return entry.key;
  return {};
}

template <typename Table>
constexpr bool rows_are_in_order(const Table& table) {
  for (std::size_t i = 0; i < table.size(); ++i)
    if (static_cast<std::size_t>(table[i].kind) != i) return false;
  return true;
}
static_assert(rows_are_in_order(joint_fields) && rows_are_in_order(force_fields) && rows_are_in_order(clock_fields));

}  // namespace ticktrue::engine
