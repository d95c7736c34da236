// The list of pairs of fat AABBs that overlap, followed from tick to tick.
// SPDX-License-Identifier: MIT
#include "engine/broad_phase/pair_list.h"

#include "engine/broad_phase/broad_phase.h"
#include "engine/broad_phase/pair_listing.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr Real ticks_ahead = 4;              // the margin of a fat AABB lasts so many ticks at the present velocity
constexpr Real share_of_radius = Real(0.1);  // and a share of the radius is added
// If more proxies have moved than this share, or than this number, the list is rebuilt.
constexpr std::size_t moving_per_moved_proxy = 8;
constexpr std::size_t moved_proxy_count_max = 1024;
constexpr std::uint32_t ticks_held_least = 6;  // after the tick of the rebuild; fewer do not pay
constexpr std::uint32_t suspended_tick_count = 60;
constexpr std::uint8_t moved_in_this_tick = 2;

Box fat_box(const Model& model, const State& state, const ProxyBoxes& boxes, std::uint32_t index) {
  const Proxy& proxy = boxes.proxies()[index];
  const Real dt = boxes.key().dt;
  const BodyRow& body = state.bodies[proxy.body];
  const Real radius = model.shapes[proxy.shape].bounding_radius;
  const Real spin = absolute(body.angular_velocity) * radius * dt;
  const Real margin =
      (share_of_radius * radius + smaller(8 * boxes.key().gravity_displacement, 2 * share_of_radius * radius)) +
      smaller(ticks_ahead * spin, share_of_radius * radius);
  const auto predict = [&](Real speed) { return smaller(larger(ticks_ahead * dt * speed, -2 * radius), 2 * radius); };
  const Vec2 predicted{predict(body.velocity.x), predict(body.velocity.y)};
  Box box = boxes.boxes()[index];
  box.lower = {box.lower.x - margin + smaller(predicted.x, 0), box.lower.y - margin + smaller(predicted.y, 0)};
  box.upper = {box.upper.x + margin + larger(predicted.x, 0), box.upper.y + margin + larger(predicted.y, 0)};
  return box;
}

/// The level of a tree whose nodes are shared out. The level has few nodes, since each is compared with each.
std::uint32_t shared_level(const BoxTree& tree) {
  constexpr std::uint32_t node_count_max = 128;
  std::uint32_t level = 0;
  while (level < top_level(tree) && tree.level_start[level + 1] - tree.level_start[level] > node_count_max) ++level;
  return level > 0 || tree.proxies.size() < 2 ? level : level + 1;
}

}  // namespace

bool PairList::are_many_moved(std::size_t leaving_count) const {
  const std::size_t count = moved_proxies_.size() + leaving_count;
  return count > moved_proxy_count_max || count * moving_per_moved_proxy > moving_tree_.proxies.size();
}

bool PairList::is_short_lived() const {
  return has_pairs_ && ticks_held_ < ticks_held_least;
}

void PairList::suspend() {
  suspended_ticks_ = suspended_tick_count;
}

void PairList::pass_suspended_tick() {
  has_pairs_ = false;
  --suspended_ticks_;
}

/// Nodes of a level of the moving tree. `is_tight`: their tight boxes must overlap, too.
struct PairList::Nodes {
  std::uint32_t level;
  bool is_tight;
};

/// Lists the pairs of a chunk of nodes: of each node with itself, with the nodes after it, and with the static tree.
void PairList::list_pairs_of_nodes(const ProxyBoxes& boxes, const Nodes& nodes, const Chunk& chunk,
                                   PairListing& listing, std::vector<Pair>& pairs) const {
  const std::uint32_t level = nodes.level;
  const BoxTree& moving = moving_tree_;
  const BoxTree& others = static_tree_;
  const Proxy* proxies = boxes.proxies().data();
  const Box* tight = boxes.boxes().data();
  bool goes_on = true;
  const auto add = [&](std::uint32_t a, std::uint32_t b) {
    if (!may_touch(proxies[a], proxies[b])) return true;
    if (nodes.is_tight && !(overlaps(tight[a], tight[b]) && are_pair(proxies[a], proxies[b], tight[a], tight[b])))
      return true;
    pairs.push_back(a < b ? Pair{a, b} : Pair{b, a});
    goes_on = listing.goes_on(pairs.size());
    return goes_on;
  };
  const Box* node_boxes = moving.boxes.data() + moving.level_start[level];
  const std::uint32_t node_count = moving.level_start[level + 1] - moving.level_start[level];
  for (auto a = static_cast<std::uint32_t>(chunk.begin); a < chunk.end && goes_on; ++a) {
    const auto add_two = [&](std::uint32_t i, std::uint32_t j) { return add(moving.proxies[i], moving.proxies[j]); };
    if (level > 0) for_each_overlap_below(moving, level, a, a, add_two);
    for (std::uint32_t b = a + 1; b < node_count && goes_on; ++b)
      if (level > 0 && overlaps(node_boxes[a], node_boxes[b])) for_each_overlap_below(moving, level, a, b, add_two);
    if (goes_on && !others.proxies.empty())
      for_each_overlap_between(moving, level, a, others, [&](std::uint32_t i, std::uint32_t j) {
        return add(moving.proxies[i], others.proxies[j]);
      });
  }
}

