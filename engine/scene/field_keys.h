// The fields of a kind in its row: a field, its JSON key and its range.
// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

#include "base/limits.h"

namespace ticktrue::engine {

/// Bounds of a number, of both numbers of a point, or of the number of elements of a list.
struct FieldRange {
  double min = 0;
  double max = 0;
};

inline constexpr double angle_max_rad = 1e6;    // sin_cos is exact to its last digits up to this angle
inline constexpr double coefficient_max = 1e9;  // friction, damping ratios, hertz, scales: more means "endless"
inline constexpr double stiffness_max = 1e18;   // N/m, N s/m, N m/rad, N m s/rad
inline constexpr double scene_force_max = limits::mass_max_kg * limits::speed_max;  // N, N m: as for inputs

/// Ranges that several fields share. All fit into f32 with a margin: its numbers end at 1e-38 and 3e38.
namespace ranges {
inline constexpr FieldRange place{-limits::coordinate_max_m, limits::coordinate_max_m};
inline constexpr FieldRange anchor{-limits::size_max_m, limits::size_max_m};
inline constexpr FieldRange angle{-angle_max_rad, angle_max_rad};
inline constexpr FieldRange speed{-limits::speed_max, limits::speed_max};
inline constexpr FieldRange length{0, limits::coordinate_max_m};
inline constexpr FieldRange size{limits::size_min_m, limits::size_max_m};
inline constexpr FieldRange coefficient{0, coefficient_max};
inline constexpr FieldRange stiffness{0, stiffness_max};
inline constexpr FieldRange force{-scene_force_max, scene_force_max};
inline constexpr FieldRange force_limit{0, scene_force_max};
inline constexpr FieldRange mass{limits::mass_min_kg, limits::mass_max_kg};
inline constexpr FieldRange inertia{1e-30, 1e30};  // kg m^2
inline constexpr FieldRange substeps{1, limits::substep_count_max};
inline constexpr FieldRange substep_budget{0, 1e6};
inline constexpr FieldRange dt{limits::dt_min_s, limits::dt_max_s};
}  // namespace ranges

template <typename Field>
struct FieldKey {
  Field field{};
  std::string_view key;  // empty: ends the row
  bool required = false;
  FieldRange range{};  // if it differs from that of the field in every kind
};

/// The key of a field in a row of these tables; empty if the kind has no such field.
template <typename Row, typename Field>
constexpr std::string_view key_of(const Row& row, Field field) {
  for (const auto& entry : row.keys)
    if (!entry.key.empty() && entry.field == field) return entry.key;
  return {};
}

/// The range of a field in a row of these tables; `general` if the row has none.
template <typename Row, typename Field>
constexpr FieldRange range_of(const Row& row, Field field, FieldRange general) {
  for (const auto& entry : row.keys)
    if (!entry.key.empty() && entry.field == field && entry.range.max > 0) return entry.range;
  return general;
}

}  // namespace ticktrue::engine
