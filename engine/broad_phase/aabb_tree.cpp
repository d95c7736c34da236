// Tree of boxes, built anew each tick: proxies sorted along a curve through space, boxes around runs of them.
// SPDX-License-Identifier: MIT
// Source: Kamel, Faloutsos, "On Packing R-trees", 1993 (packing of sorted runs); Morton, "A Computer Oriented Geodetic
// Data Base and a New Technique in File Sequencing", 1966 (the curve); Ericson, "Real-Time Collision Detection", 2005,
// section 6.3 (traversal).
#include "engine/broad_phase/broad_phase.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr std::uint32_t fan_out = 4;  // children of a node
constexpr int coordinate_bits = 27;   // of a centre along one axis, within the box of all centres
// Tasks waiting in a traversal: each that is taken leaves at most fan_out^2 of the level below; 4^16 leaves are more
// than there can be.
constexpr std::size_t open_max = 16 * fan_out * fan_out;

/// The bits of `value` with a zero after each.
std::uint64_t spread_bits(std::uint64_t value) {
  value = (value | value << 16) & 0x0000ffff0000ffffull;
  value = (value | value << 8) & 0x00ff00ff00ff00ffull;
  value = (value | value << 4) & 0x0f0f0f0f0f0f0f0full;
  value = (value | value << 2) & 0x3333333333333333ull;
  return (value | value << 1) & 0x5555555555555555ull;
}

/// Grows `box` to hold `other`. A coordinate that is no number changes nothing.
void include(Box& box, const Box& other) {
  if (other.lower.x < box.lower.x) box.lower.x = other.lower.x;
  if (other.lower.y < box.lower.y) box.lower.y = other.lower.y;
  if (other.upper.x > box.upper.x) box.upper.x = other.upper.x;
  if (other.upper.y > box.upper.y) box.upper.y = other.upper.y;
}

constexpr Real far_away = sizeof(Real) == 4 ? Real(0x1p127) : Real(0x1p1023);
constexpr Box empty_box{{far_away, far_away}, {-far_away, -far_away}};

/// Sorts static proxies, or the others, along the Morton curve through their centres.
void sort_along_curve(Scratch& scratch, bool is_static) {
  Box centers = empty_box;
  for (const Proxy& proxy : scratch.proxies)
    if (proxy.is_static == is_static) include(centers, {proxy.center, proxy.center});
  constexpr Real limit = Real(1 << coordinate_bits);
  const Vec2 extent = centers.upper - centers.lower;
  const Real scale = limit / larger(larger(extent.x, extent.y), Real(1e-30));
  scratch.sort_entries.clear();
  for (std::uint32_t i = 0; i < scratch.proxies.size(); ++i) {
    const Proxy& proxy = scratch.proxies[i];
    if (proxy.is_static != is_static) continue;
    const Vec2 place = scale * (proxy.center - centers.lower);
    const auto last = static_cast<std::int32_t>(limit) - 1;
    const auto coordinate = [&](Real value) {
      const std::int32_t whole = clamped_floor(value, limit);
      return static_cast<std::uint64_t>(whole < 0 ? 0 : (whole > last ? last : whole));
    };
    scratch.sort_entries.push_back({spread_bits(coordinate(place.x)) | spread_bits(coordinate(place.y)) << 1, i});
  }
  sort_entries(scratch.sort_entries, scratch.sort_buffer, 2 * coordinate_bits);
}

void build(Scratch& scratch, bool is_static, BoxTree& tree) {
  sort_along_curve(scratch, is_static);
  tree.boxes.clear();
  tree.proxies.clear();
  tree.level_start.clear();
  tree.level_start.push_back(0);
  for (const SortEntry& entry : scratch.sort_entries) {
    tree.boxes.push_back(scratch.proxies[entry.proxy].box);
    tree.proxies.push_back(entry.proxy);
  }
  auto begin = std::uint32_t{0};
  auto end = static_cast<std::uint32_t>(tree.boxes.size());
  while (end - begin > 1) {
    tree.level_start.push_back(end);
    for (std::uint32_t first = begin; first < end; first += fan_out) {
      Box box = empty_box;
      for (std::uint32_t i = first; i < end && i < first + fan_out; ++i) include(box, tree.boxes[i]);
      tree.boxes.push_back(box);
    }
    begin = end;
    end = static_cast<std::uint32_t>(tree.boxes.size());
  }
  tree.level_start.push_back(end);
}

/// Two nodes, of the same level of one tree or of the levels of two, whose leaves are to be compared.
struct Task {
  std::uint32_t level_a;
  std::uint32_t node_a;  // in its level
  std::uint32_t level_b;
  std::uint32_t node_b;
};

struct Children {
  std::uint32_t begin;
  std::uint32_t end;
};
Children children_of(const BoxTree& tree, std::uint32_t level, std::uint32_t node) {
  const std::uint32_t level_size = tree.level_start[level] - tree.level_start[level - 1];
  const std::uint32_t begin = node * fan_out;
  const std::uint32_t end = begin + fan_out;
  return {begin, end < level_size ? end : level_size};
}

std::uint32_t top_level(const BoxTree& tree) {
  return static_cast<std::uint32_t>(tree.level_start.size()) - 2;
}

/// Calls `use` once with each two leaves of a tree whose boxes overlap.
template <typename Use>
void for_each_overlap_within(const BoxTree& tree, Use use) {
  if (tree.proxies.size() < 2) return;
  Task open[open_max];
  std::size_t open_count = 0;
  open[open_count++] = {top_level(tree), 0, top_level(tree), 0};
  while (open_count > 0) {
    const Task task = open[--open_count];
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
        if (level == 0)
          use(a, b);
        else
          open[open_count++] = {level, a, level, b};
      }
    }
  }
}

/// Calls `use` once with each two leaves of two trees whose boxes overlap.
template <typename Use>
void for_each_overlap_between(const BoxTree& tree_a, const BoxTree& tree_b, Use use) {
  if (tree_a.proxies.empty() || tree_b.proxies.empty()) return;
  Task open[open_max];
  std::size_t open_count = 0;
  open[open_count++] = {top_level(tree_a), 0, top_level(tree_b), 0};
  while (open_count > 0) {
    const Task task = open[--open_count];
    if (!overlaps(tree_a.boxes[tree_a.level_start[task.level_a] + task.node_a],
                  tree_b.boxes[tree_b.level_start[task.level_b] + task.node_b]))
      continue;
    if (task.level_a == 0 && task.level_b == 0) {
      use(task.node_a, task.node_b);
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

}  // namespace

void aabb_tree(const Model& model, State& state, Scratch& scratch, Real dt) {
  make_proxies(model, state, scratch, dt);
  build(scratch, true, scratch.static_tree);
  build(scratch, false, scratch.moving_tree);
  scratch.unsorted_pairs.clear();
  const BoxTree& moving = scratch.moving_tree;
  const BoxTree& others = scratch.static_tree;
  const auto add = [&](std::uint32_t a, std::uint32_t b) {
    if (may_touch(scratch.proxies[a], scratch.proxies[b]))
      scratch.unsorted_pairs.push_back(a < b ? Pair{a, b} : Pair{b, a});
  };
  for_each_overlap_within(moving, [&](std::uint32_t a, std::uint32_t b) { add(moving.proxies[a], moving.proxies[b]); });
  for_each_overlap_between(moving, others,
                           [&](std::uint32_t a, std::uint32_t b) { add(moving.proxies[a], others.proxies[b]); });
  sort_pairs(scratch);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
