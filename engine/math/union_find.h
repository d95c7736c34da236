// Union-find over numbers from 0: a set is named by its smallest number.
// SPDX-License-Identifier: MIT
// Source: Tarjan, "Efficiency of a Good But Not Linear Set Union Algorithm", 1975.
#pragma once

#include <cstdint>
#include <vector>

namespace ticktrue::engine {

/// The smallest number in the set of `node`. `parent`: initially, each number is its own parent.
inline std::uint32_t find_root(std::vector<std::uint32_t>& parent, std::uint32_t node) {
  while (parent[node] != node) {
    parent[node] = parent[parent[node]];
    node = parent[node];
  }
  return node;
}

/// Unites the sets of `a` and `b`.
inline void unite(std::vector<std::uint32_t>& parent, std::uint32_t a, std::uint32_t b) {
  const std::uint32_t root_a = find_root(parent, a);
  const std::uint32_t root_b = find_root(parent, b);
  if (root_a < root_b) parent[root_b] = root_a;
  if (root_b < root_a) parent[root_a] = root_b;
}

}  // namespace ticktrue::engine
