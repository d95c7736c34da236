// The values of a world that expressions name: energy, momentum, overlaps, counts. One list, computed in one place.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/engine.h"

namespace ticktrue::tool {

enum class WorldValue : std::uint8_t {
  tick,
  time,
  bodies,
  contacts,
  energy,
  kinetic,
  potential,
  momentum_x,
  momentum_y,
  angular_momentum,
  overlap,
  joint_gap,
  speed_max,
  asleep,
};

struct WorldValueInfo {
  WorldValue value;
  std::string_view name;
  std::string_view summary;
};
inline constexpr std::array<WorldValueInfo, 14> world_values{{
    {WorldValue::tick, "tick", "ticks done"},
    {WorldValue::time, "time", "s, sum of their dt"},
    {WorldValue::bodies, "bodies", "how many there are"},
    {WorldValue::contacts, "contacts", "pairs of shapes that touch"},
    {WorldValue::energy, "energy", "J, kinetic and potential; springs, motors and pointers are not counted"},
    {WorldValue::kinetic, "kinetic", "J"},
    {WorldValue::potential, "potential", "J, of the gravity of the scene; 0 at the origin"},
    {WorldValue::momentum_x, "momentum_x", "kg m/s"},
    {WorldValue::momentum_y, "momentum_y", "kg m/s"},
    {WorldValue::angular_momentum, "angular_momentum", "kg m^2/s about the origin"},
    {WorldValue::overlap, "overlap", "m, deepest of two shapes"},
    {WorldValue::joint_gap, "joint_gap", "m, largest distance of a joint from what it holds"},
    {WorldValue::speed_max, "speed_max", "m/s, of the centre of a dynamic body"},
    {WorldValue::asleep, "asleep", "how many bodies sleep"},
}};

/// The present state of a world, measured as far as it is asked for.
class WorldMeasures {
 public:
  explicit WorldMeasures(const engine::Engine& engine) : engine_(engine) {}

  double of(WorldValue value);
  /// Ids of the bodies that make the value what it is: of the deepest overlap, of the worst joint, the one with most
  /// kinetic energy, the fastest one.
  std::vector<std::uint32_t> bodies_of(WorldValue value);

 private:
  const std::vector<engine::BodyReport>& bodies();
  const std::vector<engine::ContactReport>& contacts();
  double angular_momentum();
  double asleep_count() const;
  std::vector<std::uint32_t> deepest_pair();
  std::vector<std::uint32_t> worst_joint();
  std::vector<std::uint32_t> body_with_most(double (*measure)(const engine::BodyReport&));

  const engine::Engine& engine_;
  std::optional<std::vector<engine::BodyReport>> bodies_;
  std::optional<std::vector<engine::ContactReport>> contacts_;
};

}  // namespace ticktrue::tool
