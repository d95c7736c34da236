// The list of pairs of fat AABBs that overlap, followed from tick to tick.
// SPDX-License-Identifier: MIT
// Source: Verlet, "Computer Experiments on Classical Fluids I", 1967 (lists of pairs that may come near, with a
// margin). A list is valid until something has moved by the margin.
//
// Each proxy gets a fat AABB, larger than its tight box. While all shapes stay inside their fat AABBs, the list of
// overlapping fat AABBs holds every pair that may touch. A proxy that leaves its fat AABB gets a new one, and its pairs
// are searched again. It is then a moved proxy, whose AABB in the tree no longer counts. If many proxies have moved,
// everything is rebuilt.
#pragma once

#include <span>
#include <vector>

#include "engine/broad_phase/box_tree.h"
#include "engine/broad_phase/broad_phase_work.h"
#include "engine/broad_phase/proxy_boxes.h"
#include "engine/model/caches.h"
#include "engine/model/model.h"
#include "engine/model/tick_lists.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct PairListing;

/// Key: the generation of the bodies.
class PairList final : public TickCache {
 public:
  PairList() : TickCache(CacheKind::pair_list) {}

  bool valid_for(std::uint32_t body_generation) const { return has_pairs_ && body_generation_ == body_generation; }
  /// The fat AABBs, [proxy].
  std::span<const Box> fat_boxes() const { return fat_boxes_; }
  /// Whether too many proxies have moved to follow them. `leaving_count`: proxies that leave in this tick.
  bool are_many_moved(std::size_t leaving_count) const;
  /// Whether the list has been valid for too few ticks to be worth building.
  bool is_short_lived() const;
  /// High churn: no list is built for the next ticks.
  void suspend();
  void resume() { suspended_ticks_ = 0; }
  bool is_suspended() const { return suspended_ticks_ > 0; }
  /// Requires: is_suspended().
  void pass_suspended_tick();

  /// Replaces the pairs of the proxies in work.leaving. False: the list has too many pairs, and everything must be
  /// rebuilt.
  bool follow(const Model& model, const State& state, const TickLists& tick, BroadPhaseWork& work,
              const ProxyBoxes& boxes);
  enum class Built { all, tight, too_many };
  /// Rebuilds everything. `tight`: more fat AABBs overlap than a tick may have pairs, and the list is valid for this
  /// tick alone.
  Built rebuild(const Model& model, const State& state, const TickLists& tick, BroadPhaseWork& work, ProxyBoxes& boxes,
                const MotionBounds& bounds);
  void count(bool was_hit) { count_use(was_hit); }
  void invalidate() override { has_pairs_ = false; }

  /// The pairs of fat AABBs that overlap, by (first, second).
  const std::vector<Pair>& pairs() const { return pairs_; }
  std::size_t moved_proxy_count() const { return moved_proxies_.size(); }
  /// Ticks since the last rebuild.
  std::uint32_t ticks_held() const { return ticks_held_; }
  /// A different number for each list.
  std::uint64_t revision() const { return revision_; }

 private:
  struct Nodes;
  bool list_pairs(const TickLists& tick, BroadPhaseWork& work, const ProxyBoxes& boxes, bool is_tight) const;
  void list_pairs_of_nodes(const ProxyBoxes& boxes, const Nodes& nodes, const Chunk& chunk, PairListing& listing,
                           std::vector<Pair>& pairs) const;
  void list_pairs_of(const ProxyBoxes& boxes, std::uint32_t index, std::vector<Pair>& pairs) const;

  bool has_pairs_ = false;
  std::uint32_t body_generation_ = 0;
  std::uint64_t revision_ = 0;
  std::uint32_t ticks_held_ = 0;       // since the last rebuild
  std::uint32_t suspended_ticks_ = 0;  // ticks to come without a list
  std::vector<Box> fat_boxes_;         // [proxy]
  std::vector<Pair> pairs_;
  std::vector<std::uint8_t> is_moved_proxy_;  // [proxy] has left the fat AABB that is in the tree; 2: in this tick
  std::vector<std::uint32_t> moved_proxies_;
  BoxTree moving_tree_;
  BoxTree static_tree_;
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
