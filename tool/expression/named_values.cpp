// Values of bodies, contacts and joints by name.
// SPDX-License-Identifier: MIT
#include "tool/expression/named_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "tool/expression/named_table.h"
#include "tool/study/measures.h"

namespace ticktrue::tool {
namespace {

struct PartName {
  PartKind kind;
  std::string_view prefix;
  int id_count;
};
constexpr std::array<PartName, 3> part_names{
    {{PartKind::body, "bodies", 1}, {PartKind::contact, "contacts", 2}, {PartKind::joint, "joints", 1}}};

/// Takes `.123` or `.word` from the front of a name.
bool take_part(std::string_view& name, std::uint32_t& number, std::string& word) {
  if (name.empty() || name.front() != '.') return false;
  name.remove_prefix(1);
  const std::string_view part = name.substr(0, name.find('.'));
  const bool is_word = !part.empty() && (part.front() == '_' || std::isalpha(static_cast<unsigned char>(part.front())));
  if (is_word) {
    word = std::string(part);
  } else {
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), number);
    if (error != std::errc() || end != part.data() + part.size()) return false;
  }
  name.remove_prefix(part.size());
  return true;
}

/// Replaces the names of bodies and joints by their numbers. Returns the name that the scene does not have, or "".
std::string replace_names(NamedValue& named, PartKind part, const engine::Scene& scene) {
  const auto replace = [&](std::string& word, std::uint32_t& number) {
    if (word.empty()) return true;
    const auto find = [&](const auto& list) {
      const auto at = std::find_if(list.begin(), list.end(), [&](const auto& each) { return each.name == word; });
      number = static_cast<std::uint32_t>(at - list.begin());
      return at != list.end();
    };
    if (!(part == PartKind::joint ? find(scene.joints) : find(scene.bodies))) return false;
    word.clear();
    return true;
  };
  if (!replace(named.first_name, named.first)) return named.first_name;
  if (!replace(named.second_name, named.second)) return named.second_name;
  return {};
}

/// The names that a scene gives to its bodies or joints.
template <typename Part>
std::string listed_names(const std::vector<Part>& parts) {
  constexpr std::size_t length_max = 200;
  std::string names;
  for (const Part& part : parts)
    if (!part.name.empty() && names.size() < length_max) names += (names.empty() ? "" : ", ") + part.name;
  return names.empty() ? "the scene names none: give its number" : "names: " + names;
}

/// Whether an input may make a body.
bool can_gain_bodies(const engine::Scene& scene) {
  const auto is_declared = [&](engine::InputKind kind) {
    return std::find(scene.inputs.begin(), scene.inputs.end(), kind) != scene.inputs.end();
  };
  if (is_declared(engine::InputKind::spawn) && !scene.prototypes.empty()) return true;
  return is_declared(engine::InputKind::press) && scene.pointer && !scene.pointer->spawns.empty();
}

}  // namespace

std::optional<NamedValue> find_named_value(std::string_view name) {
  NamedValue named;
  named.name = std::string(name);
  for (const PartName& part : part_names) {
    std::string_view rest = name;
    if (rest.substr(0, part.prefix.size()) != part.prefix) continue;
    rest.remove_prefix(part.prefix.size());
    if (!take_part(rest, named.first, named.first_name)) return {};
    if (part.id_count == 2 && !take_part(rest, named.second, named.second_name)) return {};
    for (const PartValueInfo& info : part_values) {
      if (info.part != part.kind || rest != "." + std::string(info.name)) continue;
      named.value = info.value;
      return named;
    }
  }
  return {};
}

Status check_exists(const NamedValue& of_text, const engine::Scene& scene, const std::string& place) {
  NamedValue named = of_text;
  const auto info = std::find_if(part_values.begin(), part_values.end(),
                                 [&](const PartValueInfo& part) { return part.value == named.value; });
  const bool is_joint = info->part == PartKind::joint;
  const std::string unknown = replace_names(named, info->part, scene);
  if (!unknown.empty())
    return Error{ErrorCode::usage,
                 fmt::format("{}: {}: found no {} \"{}\"", place, named.name, is_joint ? "joint" : "body", unknown),
                 is_joint ? listed_names(scene.joints) : listed_names(scene.bodies)};
  const auto refused = [&](std::string_view what, std::uint32_t number, std::size_t count, const char* all) {
    std::string message = fmt::format("{}: {}: found no {} {}: the scene has {}", place, named.name, what, number,
                                      count == 0 ? "none" : std::to_string(count));
    if (count > 0) message += count == 1 ? ", expected 0" : fmt::format(", expected 0..{}", count - 1);
    return Error{ErrorCode::usage, message,
                 fmt::format("they count from 0 in the order of the scene; {}: of all", all)};
  };
  if (is_joint) {
    if (named.first < scene.joints.size()) return {};
    return refused("joint", named.first, scene.joints.size(), "joints.*.gap");
  }
  const bool is_contact = info->part == PartKind::contact;
  if (is_contact && named.first == named.second)
    return Error{ErrorCode::usage,
                 fmt::format("{}: {}: found body {} twice, expected two bodies", place, named.name, named.first), ""};
  if (can_gain_bodies(scene)) return {};
  for (const std::uint32_t id : {named.first, is_contact ? named.second : named.first})
    if (id >= scene.bodies.size()) return refused("body", id, scene.bodies.size(), "bodies.*.x");
  return {};
}

