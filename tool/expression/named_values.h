// Values of single bodies, of two bodies that touch, and of joints, by names such as `bodies.3.x`.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "engine/engine.h"

namespace ticktrue::tool {

enum class PartKind : std::uint8_t { body, contact, joint };

enum class PartValue : std::uint8_t {
  x,
  y,
  angle,
  vx,
  vy,
  w,
  asleep,
  points,
  normal_force,
  friction_force,
  overlap,
  force,
  torque,
  spring_force,
  limit_force,
  motor_force,
  gap,
};

struct PartValueInfo {
  PartKind part;
  PartValue value;
  std::string_view name;
  std::string_view summary;
};
/// `bodies.ID.value`, `contacts.ID.ID.value`, `joints.NUMBER.value`. Ids count from 0 in the order of the scene, and so
/// do joints. The name that the scene gives to a body or joint stands for its number.
inline constexpr std::array<PartValueInfo, 17> part_values{{
    {PartKind::body, PartValue::x, "x", "m, of the centre of mass"},
    {PartKind::body, PartValue::y, "y", "m, of the centre of mass"},
    {PartKind::body, PartValue::angle, "angle", "rad, -pi to pi"},
    {PartKind::body, PartValue::vx, "vx", "m/s"},
    {PartKind::body, PartValue::vy, "vy", "m/s"},
    {PartKind::body, PartValue::w, "w", "rad/s"},
    {PartKind::body, PartValue::asleep, "asleep", "1 asleep, 0 awake or in a scene without sleep"},
    {PartKind::contact, PartValue::points, "points", "points in which the two touch"},
    {PartKind::contact, PartValue::normal_force, "normal_force", "N, of all points, mean over the last substep"},
    {PartKind::contact, PartValue::friction_force, "friction_force",
     "N, likewise; above 0: pushes the upper body to +x"},
    {PartKind::contact, PartValue::overlap, "overlap", "m, the deepest of the points"},
    {PartKind::joint, PartValue::force, "force",
     "N, >= 0, length of the force that holds it, with its limits; mean over the last substep"},
    {PartKind::joint, PartValue::torque, "torque", "N m, likewise"},
    {PartKind::joint, PartValue::spring_force, "spring_force", "N or N m"},
    {PartKind::joint, PartValue::limit_force, "limit_force", "N or N m, above 0 at the lower limit"},
    {PartKind::joint, PartValue::motor_force, "motor_force", "N or N m"},
    {PartKind::joint, PartValue::gap, "gap", "m, how far it is from what it holds"},
}};

struct NamedValue {
  std::string name;
  PartValue value = PartValue::x;
  std::uint32_t first = 0;   // id of a body, or number of a joint
  std::uint32_t second = 0;  // id of the other body of a contact
  std::string first_name;    // stands for `first` if it is not empty: the name that the scene gives
  std::string second_name;
};

/// The value that a name means; none: it means none.
std::optional<NamedValue> find_named_value(std::string_view name);
/// Refuses a body or joint that no state of the scene can have. Spawned bodies have any id. Messages begin with
/// `place`. Errors: usage.
Status check_exists(const NamedValue& named, const engine::Scene& scene, const std::string& place);
/// "bodies.3: x y ...; contacts.3.7: ...": what find_named_value knows.
std::string named_values_text();

/// The value in the present state of an engine; NaN where the body or joint is gone or never was, 0 where two bodies do
/// not touch.
class NamedValues {
 public:
  explicit NamedValues(const engine::Engine& engine) : engine_(engine) {}
  double of(NamedValue named);

 private:
  double of_body(std::uint32_t id, PartValue value);
  bool is_asleep(std::uint32_t id) const;
  double of_contact(const NamedValue& named);
  double of_joint(std::uint32_t joint, PartValue value);

  const engine::Engine& engine_;
  std::optional<std::vector<engine::BodyReport>> bodies_;
  std::optional<std::vector<engine::ContactReport>> contacts_;
};

}  // namespace ticktrue::tool