/// Lists all pairs of fat AABBs that overlap, in any order. `is_tight`: only the pairs whose tight boxes overlap, too.
/// False: a tick may not have so many pairs, and not all are listed.
bool PairList::list_pairs(const TickLists& tick, BroadPhaseWork& work, const ProxyBoxes& boxes, bool is_tight) const {
  const BoxTree& tree = moving_tree_;
  work.unsorted_pairs.clear();
  if (tree.proxies.empty()) return true;
  const std::size_t proxy_count = tree.proxies.size();
  const bool is_shared = tick.parallel.chunk_size(proxy_count, 128) < proxy_count;
  const std::uint32_t level = is_shared ? shared_level(tree) : top_level(tree);
  const std::size_t node_count = tree.level_start[level + 1] - tree.level_start[level];
  return list_in_chunks(tick, work, node_count, is_shared ? 1 + node_count / 32 : node_count,
                        [&](const Chunk& chunk, PairListing& listing, std::vector<Pair>& pairs) {
                          list_pairs_of_nodes(boxes, {level, is_tight}, chunk, listing, pairs);
                        });
}

PairList::Built PairList::rebuild(const Model& model, const State& state, const TickLists& tick, BroadPhaseWork& work,
                                  ProxyBoxes& boxes, const MotionBounds& bounds) {
  const std::vector<Proxy>& proxies = boxes.proxies();
  const std::size_t proxy_count = proxies.size();
  fat_boxes_.resize(proxy_count);
  tick.parallel.for_chunks(proxy_count, tick.parallel.chunk_size(proxy_count, 128), [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i)
      fat_boxes_[i] = fat_box(model, state, boxes, static_cast<std::uint32_t>(i));
  });
  is_moved_proxy_.assign(proxy_count, 0);
  moved_proxies_.clear();
  for (const bool is_static : {true, false}) {
    work.sort_entries.clear();
    for (std::uint32_t i = 0; i < proxy_count; ++i)
      if (proxies[i].is_static == is_static) work.sort_entries.push_back({0, i});
    build_tree(fat_boxes_, work.sort_entries, work.sort_buffer, is_static ? static_tree_ : moving_tree_);
  }
  const bool fits = list_pairs(tick, work, boxes, false);
  if (!fits) boxes.make_tight(model, state, bounds);
  if (!fits && !list_pairs(tick, work, boxes, true)) return Built::too_many;
  has_pairs_ = true;
  body_generation_ = boxes.key().body_generation;
  ++revision_;
  ticks_held_ = 0;
  sort_pairs(tick.parallel, work, proxy_count, pairs_);
  return fits ? Built::all : Built::tight;
}

/// Adds the pairs of a proxy that has a new fat AABB. Of two such proxies the one with the smaller index finds both.
void PairList::list_pairs_of(const ProxyBoxes& boxes, std::uint32_t index, std::vector<Pair>& pairs) const {
  const Proxy* proxies = boxes.proxies().data();
  const Box box = fat_boxes_[index];
  const auto add = [&](std::uint32_t other) {
    if (may_touch(proxies[index], proxies[other]))
      pairs.push_back(index < other ? Pair{index, other} : Pair{other, index});
    return true;
  };
  for_each_overlap_of(static_tree_, box, [&](std::uint32_t leaf) { return add(static_tree_.proxies[leaf]); });
  for_each_overlap_of(moving_tree_, box, [&](std::uint32_t leaf) {
    const std::uint32_t other = moving_tree_.proxies[leaf];
    return is_moved_proxy_[other] != 0 || add(other);
  });
  for (const std::uint32_t other : moved_proxies_)
    if ((is_moved_proxy_[other] != moved_in_this_tick || index < other) && other != index &&
        overlaps(box, fat_boxes_[other]))
      add(other);
}

bool PairList::follow(const Model& model, const State& state, const TickLists& tick, BroadPhaseWork& work,
                      const ProxyBoxes& boxes) {
  ++ticks_held_;
  if (work.leaving.empty()) return true;
  ++revision_;
  for (const std::uint32_t index : work.leaving) {
    fat_boxes_[index] = fat_box(model, state, boxes, index);
    if (is_moved_proxy_[index] == 0) moved_proxies_.push_back(index);
    is_moved_proxy_[index] = moved_in_this_tick;
  }
  work.unsorted_pairs.clear();
  for (const std::uint32_t index : work.leaving) {
    list_pairs_of(boxes, index, work.unsorted_pairs);
    if (work.unsorted_pairs.size() > tick.pair_count_max) return false;
  }
  const std::vector<Pair>& added = work.pair_rows;
  sort_pairs(tick.parallel, work, boxes.proxies().size(), work.pair_rows);
  std::vector<Pair>& merged = work.merged;
  merged.clear();
  std::size_t next = 0;
  const auto comes_before = [](Pair a, Pair b) {
    return a.first < b.first || (a.first == b.first && a.second < b.second);
  };
  for (const Pair& pair : pairs_) {
    if (is_moved_proxy_[pair.first] == moved_in_this_tick || is_moved_proxy_[pair.second] == moved_in_this_tick)
      continue;
    while (next < added.size() && comes_before(added[next], pair)) merged.push_back(added[next++]);
    merged.push_back(pair);
  }
  while (next < added.size()) merged.push_back(added[next++]);
  pairs_.swap(merged);
  for (const std::uint32_t index : work.leaving) is_moved_proxy_[index] = 1;
  return pairs_.size() <= tick.pair_count_max;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
