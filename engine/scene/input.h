// Input events: what a person or a program does to a world, stamped (tick, player, sequence).
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

struct InputInfo {
  InputKind kind;
  std::string_view name;
  bool has_body;                                // `body` counts
  bool has_prototype;                           // `prototype` counts
  bool has_joint;                               // `joint` counts
  std::uint8_t value_count;                     // how many of `values` count
  std::array<std::string_view, 6> value_names;  // JSON keys, in order
  std::string_view summary;
};
inline constexpr std::array<InputInfo, 12> input_kinds{{
    {InputKind::spawn,
     "spawn",
     false,
     true,
     false,
     6,
     {"x", "y", "angle", "vx", "vy", "angular_velocity"},
     "makes a body from a prototype: pose of its origin (m, rad), velocity (m/s, rad/s)"},
    {InputKind::remove, "remove", true, false, false, 0, {}, "removes a body"},
    {InputKind::impulse,
     "impulse",
     true,
     false,
     false,
     4,
     {"ix", "iy", "px", "py"},
     "changes momentum by (ix, iy) N s, applied at (px, py) in the body's frame, from its centre of mass"},
    {InputKind::force,
     "force",
     true,
     false,
     false,
     4,
     {"fx", "fy", "px", "py"},
     "(fx, fy) N during this tick, applied at (px, py) in the body's frame, from its centre of mass"},
    {InputKind::torque, "torque", true, false, false, 1, {"torque"}, "N m during this tick"},
    {InputKind::set_velocity,
     "set_velocity",
     true,
     false,
     false,
     3,
     {"vx", "vy", "angular_velocity"},
     "m/s of the centre of mass and rad/s"},
    {InputKind::set_gravity, "set_gravity", false, false, false, 2, {"gx", "gy"}, "m/s^2, from this tick on"},
    {InputKind::press,
     "press",
     false,
     false,
     false,
     2,
     {"x", "y"},
     "the player's pointer goes down at (x, y) m: grabs the dynamic body there, or spawns on empty space"},
    {InputKind::drag, "drag", false, false, false, 2, {"x", "y"}, "the pointer moves, held down"},
    {InputKind::release, "release", false, false, false, 0, {}, "the pointer goes up"},
    {InputKind::end,
     "end",
     false,
     false,
     false,
     0,
     {},
     "the session ends before this tick; ends an input file, is part of no tick"},
    {InputKind::set_motor,
     "set_motor",
     false,
     false,
     true,
     2,
     {"speed", "force_max"},
     "a joint's motor: speed of B relative to A (m/s or rad/s) and its largest force (N or N m), from this tick on"},
}};

/// One input event. Which fields count is said by its row in input_kinds; the others are zero.
struct Input {
  std::uint64_t tick = 0;  // the tick it acts in, from 0
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

/// Errors: invalid_input (unknown kind, order, non-finite or out-of-limit values, a prototype the scene has not, a kind
/// it did not declare, too many, bytes left over). On success `out` holds the inputs, with tick 0.
Status decode_inputs(const Scene& scene, ByteView bytes, std::vector<Input>& out);

/// What decode_inputs checks of one input. `place` comes first in the message.
Status check_input(const Scene& scene, const Input& input, const std::string& place);

}  // namespace ticktrue::engine
