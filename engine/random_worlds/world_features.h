// Features of random worlds that are not rows of the tables of choices.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "engine/random_worlds/random_world.h"

namespace ticktrue::engine {

enum class WorldFeature : std::uint8_t {
  sleeping,
  never_sleeps,
  automatic_substeps,
  tight_target_error,
  loose_target_error,
  one_substep,
  many_substeps,
  locate_impacts,
  continuous_off,
  events,
  zero_gravity,
  sideways_gravity,
  short_ticks,
  bounds,
  spawned_max,
  bullets,
  fixed_rotation,
  explicit_mass,
  gravity_scale,
  linear_damping,
  angular_damping,
  kinematic_movers,
  several_shapes,
  sensors,
  category_filters,
  group_filters,
  restitution,
  no_restitution_threshold,
  frictionless,
  tangent_speed,
  rolling_resistance,
  rounded_shapes,
  densities,
  joint_limits,
  joint_motors,
  joint_springs,
  absolute_springs,
  linear_springs,
  collide_connected,
  several_players,
  teleports,
  quarter_turns,
  size_ratio,
  far_from_origin,
};
inline constexpr std::size_t world_feature_count = 44;

struct WorldFeatureInfo : Choice<WorldFeature> {
  int percent;  // of worlds that ask for the feature; it is dropped if the choices cannot carry it
  bool (*is_on)(const RandomWorld& world);
  void (*take_away)(RandomWorld& world);  // null: no sensible world would remain
};

/// The only list of features, in the order of the enumeration.
std::span<const WorldFeatureInfo> world_features();

/// Sizes of shapes differ by at least this factor in worlds with the feature size_ratio.
inline constexpr double size_ratio_min = 50;
/// Some coordinate is at least this large in worlds with the feature far_from_origin, m.
inline constexpr double far_m = 4000;

}  // namespace ticktrue::engine
