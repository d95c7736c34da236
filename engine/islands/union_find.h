// Union-find over body rows: an island is named by its first row.
// SPDX-License-Identifier: MIT
// Source: Tarjan, "Efficiency of a Good But Not Linear Set Union Algorithm", 1975.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/math/real.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

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

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
