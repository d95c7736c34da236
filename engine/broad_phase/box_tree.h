// A tree of boxes over proxies that are sorted along a space-filling curve: boxes around runs of boxes, level by level.
// SPDX-License-Identifier: MIT
// Source: Kamel, Faloutsos, "On Packing R-trees", 1993 (packing of sorted runs); Morton, "A Computer Oriented Geodetic
// Data Base and a New Technique in File Sequencing", 1966 (the curve); Ericson, "Real-Time Collision Detection", 2005,
// section 6.3 (traversal).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/broad_phase/sorting.h"
#include "engine/math/vec2.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Boxes over runs of sorted proxies, boxes over runs of these boxes, and so on up to one. Level 0 is the proxies.
struct BoxTree {
  std::vector<Box> boxes;                  // [level_start[level] + node]
  std::vector<std::uint32_t> proxies;      // [node of level 0]
  std::vector<std::uint32_t> level_start;  // [level]; one more at the end: the number of boxes
};

/// The empty box: it contains nothing, and grows by what it includes.
inline constexpr Real far_away = sizeof(Real) == 4 ? Real(0x1p127) : Real(0x1p1023);
inline constexpr Box empty_box{{far_away, far_away}, {-far_away, -far_away}};

/// Builds a tree over the proxies of `entries`, sorts `entries` along the curve and overwrites their keys. `boxes`:
/// [proxy]. `buffer` is overwritten.
void build_tree(std::span<const Box> boxes, std::vector<SortEntry>& entries, std::vector<SortEntry>& buffer,
                BoxTree& tree);

inline constexpr std::uint32_t fan_out = 4;  // children of a node
// The largest stack of a traversal. Each task leaves at most fan_out^2 tasks of the level below, and no tree has 4^16
// leaves.
inline constexpr std::size_t open_max = 16 * fan_out * fan_out;

/// Two nodes, of the same level of one tree or of the levels of two, whose leaves are to be compared.
struct NodePair {
  std::uint32_t level_a;
  std::uint32_t node_a;  // in its level
  std::uint32_t level_b;
  std::uint32_t node_b;
};

struct Children {
  std::uint32_t begin;
  std::uint32_t end;
};
inline Children children_of(const BoxTree& tree, std::uint32_t level, std::uint32_t node) {
  const std::uint32_t level_size = tree.level_start[level] - tree.level_start[level - 1];
  const std::uint32_t begin = node * fan_out;
  const std::uint32_t end = begin + fan_out;
  return {begin, end < level_size ? end : level_size};
}

inline std::uint32_t top_level(const BoxTree& tree) {
  return static_cast<std::uint32_t>(tree.level_start.size()) - 2;
}

/// Calls `use` once with each two leaves whose boxes overlap, until `use` returns false. The leaves are below two nodes
/// of one level, or below one node. Requires: a level above the leaves.
template <typename Use>
void for_each_overlap_below(const BoxTree& tree, std::uint32_t node_level, std::uint32_t node_a, std::uint32_t node_b,
                            Use use) {
  NodePair open[open_max];
  std::size_t open_count = 0;
  open[open_count++] = {node_level, node_a, node_level, node_b};
  while (open_count > 0) {
    const NodePair task = open[--open_count];
    const std::uint32_t level = task.level_a - 1;
    const Box* boxes = &tree.boxes[tree.level_start[level]];
    const Children of_a = children_of(tree, task.level_a, task.node_a);
    const Children of_b = children_of(tree, task.level_a, task.node_b);
    const bool same = task.node_a == task.node_b;
    const Box box_b = tree.boxes[tree.level_start[task.level_a] + task.node_b];
    for (std::uint32_t a = of_a.begin; a < of_a.end; ++a) {
      const Box box = boxes[a];
      if (!overlaps(box, box_b)) continue;
      if (same && level > 0) open[open_count++] = {level, a, level, a};
      for (std::uint32_t b = same ? a + 1 : of_b.begin; b < of_b.end; ++b) {
        if (!overlaps(box, boxes[b])) continue;
        if (level > 0)
          open[open_count++] = {level, a, level, b};
        else if (!use(a, b))
          return;
      }
    }
  }
}

/// Calls `use` once with each leaf below a node of tree A and each leaf of tree B whose boxes overlap, until `use`
/// returns false. Requires: a leaf in B.
template <typename Use>
void for_each_overlap_between(const BoxTree& tree_a, std::uint32_t level, std::uint32_t node, const BoxTree& tree_b,
                              Use use) {
  NodePair open[open_max];
  std::size_t open_count = 0;
  open[open_count++] = {level, node, top_level(tree_b), 0};
  while (open_count > 0) {
    const NodePair task = open[--open_count];
    if (!overlaps(tree_a.boxes[tree_a.level_start[task.level_a] + task.node_a],
                  tree_b.boxes[tree_b.level_start[task.level_b] + task.node_b]))
      continue;
    if (task.level_a == 0 && task.level_b == 0) {
      if (!use(task.node_a, task.node_b)) return;
    } else if (task.level_a >= task.level_b) {
      const Children children = children_of(tree_a, task.level_a, task.node_a);
      for (std::uint32_t a = children.begin; a < children.end; ++a)
        open[open_count++] = {task.level_a - 1, a, task.level_b, task.node_b};
    } else {
      const Children children = children_of(tree_b, task.level_b, task.node_b);
      for (std::uint32_t b = children.begin; b < children.end; ++b)
        open[open_count++] = {task.level_a, task.node_a, task.level_b - 1, b};
    }
  }
}

/// Calls `use` once with each leaf of a tree whose box overlaps `box`, until `use` returns false.
template <typename Use>
void for_each_overlap_of(const BoxTree& tree, const Box& box, Use use) {
  if (tree.proxies.empty()) return;
  struct Node {
    std::uint32_t level;
    std::uint32_t node;
  };
  Node open[open_max];
  std::size_t open_count = 0;
  open[open_count++] = {top_level(tree), 0};
  while (open_count > 0) {
    const Node at = open[--open_count];
    if (!overlaps(tree.boxes[tree.level_start[at.level] + at.node], box)) continue;
    if (at.level == 0) {
      if (!use(at.node)) return;
      continue;
    }
    const Children children = children_of(tree, at.level, at.node);
    for (std::uint32_t child = children.begin; child < children.end; ++child)
      open[open_count++] = {at.level - 1, child};
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
