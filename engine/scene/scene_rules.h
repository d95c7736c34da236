// The rules of a scene: what check_scene walks.
// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/limits.h"
#include "engine/json/number_text.h"
#include "engine/scene/scene.h"
#include "engine/scene/scene_fields.h"

namespace ticktrue::engine {

// Limits of the rules' own. All leave room in f32, whose numbers end at 1e-38 and 3e38.
inline constexpr double coefficient_max = 1e9;  // friction, damping ratios, hertz, scales: more means "endless"

bool declares(const Scene& scene, InputKind kind);

/// Whether the number `kind`, which may come from outside, is one of the table's.
template <typename Table, typename Kind>
bool is_row(const Table& table, Kind kind) {
  return static_cast<std::size_t>(kind) < table.size();
}

/// Walks a scene and keeps the first rule broken. Places are put together only then: scenes have many bodies.
class SceneRules {
 public:
  /// Requires: both outlive it.
  SceneRules(const Scene& scene, const std::string& source) : scene_(scene), source_(source) {}

  Status run();

 private:
  // ---- What the rules are made of (scene_rules.cpp): false once one is broken ----

  std::string place(const std::string& key) const;
  bool fail(ErrorCode code, const std::string& key, const std::string& what, std::string hint = {});
  bool refuse(const std::string& key, const std::string& what, std::string hint = {});
  /// `index` >= 0: an element of the array `key`.
  bool number(const char* key, double value, double min, double max, int index = -1, const char* hint = "");
  bool point(const char* key, const Point& value, double max);
  bool name(const char* key, const std::string& value);
  bool box(const std::string& key, const Bounds& bounds);
  template <typename Table, typename Kind>
  bool row(const char* key, const Table& table, Kind kind) {
    return is_row(table, kind) || refuse(key, "unknown: found number " + std::to_string(static_cast<unsigned>(kind)) +
                                                  ", expected " + choice_names(table));
  }
  using Names = std::map<std::string_view, std::size_t>;
  /// Among those of the list before it.
  bool unique(const std::string& text, Names& names);

  // ---- The scene as a whole, and what comes from outside (scene_rules.cpp) ----

  bool check_counts();
  bool check_settings();
  bool check_substeps();
  bool check_sleep();
  bool check_clock();
  bool check_inputs();
  bool check_pointer();
  bool check_bounds();

  // ---- Bodies and prototypes (scene_rules_bodies.cpp) ----

  bool check_bodies(const std::vector<Body>& bodies, const char* list);
  bool check_prototype(const Body& body);
  bool check_body(const Body& body);
  bool check_mass(const Body& body);
  bool check_resulting_mass(const Body& body);
  bool check_shape(const Shape& shape);
  /// Of capsules, segments and chains.
  bool check_points(const Shape& shape);
  bool check_polygon(const Shape& shape);

  // ---- Joints and forces (scene_rules_joints.cpp) ----

  bool check_joints();
  bool check_joint(const Joint& joint);
  /// Of any type of field. `key`: of the field in the joint's kind.
  template <typename Value>
  bool check_field(const Joint& joint, JointField field, const char* key, const Value& value, const FieldRange& range);
  bool check_body_index(const char* key, std::uint32_t index);
  bool check_pair(const Joint& joint, bool has_a);
  bool check_axis(const Point& axis);
  bool check_length(const Joint& joint, const FieldRange& range);
  bool check_limits(const Joint& joint);
  bool check_motor(const JointMotor& motor);
  bool check_spring(const std::string& key, const JointSpring& spring);
  bool check_forces();
  bool check_force(const Force& force);
  bool check_force_bodies(const Force& force);
  bool check_exponent(const Force& force);
  /// That the kind has no such field, where it keeps the value that it has when unset.
  template <typename Row, typename Field>
  bool unused(const Row& fields, Field field, const char* key, bool is_unset, std::string_view kind) {
    return !key_of(fields, field).empty() || is_unset || refuse(key, "a " + std::string(kind) + " has none: found one");
  }

  // ---- Choices that do not go together (scene_rules_choices.cpp) ----

  bool check_choices();
  /// What only solvers that read the narrow phase's contacts can do.
  bool check_contact_needs(const SolverInfo& solver);

  static constexpr std::size_t no_shape = static_cast<std::size_t>(-1);
  const Scene& scene_;
  const std::string& source_;
  const char* list_ = nullptr;
  std::size_t item_index_ = 0;
  std::size_t shape_index_ = no_shape;
  Error error_{};
};

}  // namespace ticktrue::engine
