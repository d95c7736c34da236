// Which fields of forces and clocks count, by kind, with their JSON keys: one table each, which reader, printer and
// checker go through. Those of joints: joint_kinds.h.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "engine/scene/choices.h"
#include "engine/scene/field_keys.h"

namespace ticktrue::engine {

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

template <typename Kind, typename Field, std::size_t count_max>
struct KindFields {
  Kind kind;
  std::array<FieldKey<Field>, count_max + 1> keys;
};

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

static_assert(rows_are_in_order(force_fields) && rows_are_in_order(clock_fields));

}  // namespace ticktrue::engine
