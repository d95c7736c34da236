// The rules of a scene as a whole: counts, settings, inputs, bounds; and the parts of all rules.
// SPDX-License-Identifier: MIT
#include "engine/scene/scene_rules.h"

#include <utility>

#include "base/bytes.h"

namespace ticktrue::engine {
namespace {

bool is_finite(double value) {
  return value - value == 0;
}

/// Valid UTF-8 without control characters, which can be printed and stored in JSON unchanged.
bool is_printable(std::string_view text) {
  std::size_t i = 0;
  while (i < text.size()) {
    const auto lead = static_cast<unsigned char>(text[i++]);
    if (lead < 0x20 || lead == 0x7f) return false;
    if (lead < 0x80) continue;
    const int follow_count = lead >= 0xc2 && lead < 0xe0   ? 1
                             : lead >= 0xe0 && lead < 0xf0 ? 2
                             : lead >= 0xf0 && lead < 0xf5 ? 3
                                                           : 0;
    if (follow_count == 0) return false;
    std::uint32_t code = lead & (0x3fu >> follow_count);
    for (int k = 0; k < follow_count; ++k, ++i) {
      if (i == text.size() || (static_cast<unsigned char>(text[i]) & 0xc0) != 0x80) return false;
      code = code << 6 | (static_cast<unsigned char>(text[i]) & 0x3fu);
    }
    const bool overlong = (follow_count == 2 && code < 0x800) || (follow_count == 3 && code < 0x10000);
    if (overlong || (code >= 0xd800 && code < 0xe000) || code > 0x10ffff) return false;
  }
  return true;
}

}  // namespace

bool declares(const Scene& scene, InputKind kind) {
  for (const InputKind declared : scene.inputs)
    if (declared == kind) return true;
  return false;
}

Status SceneRules::run() {
  const bool good = check_counts() && check_settings() && check_bodies(scene_.bodies, "bodies") &&
                    check_bodies(scene_.prototypes, "prototypes") && check_joints() && check_forces() &&
                    check_inputs() && check_pointer() && check_fields(scene_) && check_choices();
  if (good) return {};
  return error_;
}

std::string SceneRules::place(const std::string& key) const {
  std::string text = source_ + ": ";
  if (list_ != nullptr) {
    text += std::string(list_) + "[" + std::to_string(item_index_) + "]";
    if (shape_index_ != no_shape) text += ".shapes[" + std::to_string(shape_index_) + "]";
    if (!key.empty()) text += ".";
  }
  return text + prefix_ + key;
}

bool SceneRules::fail(ErrorCode code, const std::string& key, const std::string& what, std::string hint) {
  error_ = Error{code, place(key) + ": " + what, std::move(hint)};
  return false;
}

bool SceneRules::refuse(const std::string& key, const std::string& what, std::string hint) {
  return fail(ErrorCode::invalid_scene, key, what, std::move(hint));
}

bool SceneRules::number(std::string_view key, double value, FieldRange range, int index, const char* hint) {
  if (value >= range.min && value <= range.max) return true;
  const std::string name = std::string(key) + (index < 0 ? "" : "[" + std::to_string(index) + "]");
  const char* what = !is_finite(value)             ? "must be finite"
                     : range.min > 0 && value <= 0 ? "must be > 0"
                     : range.min == 0 && value < 0 ? "must be >= 0"
                                                   : "out of range";
  return refuse(name,
                std::string(what) + ": found " + number_text(value) + ", expected " + number_text(range.min) + ".." +
                    number_text(range.max),
                hint);
}

bool SceneRules::name(std::string_view key, const std::string& value) {
  if (value.size() > limits::name_size_max)
    return fail(ErrorCode::limit, std::string(key),
                "too long: found " + std::to_string(value.size()) + " bytes, expected at most " +
                    std::to_string(limits::name_size_max));
  if (!is_printable(value))
    return refuse(std::string(key), "must be UTF-8 without control characters: found other bytes");
  return true;
}

bool SceneRules::check_value(std::string_view key, const Bounds& value, FieldRange, const char*) {
  if (!check_fields(value, key)) return false;
  const auto ascend = [&](const char* axis, double lower, double upper) {
    return lower < upper ||
           refuse(std::string(key) + ".upper[" + axis + "]",
                  "must be above lower: found " + number_text(upper) + ", expected more than " + number_text(lower));
  };
  return ascend("0", value.lower.x, value.upper.x) && ascend("1", value.lower.y, value.upper.y);
}

bool SceneRules::unique(const std::string& text, Names& names) {
  if (text.empty()) return true;
  const auto [at, is_new] = names.emplace(text, item_index_);
  return is_new || refuse("name",
                          "must be unique: found \"" + text + "\", which " + list_ + "[" + std::to_string(at->second) +
                              "] has already",
                          "leave a name out where none is needed");
}

bool SceneRules::check_counts() {
  if (!name("name", scene_.name)) return false;
  bool good = true;
  const auto count = [&](const FieldInfo& field, std::size_t found) {
    const auto max = static_cast<std::size_t>(field.range.max);
    if (good && found > max)
      good = fail(ErrorCode::limit, std::string(field.name),
                  "too many: found " + std::to_string(found) + ", expected at most " + std::to_string(max));
  };
  visit_fields(
      [&](const FieldInfo& field, const auto& value) {
        if constexpr (requires { value[0].name; }) count(field, value.size());
      },
      scene_);
  if (!good) return false;
  if (scene_.bodies.empty() && scene_.prototypes.empty())
    return refuse("bodies", "nothing to simulate: found no body and no prototype, expected at least one");
  return true;
}

bool SceneRules::check_settings() {
  bool good = true;
  prefix_ = "settings.";
  visit_fields(
      [&](const FieldInfo& field, const auto& value) {
        good = good &&
               (field.name == "substeps" ? check_substeps() : check_value(field.name, value, field.range, field.hint));
      },
      scene_.settings);
  prefix_.clear();
  return good && point("gravity", scene_.gravity, ranges::speed);
}

bool SceneRules::check_substeps() {
  const int least = scene_.settings.substeps;
  if (!scene_.settings.auto_substeps) return number("substeps", least, ranges::substeps);
  const int most = scene_.settings.auto_substeps->substeps_max;
  if (!number("substeps.least", least, ranges::substeps) || !check_fields(*scene_.settings.auto_substeps, "substeps"))
    return false;
  if ((most & (most - 1)) != 0)
    return refuse("substeps.most", "must be a power of two: found " + std::to_string(most) +
                                       ", expected 1, 2, 4, 8, ... or " + std::to_string(limits::substep_count_max));
  return least <= most || refuse("substeps.least", "must not be above most: found " + std::to_string(least) +
                                                       ", expected at most " + std::to_string(most));
}

bool SceneRules::check_value(std::string_view key, const ClockSettings& clock, FieldRange, const char*) {
  if (!row(key, clock_kinds, clock.kind)) return false;
  const std::size_t size = prefix_.size();
  prefix_.append(key).append(".");
  const bool good = check_own_fields(clock, info_of(clock_kinds, clock.kind), "a clock of kind ", "",
                                     [this](const auto& field, std::string_view name, double value, FieldRange range) {
                                       return check_value(name, value, range, field.hint);
                                     }) &&
                    (clock.kind != ClockKind::adaptive || clock.dt_min <= clock.dt_max ||
                     refuse("dt_min", "must not be above dt_max: found " + number_text(clock.dt_min) +
                                          ", expected at most " + number_text(clock.dt_max)));
  prefix_.resize(size);
  return good;
}

bool SceneRules::check_inputs() {
  for (std::size_t i = 0; i < scene_.inputs.size(); ++i) {
    const std::string key = "inputs[" + std::to_string(i) + "]";
    const InputKind kind = scene_.inputs[i];
    if (!is_row(input_kinds, kind))
      return refuse(key, "unknown: found number " + std::to_string(static_cast<unsigned>(kind)) + ", expected " +
                             choice_names(input_kinds));
    if (i > 0 && kind <= scene_.inputs[i - 1]) {
      const bool twice = kind == scene_.inputs[i - 1];
      return refuse(key,
                    std::string(twice ? "declared twice" : "out of order") + ": found " +
                        std::string(info_of(input_kinds, kind).name) + " after " +
                        std::string(info_of(input_kinds, scene_.inputs[i - 1]).name) +
                        ", expected each once, ascending",
                    "the order is: " + choice_names(input_kinds));
    }
  }
  if (declares(scene_, InputKind::spawn) && scene_.prototypes.empty())
    return refuse("inputs", "spawn is declared, but there is nothing to spawn: found no prototypes");
  if (declares(scene_, InputKind::set_motor)) {
    bool some_motor = false;
    for (const Joint& joint : scene_.joints) some_motor = some_motor || joint.motor;
    if (!some_motor)
      return refuse("inputs", "set_motor is declared, but there is no motor to set: found no joint with one",
                    "give a joint a \"motor\"; its force_max may be 0");
  }
  for (const InputInfo& info : input_kinds) {
    if (!info.is_of_pointer || declares(scene_, info.kind) == scene_.pointer.has_value()) continue;
    const std::string kind_name(info.name);
    if (scene_.pointer)
      return refuse("inputs", "a pointer presses, drags and releases: found no " + kind_name,
                    "declare press, drag and release, or leave the pointer out");
    return refuse("pointer", "missing: found " + kind_name + " among the inputs, expected a pointer",
                  "\"pointer\": {} has useful defaults");
  }
  return true;
}

bool SceneRules::check_pointer() {
  if (!scene_.pointer) return true;
  const PointerSettings& pointer = *scene_.pointer;
  if (pointer.spawns.size() > limits::prototype_count_max)
    return fail(ErrorCode::limit, "pointer.spawns",
                "too many: found " + std::to_string(pointer.spawns.size()) + ", expected at most " +
                    std::to_string(limits::prototype_count_max));
  for (std::size_t i = 0; i < pointer.spawns.size(); ++i) {
    bool known = false;
    std::string names;
    for (const Body& prototype : scene_.prototypes) {
      known = known || prototype.name == pointer.spawns[i];
      if (names.size() < limits::name_size_max) names += (names.empty() ? "" : ", ") + prototype.name;
    }
    if (!known)
      return refuse("pointer.spawns[" + std::to_string(i) + "]",
                    "no prototype has this name: found \"" +
                        (is_printable(pointer.spawns[i]) ? pointer.spawns[i] : std::string("?")) + "\", expected " +
                        (names.empty() ? "none: there are no prototypes" : "one of " + names));
  }
  return check_fields(pointer, "pointer");
}

Status check_scene(const Scene& scene, const std::string& source) {
  return SceneRules(scene, source).run();
}

}  // namespace ticktrue::engine