std::string named_values_text() {
  std::string text;
  for (const PartName& part : part_names) {
    text += (text.empty() ? "" : "; ") + std::string(part.prefix) + (part.id_count == 2 ? ".3.7:" : ".3:");
    for (const PartValueInfo& info : part_values)
      if (info.part == part.kind) text += " " + std::string(info.name);
  }
  return text;
}

double NamedValues::of(NamedValue named) {
  const auto info = std::find_if(part_values.begin(), part_values.end(),
                                 [&](const PartValueInfo& part) { return part.value == named.value; });
  if (!replace_names(named, info->part, engine_.scene()).empty()) return std::nan("");
  switch (info->part) {
    case PartKind::body:
      return of_body(named.first, named.value);
    case PartKind::contact:
      return of_contact(named);
    case PartKind::joint:
      return of_joint(named.first, named.value);
  }
  return std::nan("");
}

double NamedValues::of_body(std::uint32_t id, PartValue value) {
  if (!bodies_) bodies_ = engine_.bodies();
  const auto body =
      std::find_if(bodies_->begin(), bodies_->end(), [id](const auto& report) { return report.id == id; });
  if (body == bodies_->end()) return std::nan("");
  switch (value) {
    case PartValue::x:
      return body->center.x;
    case PartValue::y:
      return body->center.y;
    case PartValue::angle:
      return body->angle;
    case PartValue::vx:
      return body->velocity.x;
    case PartValue::vy:
      return body->velocity.y;
    case PartValue::asleep:
      return is_asleep(id) ? 1 : 0;
    default:
      return body->angular_velocity;
  }
}

bool NamedValues::is_asleep(std::uint32_t id) const {
  const NamedTable sleep(engine_.state(), "sleep");
  for (std::uint32_t row = 0; row < sleep.row_count(); ++row)
    if (sleep.value(row, "body") == id) return sleep.value(row, "asleep") != 0;
  return false;
}

double NamedValues::of_contact(const NamedValue& named) {
  if (std::isnan(of_body(named.first, PartValue::x)) || std::isnan(of_body(named.second, PartValue::x)))
    return std::nan("");
  const std::uint32_t a = std::min(named.first, named.second);
  const std::uint32_t b = std::max(named.first, named.second);
  double result = 0;
  if (named.value == PartValue::points || named.value == PartValue::overlap) {
    if (!contacts_) contacts_ = engine_.contacts();
    for (const engine::ContactReport& contact : *contacts_) {
      if (contact.body_a != a || contact.body_b != b) continue;
      for (int i = 0; i < contact.point_count; ++i) {
        if (named.value == PartValue::overlap)
          result = std::max(result, -contact.separation[i]);
        else
          result += contact.separation[i] <= 0 ? 1 : 0;
      }
    }
    return result;
  }
  const NamedTable contacts(engine_.state(), "contacts");
  const std::string_view column = named.value == PartValue::normal_force ? "normal_force" : "tangent_force";
  for (std::uint32_t row = 0; row < contacts.row_count(); ++row)
    if (contacts.value(row, "body_a") == a && contacts.value(row, "body_b") == b)
      result += contacts.value(row, column, 0) + contacts.value(row, column, 1);
  return result;
}

namespace {

/// N, >= 0: `x` and `y` of the column linear_force, and the force of a limit along the axis of the joint. The lanes of
/// a pulley and of a gear belong to their two bodies: the first counts.
double holding_force(engine::JointKind kind, double x, double y, double limit) {
  if (kind == engine::JointKind::pulley || kind == engine::JointKind::gear) return std::abs(x);
  if (kind == engine::JointKind::distance) return std::abs(x + limit);
  return std::hypot(x, y, limit);
}

}  // namespace

double NamedValues::of_joint(std::uint32_t joint, PartValue value) {
  const NamedTable joints(engine_.state(), "joints");
  for (std::uint32_t row = 0; row < joints.row_count(); ++row) {
    if (joints.value(row, "joint") != joint) continue;
    const engine::JointKind kind = engine_.scene().joints[joint].kind;
    const double limit = joints.value(row, "lower_force") - joints.value(row, "upper_force");
    const bool limits_angle = engine::traits_of(kind).limits == engine::JointLimits::angle;
    switch (value) {
      case PartValue::force:
        return holding_force(kind, joints.value(row, "linear_force", 0), joints.value(row, "linear_force", 1),
                             limits_angle ? 0 : limit);
      case PartValue::torque:
        return joints.value(row, "torque") + (limits_angle ? limit : 0);
      case PartValue::spring_force:
        return joints.value(row, "spring_force");
      case PartValue::limit_force:
        return limit;
      case PartValue::motor_force:
        return joints.value(row, "motor_force");
      default:
        return joint_gaps(engine_.scene(), engine_.bodies())[joint];
    }
  }
  return std::nan("");
}

}  // namespace ticktrue::tool
