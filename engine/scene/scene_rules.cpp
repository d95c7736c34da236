// The rules of a scene as a whole: counts, settings, inputs, bounds; and what all rules are made of.
// SPDX-License-Identifier: MIT
#include "engine/scene/scene_rules.h"

#include <utility>

#include "base/bytes.h"

namespace ticktrue::engine {
namespace {

constexpr double force_per_kg_max = 1e15;  // N/kg
constexpr double error_target_min = 1e-6;  // of automatic substeps
constexpr double error_target_max = 0.1;
constexpr double tolerance_min = 1e-12;  // m and rad, of the adaptive clock
constexpr double tolerance_max = 1;

bool is_finite(double value) {
  return value - value == 0;
}

/// Valid UTF-8 without control characters: what can be printed and stored in JSON as it is.
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
                    check_inputs() && check_pointer() && check_bounds() && check_choices();
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
  return text + key;
}

bool SceneRules::fail(ErrorCode code, const std::string& key, const std::string& what, std::string hint) {
  error_ = Error{code, place(key) + ": " + what, std::move(hint)};
  return false;
}

bool SceneRules::refuse(const std::string& key, const std::string& what, std::string hint) {
  return fail(ErrorCode::invalid_scene, key, what, std::move(hint));
}

bool SceneRules::number(const char* key, double value, double min, double max, int index, const char* hint) {
  if (value >= min && value <= max) return true;
  const std::string name = index < 0 ? std::string(key) : std::string(key) + "[" + std::to_string(index) + "]";
  const char* what = !is_finite(value)       ? "must be finite"
                     : min > 0 && value <= 0 ? "must be > 0"
                     : min == 0 && value < 0 ? "must be >= 0"
                                             : "out of range";
  return refuse(
      name,
      std::string(what) + ": found " + number_text(value) + ", expected " + number_text(min) + ".." + number_text(max),
      hint);
}

bool SceneRules::point(const char* key, const Point& value, double max) {
  return number(key, value.x, -max, max, 0) && number(key, value.y, -max, max, 1);
}

bool SceneRules::name(const char* key, const std::string& value) {
  if (value.size() > limits::name_size_max)
    return fail(ErrorCode::limit, key,
                "too long: found " + std::to_string(value.size()) + " bytes, expected at most " +
                    std::to_string(limits::name_size_max));
  if (!is_printable(value)) return refuse(key, "must be UTF-8 without control characters: found other bytes");
  return true;
}

bool SceneRules::box(const std::string& key, const Bounds& bounds) {
  if (!point((key + ".lower").c_str(), bounds.lower, limits::coordinate_max_m) ||
      !point((key + ".upper").c_str(), bounds.upper, limits::coordinate_max_m))
    return false;
  const auto ascend = [&](const char* axis, double lower, double upper) {
    return lower < upper || refuse(key + ".upper[" + axis + "]", "must be above lower: found " + number_text(upper) +
                                                                     ", expected more than " + number_text(lower));
  };
  return ascend("0", bounds.lower.x, bounds.upper.x) && ascend("1", bounds.lower.y, bounds.upper.y);
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
  const auto count = [&](const char* key, std::size_t found, std::size_t max) {
    return found <= max ||
           fail(ErrorCode::limit, key,
                "too many: found " + std::to_string(found) + ", expected at most " + std::to_string(max));
  };
  if (!count("bodies", scene_.bodies.size(), limits::body_count_max) ||
      !count("prototypes", scene_.prototypes.size(), limits::prototype_count_max) ||
      !count("joints", scene_.joints.size(), limits::joint_count_max) ||
      !count("forces", scene_.forces.size(), limits::force_count_max))
    return false;
  if (scene_.bodies.empty() && scene_.prototypes.empty())
    return refuse("bodies", "nothing to simulate: found no body and no prototype, expected at least one");
  return true;
}

bool SceneRules::check_settings() {
  const Settings& settings = scene_.settings;
  return row("settings.precision", precisions, settings.precision) &&
         row("settings.solver", solvers, settings.solver) &&
         row("settings.integrator", integrators, settings.integrator) &&
         row("settings.broad_phase", broad_phases, settings.broad_phase) &&
         row("settings.friction_mix", mix_rules, settings.friction_mix) &&
         row("settings.restitution_mix", mix_rules, settings.restitution_mix) &&
         row("settings.clock", clock_kinds, settings.clock.kind) &&
         number("settings.dt", settings.dt, limits::dt_min_s, limits::dt_max_s, -1, "seconds per tick, such as 1/60") &&
         check_substeps() && number("settings.iterations", settings.iterations, 1, limits::iteration_count_max) &&
         number("settings.restitution_threshold", settings.restitution_threshold, 0, limits::speed_max) &&
         check_sleep() && check_clock() && point("gravity", scene_.gravity, limits::speed_max);
}

bool SceneRules::check_substeps() {
  const int least = scene_.settings.substeps;
  if (!scene_.settings.auto_substeps) return number("settings.substeps", least, 1, limits::substep_count_max);
  const AutoSubsteps& automatic = *scene_.settings.auto_substeps;
  const int most = automatic.substeps_max;
  if (!number("settings.substeps.least", least, 1, limits::substep_count_max) ||
      !number("settings.substeps.target_error", automatic.target_error, error_target_min, error_target_max) ||
      !number("settings.substeps.most", most, 1, limits::substep_count_max))
    return false;
  if ((most & (most - 1)) != 0)
    return refuse("settings.substeps.most", "must be a power of two: found " + std::to_string(most) +
                                                ", expected 1, 2, 4, 8, ... or " +
                                                std::to_string(limits::substep_count_max));
  return least <= most || refuse("settings.substeps.least", "must not be above most: found " + std::to_string(least) +
                                                                ", expected at most " + std::to_string(most));
}

bool SceneRules::check_sleep() {
  if (!scene_.settings.sleep) return true;
  const SleepSettings& sleep = *scene_.settings.sleep;
  return number("settings.sleep.after", sleep.after_s, 0, coefficient_max) &&
         number("settings.sleep.speed_max", sleep.speed_max, 0, limits::speed_max);
}

bool SceneRules::check_clock() {
  const ClockSettings& clock = scene_.settings.clock;
  const ClockSettings unset;
  const auto& fields = info_of(clock_fields, clock.kind);
  const auto has_no = [&](ClockField field, const char* key, double value, double default_value) {
    return !key_of(fields, field).empty() || bits_of(value) == bits_of(default_value) ||
           refuse(std::string("settings.clock.") + key,
                  "a clock of kind " + std::string(info_of(clock_kinds, clock.kind).name) + " has none: found one");
  };
  if (!has_no(ClockField::ticks_per_frame_max, "ticks_per_frame_max", clock.ticks_per_frame_max,
              unset.ticks_per_frame_max) ||
      !has_no(ClockField::tolerance, "tolerance", clock.tolerance, unset.tolerance) ||
      !has_no(ClockField::dt_min, "dt_min", clock.dt_min, unset.dt_min) ||
      !has_no(ClockField::dt_max, "dt_max", clock.dt_max, unset.dt_max) ||
      !number("settings.clock.ticks_per_frame_max", clock.ticks_per_frame_max, 1, limits::ticks_per_frame_max) ||
      !number("settings.clock.tolerance", clock.tolerance, tolerance_min, tolerance_max) ||
      !number("settings.clock.dt_min", clock.dt_min, limits::dt_min_s, limits::dt_max_s) ||
      !number("settings.clock.dt_max", clock.dt_max, limits::dt_min_s, limits::dt_max_s))
    return false;
  return clock.kind != ClockKind::adaptive || clock.dt_min <= clock.dt_max ||
         refuse("settings.clock.dt_min", "must not be above dt_max: found " + number_text(clock.dt_min) +
                                             ", expected at most " + number_text(clock.dt_max));
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
  for (const InputKind kind : {InputKind::press, InputKind::drag, InputKind::release}) {
    if (declares(scene_, kind) == scene_.pointer.has_value()) continue;
    const std::string kind_name(info_of(input_kinds, kind).name);
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
  return number("pointer.hertz", pointer.hertz, 1e-6, coefficient_max) &&
         number("pointer.damping_ratio", pointer.damping_ratio, 0, coefficient_max) &&
         number("pointer.force_max_per_kg", pointer.force_max_per_kg, 1e-6, force_per_kg_max) &&
         (!pointer.window || box("pointer.window", *pointer.window));
}

bool SceneRules::check_bounds() {
  if (scene_.bounds && !box("bounds", *scene_.bounds)) return false;
  return !scene_.spawned_max || number("spawned_max", *scene_.spawned_max, 1, limits::body_count_max);
}

Status check_scene(const Scene& scene, const std::string& source) {
  return SceneRules(scene, source).run();
}

}  // namespace ticktrue::engine
