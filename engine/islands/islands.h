// Islands as stages see them: connected bodies, named by their first row.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model/model.h"
#include "engine/model/scratch.h"
#include "engine/model/state.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

inline BodyType type_of(const Model& model, const State& state, std::uint32_t row) {
  return model.bodies[state.bodies[row].source].type;
}

/// The first row of the island of a row.
inline std::uint32_t find_root(std::vector<std::uint32_t>& parent, std::uint32_t row) {
  while (parent[row] != row) {
    parent[row] = parent[parent[row]];
    row = parent[row];
  }
  return row;
}

/// The smaller row becomes the root, so that an island is named by its first row.
inline void unite(std::vector<std::uint32_t>& parent, std::uint32_t a, std::uint32_t b) {
  const std::uint32_t root_a = find_root(parent, a);
  const std::uint32_t root_b = find_root(parent, b);
  if (root_a < root_b) parent[root_b] = root_a;
  if (root_b < root_a) parent[root_a] = root_b;
}

inline std::uint32_t row_of(const State& state, std::uint32_t id) {
  return static_cast<std::uint32_t>(state.find_body(id));
}

/// Chooses the substeps of each island: scratch.island_level, state.substeps. Also finds the islands with resting
/// impacts. Requires: islands are united.
void choose_substeps(const Model& model, State& state, Scratch& scratch, Real dt);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
