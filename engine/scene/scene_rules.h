// The rules of a scene, for check_scene.
// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/limits.h"
#include "engine/json/number_text.h"
#include "engine/scene/scene.h"
#include "engine/scene/scene_fields.h"

namespace ticktrue::engine {

bool declares(const Scene& scene, InputKind kind);

/// The largest restitution of two shapes that may touch; 0 if there are none. Filters and joints do not count.
double largest_restitution(const Scene& scene);

/// What `"locate_impacts": "auto"` of a scene file stands for: whether some pair has restitution 1, and the scene may
/// have its impacts located.
bool locates_bounces(const Scene& scene);

/// Whether the number `kind`, which may come from outside, is a row of the table.
template <typename Table, typename Kind>
bool is_row(const Table& table, Kind kind) {
  return static_cast<std::size_t>(kind) < table.size();
}

/// Walks a scene and stores the first broken rule. Texts of places are made only then, since scenes have many bodies.
class SceneRules {
 public:
  /// Requires: the arguments outlive this object.
  SceneRules(const Scene& scene, const std::string& source) : scene_(scene), source_(source) {}

  Status run();

 private:
  // ---- Parts of rules (scene_rules.cpp): false once a rule is broken ----

  std::string place(const std::string& key) const;
  bool fail(ErrorCode code, const std::string& key, const std::string& what, std::string hint = {});
  bool refuse(const std::string& key, const std::string& what, std::string hint = {});
  /// `index` >= 0: an element of the array `key`.
  bool number(std::string_view key, double value, FieldRange range, int index = -1, const char* hint = "");
  bool point(std::string_view key, const Point& value, FieldRange range) {
    return number(key, value.x, range, 0) && number(key, value.y, range, 1);
  }
  bool name(std::string_view key, const std::string& value);
  template <typename Table, typename Kind>
  bool row(std::string_view key, const Table& table, Kind kind) {
    return is_row(table, kind) ||
           refuse(std::string(key), "unknown: found number " + std::to_string(static_cast<unsigned>(kind)) +
                                        ", expected " + choice_names(table));
  }
  using Names = std::map<std::string_view, std::size_t>;
  /// Whether the text differs from the earlier names of its list.
  bool unique(const std::string& text, Names& names);

  // ---- Fields by their types ----

  /// Types that check_value accepts without a check: flags, and structs that other functions check.
  template <typename Value>
  static constexpr bool is_checked_apart =
      std::is_same_v<Value, bool> || std::is_same_v<Value, Settings> || std::is_same_v<Value, AutoSubsteps> ||
      std::is_same_v<Value, ExplicitMass> || std::is_same_v<Value, PointerSettings> || std::is_same_v<Value, Range>;
  template <typename Value>
  bool check_value(std::string_view key, const Value& value, FieldRange range, const char* hint = "") {
    if constexpr (std::is_enum_v<Value>)
      return row(key, Tables::of(value), value);
    else if constexpr (is_checked_apart<Value>)
      return true;
    else if constexpr (std::is_arithmetic_v<Value>)
      return number(key, value, range, -1, hint);
    else
      return check_fields(value, key);
  }
  bool check_value(std::string_view key, const Point& value, FieldRange range, const char*) {
    return point(key, value, range);
  }
  bool check_value(std::string_view key, const std::string& value, FieldRange, const char*) { return name(key, value); }
  bool check_value(std::string_view key, const Bounds& value, FieldRange, const char*);
  bool check_value(std::string_view key, const ClockSettings& value, FieldRange, const char*);
  bool check_value(std::string_view key, const JointSpring& value, FieldRange, const char*);
  template <typename Value>
  bool check_value(std::string_view key, const std::optional<Value>& value, FieldRange range, const char* hint) {
    return !value || check_value(key, *value, range, hint);
  }
  template <typename Value>
  bool check_value(std::string_view, const std::vector<Value>&, FieldRange, const char*) {
    return true;
  }

  template <typename Struct>
  bool check_fields(const Struct& object) {
    bool good = true;
    visit_fields([&](const FieldInfo& field,
                     const auto& value) { good = good && check_value(field.name, value, field.range, field.hint); },
                 object);
    return good;
  }
  /// Checks the fields of an object that is the value of `key`.
  template <typename Struct>
  bool check_fields(const Struct& object, std::string_view key) {
    const std::size_t size = prefix_.size();
    prefix_.append(key).append(".");
    const bool good = check_fields(object);
    prefix_.resize(size);
    return good;
  }

  template <typename Struct, typename Value>
  static bool is_same(const Struct&, const Value& a, const Value& b) {
    return same_bits(a, b);
  }
  template <typename Value>
  static bool is_same(const Shape&, const Value& a, const Value& b) {
    return a == b;  // neither form stores fields that the kind does not have
  }
  /// Refuses a field that is set and that the row does not have. Calls `check(field, key, value, range)` for each field
  /// of the row. Messages put `before` and `after` around the name of the kind.
  template <typename Struct, typename Row, typename Check>
  bool check_own_fields(const Struct& object, const Row& row, const char* before, const char* after, Check check) {
    const Struct unset;
    bool good = true;
    visit_own_fields(
        [&](const auto& field, const auto& value, const auto& default_value) {
          if (good && key_of(row, field.own).empty() && !is_same(object, value, default_value))
            good = refuse(std::string(field.name), before + std::string(row.name) + after + " has none: found one");
        },
        object, unset);
    visit_own_fields(
        [&](const auto& field, const auto& value) {
          const std::string_view key = key_of(row, field.own);
          good = good && (key.empty() || check(field, key, value, range_of(row, field.own, field.range)));
        },
        object);
    return good;
  }

  // ---- The scene as a whole, and its inputs (scene_rules.cpp) ----

  bool check_counts();
  bool check_settings();
  bool check_substeps();
  bool check_inputs();
  bool check_pointer();

  // ---- Bodies and prototypes (scene_rules_bodies.cpp) ----

  bool check_bodies(const std::vector<Body>& bodies, const char* list);
  bool check_prototype(const Body& body);
  bool check_body(const Body& body);
  bool check_mass(const Body& body);
  bool check_resulting_mass(const Body& body);
  bool check_shape(const Shape& shape);
  /// Checks the points of capsules, segments and chains.
  bool check_points(const Shape& shape);
  bool check_polygon(const Shape& shape);

  // ---- Joints and forces (scene_rules_joints.cpp) ----

  bool check_joints();
  bool check_joint(const Joint& joint);
  bool check_body_index(const char* key, std::uint32_t index);
  bool check_joint_bodies(const Joint& joint);
  /// Checks the two joints of a gear, and its ratio.
  bool check_gear(const Joint& joint);
  bool check_axis(const Point& axis);
  bool check_length(const Joint& joint, FieldRange range);
  bool check_limits(const Joint& joint);
  bool check_forces();
  bool check_force(const Force& force);
  bool check_force_bodies(const Force& force);
  bool check_exponent(const Force& force);

  // ---- Choices that do not go together (scene_rules_choices.cpp) ----

  bool check_choices();
  /// Refuses features that need a solver that reads the narrow phase's contacts.
  bool check_contact_needs(const SolverInfo& solver);

  static constexpr std::size_t no_shape = static_cast<std::size_t>(-1);
  const Scene& scene_;
  const std::string& source_;
  const char* list_ = nullptr;
  std::string prefix_;  // of keys
  std::size_t item_index_ = 0;
  std::size_t shape_index_ = no_shape;
  Error error_{};
};

}  // namespace ticktrue::engine
