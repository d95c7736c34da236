// The rules of inputs and their canonical bytes.
// SPDX-License-Identifier: MIT
#include "engine/scene/input.h"

#include <string_view>

#include "base/limits.h"
#include "base/state/state_view.h"
#include "engine/json/number_text.h"
#include "engine/scene/scene.h"

namespace ticktrue::engine {
namespace {

struct ValueLimit {
  std::string_view name;
  double max;  // of the magnitude
};
// Every name in input_kinds. Impulses and forces: enough to give the largest mass the largest speed.
constexpr std::array<ValueLimit, 17> value_limits{{
    {"x", limits::coordinate_max_m},
    {"y", limits::coordinate_max_m},
    {"px", limits::coordinate_max_m},
    {"py", limits::coordinate_max_m},
    {"angle", 1e6},
    {"vx", limits::speed_max},
    {"vy", limits::speed_max},
    {"angular_velocity", limits::speed_max},
    {"gx", limits::speed_max},
    {"gy", limits::speed_max},
    {"ix", limits::mass_max_kg* limits::speed_max},
    {"iy", limits::mass_max_kg* limits::speed_max},
    {"fx", limits::mass_max_kg* limits::speed_max},
    {"fy", limits::mass_max_kg* limits::speed_max},
    {"torque", limits::mass_max_kg* limits::speed_max},
    {"speed", limits::speed_max},
    {"force_max", limits::mass_max_kg* limits::speed_max},
}};

constexpr double value_max(std::string_view name) {
  for (const ValueLimit& limit : value_limits)
    if (limit.name == name) return limit.max;
  return 0;
}
constexpr bool every_value_has_a_limit() {
  for (const InputInfo& info : input_kinds)
    for (std::size_t i = 0; i < info.value_count; ++i)
      if (value_max(info.value_names[i]) == 0) return false;
  return true;
}
static_assert(every_value_has_a_limit());

Error refused(const std::string& place, const std::string& what, std::string hint = {}) {
  return Error{ErrorCode::invalid_input, place + ": " + what, std::move(hint)};
}

}  // namespace

Status check_input(const Scene& scene, const Input& input, const std::string& place) {
  if (static_cast<std::size_t>(input.kind) >= input_kinds.size())
    return refused(place, "kind: unknown: found number " + std::to_string(static_cast<unsigned>(input.kind)) +
                              ", expected " + choice_names(input_kinds));
  const InputInfo& info = info_of(input_kinds, input.kind);
  if (input.tick >= limits::tick_count_max)
    return refused(place, "tick: out of range: found " + std::to_string(input.tick) + ", expected 0.." +
                              std::to_string(limits::tick_count_max - 1));
  bool declared = input.kind == InputKind::end;
  for (const InputKind kind : scene.inputs) declared = declared || kind == input.kind;
  if (!declared) {
    std::string names;
    for (const InputKind kind : scene.inputs)
      names += (names.empty() ? "" : ", ") + std::string(info_of(input_kinds, kind).name);
    return refused(place,
                   "kind: not declared by scene " + scene.name + ": found " + std::string(info.name) + ", expected " +
                       (names.empty() ? "none: it takes no inputs" : names),
                   "declare it in the scene's \"inputs\"");
  }
  if (info.has_body && input.body == no_reference)
    return refused(place, "body: no body has this id: found " + std::to_string(input.body));
  if (info.has_prototype && input.prototype >= scene.prototypes.size())
    return refused(place, "prototype: unknown: found number " + std::to_string(input.prototype) + ", expected 0.." +
                              std::to_string(scene.prototypes.size() - 1));
  if (info.has_joint) {
    if (input.joint >= scene.joints.size())
      return refused(place, "joint: unknown: found number " + std::to_string(input.joint) + ", expected less than " +
                                std::to_string(scene.joints.size()));
    if (!scene.joints[input.joint].motor)
      return refused(place, "joint: has no motor: found number " + std::to_string(input.joint),
                     "give the joint a \"motor\" in the scene; force_max may be 0");
  }
  for (std::size_t i = 0; i < info.value_count; ++i) {
    const double value = input.values[i];
    const double max = value_max(info.value_names[i]);
    const double min = info.value_names[i] == "force_max" ? 0 : -max;
    if (value >= min && value <= max) continue;
    const bool finite = value - value == 0;
    return refused(place, std::string(info.value_names[i]) + (finite ? ": out of range" : ": must be finite") +
                              ": found " + number_text(value) + ", expected " + number_text(min) + ".." +
                              number_text(max));
  }
  return {};
}

void encode_inputs(const std::vector<Input>& inputs, Bytes& out) {
  ByteWriter writer;
  for (const Input& input : inputs) {
    const InputInfo& info = info_of(input_kinds, input.kind);
    writer.u8(input.player);
    writer.u32(input.sequence);
    writer.u8(static_cast<std::uint8_t>(input.kind));
    if (info.has_body) writer.u32(input.body);
    if (info.has_prototype) writer.u16(input.prototype);
    if (info.has_joint) writer.u32(input.joint);
    for (std::size_t i = 0; i < info.value_count; ++i) writer.f64(input.values[i]);
  }
  out = writer.take();
}

Status decode_inputs(const Scene& scene, ByteView bytes, std::vector<Input>& out) {
  out.clear();
  ByteReader reader(bytes);
  while (!reader.at_end()) {
    const std::string place = "input " + std::to_string(out.size());
    if (out.size() == limits::inputs_per_tick_max)
      return refused(place,
                     "too many inputs in one tick: expected at most " + std::to_string(limits::inputs_per_tick_max));
    Input input;
    input.player = reader.u8();
    input.sequence = reader.u32();
    const std::uint8_t kind = reader.u8();
    if (kind >= input_kinds.size())
      return refused(place,
                     "kind: unknown: found number " + std::to_string(kind) + ", expected " + choice_names(input_kinds));
    input.kind = static_cast<InputKind>(kind);
    const InputInfo& info = info_of(input_kinds, input.kind);
    if (info.has_body) input.body = reader.u32();
    if (info.has_prototype) input.prototype = reader.u16();
    if (info.has_joint) input.joint = reader.u32();
    for (std::size_t i = 0; i < info.value_count; ++i) input.values[i] = reader.f64();
    if (!reader.ok()) return refused(place, "bytes end inside it: found " + std::to_string(bytes.size()) + " in all");
    if (input.kind == InputKind::end)
      return refused(place, "kind: end is part of no tick", "a session ends before the tick of its end");
    if (Status status = check_input(scene, input, place); !status) return status;
    if (!out.empty()) {
      const Input& last = out.back();
      if (input.player < last.player || (input.player == last.player && input.sequence <= last.sequence))
        return refused(place, "out of order: found (player " + std::to_string(input.player) + ", sequence " +
                                  std::to_string(input.sequence) + ") after (player " + std::to_string(last.player) +
                                  ", sequence " + std::to_string(last.sequence) + "), expected ascending");
    }
    out.push_back(input);
  }
  return {};
}

}  // namespace ticktrue::engine
