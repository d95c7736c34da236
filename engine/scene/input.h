// Input events: the actions of a person or a program on a world, stamped (tick, player, sequence).
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"

namespace ticktrue::engine {

struct Scene;

enum class InputKind : std::uint8_t {
  spawn,
  remove,
  impulse,
  force,
  torque,
  set_velocity,
  set_gravity,
  press,
  drag,
  release,
  end,
  set_motor,
};

using ValueNames = std::array<std::string_view, 6>;
constexpr std::size_t stated_count(const ValueNames& names) {
  std::size_t count = 0;
  while (count < names.size() && !names[count].empty()) ++count;
  return count;
}

struct InputInfo {
  InputKind kind;
  std::string_view name;
  std::string_view summary;
  ValueNames value_names{};    // JSON keys, in order
  bool has_body = false;       // `body` is used
  bool has_prototype = false;  // `prototype` is used
  bool has_joint = false;      // `joint` is used
  bool is_of_pointer = false;  // declared if and only if the scene has a pointer
  bool may_make_body = false;
  std::size_t value_count = stated_count(value_names);  // the number of `values` that are used
};
inline constexpr std::array<InputInfo, 12> input_kinds{{
    {.kind = InputKind::spawn,
     .name = "spawn",
     .summary = "makes a body from a prototype: pose of its origin (m, rad), velocity (m/s, rad/s)",
     .value_names = {"x", "y", "angle", "vx", "vy", "angular_velocity"},
     .has_prototype = true,
     .may_make_body = true},
    {.kind = InputKind::remove, .name = "remove", .summary = "removes a body", .has_body = true},
    {.kind = InputKind::impulse,
     .name = "impulse",
     .summary = "changes momentum by (ix, iy) N s, applied at (px, py) in the body's frame, from its centre of mass",
     .value_names = {"ix", "iy", "px", "py"},
     .has_body = true},
    {.kind = InputKind::force,
     .name = "force",
     .summary = "(fx, fy) N during this tick, applied at (px, py) in the body's frame, from its centre of mass",
     .value_names = {"fx", "fy", "px", "py"},
     .has_body = true},
    {.kind = InputKind::torque,
     .name = "torque",
     .summary = "N m during this tick",
     .value_names = {"torque"},
     .has_body = true},
    {.kind = InputKind::set_velocity,
     .name = "set_velocity",
     .summary = "m/s of the centre of mass and rad/s",
     .value_names = {"vx", "vy", "angular_velocity"},
     .has_body = true},
    {.kind = InputKind::set_gravity,
     .name = "set_gravity",
     .summary = "m/s^2, from this tick on",
     .value_names = {"gx", "gy"}},
    {.kind = InputKind::press,
     .name = "press",
     .summary = "the player's pointer goes down at (x, y) m: grabs the dynamic body there, or spawns on empty space",
     .value_names = {"x", "y"},
     .is_of_pointer = true,
     .may_make_body = true},
    {.kind = InputKind::drag,
     .name = "drag",
     .summary = "the pointer moves, held down",
     .value_names = {"x", "y"},
     .is_of_pointer = true},
    {.kind = InputKind::release, .name = "release", .summary = "the pointer goes up", .is_of_pointer = true},
    {.kind = InputKind::end,
     .name = "end",
     .summary = "the session ends before this tick; ends an input file, is part of no tick"},
    {.kind = InputKind::set_motor,
     .name = "set_motor",
     .summary =
         "a joint's motor: speed of B relative to A (m/s or rad/s) and its largest force (N or N m), from this tick on",
     .value_names = {"speed", "force_max"},
     .has_joint = true},
}};

/// One input event. Its row in input_kinds tells which fields are used; the other fields are zero.
struct Input {
  std::uint64_t tick = 0;  // the tick in which it acts, from 0
  std::uint8_t player = 0;
  std::uint32_t sequence = 0;  // within (tick, player); inputs apply in (player, sequence) order
  InputKind kind = InputKind::end;
  std::uint32_t body = 0;       // id
  std::uint16_t prototype = 0;  // index in Scene::prototypes
  std::uint32_t joint = 0;      // index in Scene::joints
  std::array<double, 6> values{};
  bool operator==(const Input&) const = default;
};

/// Canonical bytes of the inputs of one tick, in (player, sequence) order, without the tick. None: no bytes.
/// docs/trace_format.md, "Inputs of ticktrue.engine".
/// Requires: ascending (player, sequence).
void encode_inputs(const std::vector<Input>& inputs, Bytes& out);

/// Errors: invalid_input (unknown kind, wrong order, non-finite or out-of-limit values, a prototype that the scene does
/// not have, a kind that the scene did not declare, too many inputs, bytes left over). On success `out` holds the
/// inputs, with tick 0.
Status decode_inputs(const Scene& scene, ByteView bytes, std::vector<Input>& out);

/// Checks one input, as decode_inputs does. `place` comes first in the message.
Status check_input(const Scene& scene, const Input& input, const std::string& place);

}  // namespace ticktrue::engine
