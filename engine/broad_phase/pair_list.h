// The list of pairs of fat AABBs that overlap, followed from tick to tick.
// SPDX-License-Identifier: MIT
// Source: Verlet, "Computer Experiments on Classical Fluids I", 1967 (lists of pairs that may come near, with a margin,
// until something has moved as far).
//
// Each proxy gets a fat AABB that is larger than it needs. While all shapes stay inside, the list of overlapping fat
// AABBs holds every pair that may touch. A proxy that leaves gets a new fat AABB and its pairs are found anew. It is
// then a moved proxy, whose AABB in the tree no longer counts. With many moved proxies, everything is built anew.
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
  /// Whether more proxies have moved, with so many that leave now, than it pays to follow.
  bool are_many_moved(std::size_t leaving_count) const;
  /// Whether the list has held for too few ticks to be worth its making.
  bool is_short_lived() const;
  /// For the next ticks no list is made (high churn); then it is tried again.
  void suspend();
  void resume() { suspended_ticks_ = 0; }
  bool is_suspended() const { return suspended_ticks_ > 0; }
  /// Requires: is_suspended().
  void pass_suspended_tick();

  /// Puts the pairs of the proxies in work.leaving in the place of those they had. False: the list has too many pairs,
  /// and all is to be built anew.
  bool follow(const Model& model, const State& state, const TickLists& tick, BroadPhaseWork& work,
              const ProxyBoxes& boxes);
  enum class Built { all, tight, too_many };
  /// Builds all anew. `tight`: more fat AABBs overlap than a tick may have pairs, and the list holds for this tick
  /// alone.
  Built rebuild(const Model& model, const State& state, const TickLists& tick, BroadPhaseWork& work, ProxyBoxes& boxes,
                const MotionBounds& bounds);
  void count(bool was_hit) { count_use(was_hit); }
  void invalidate() override { has_pairs_ = false; }

  /// Of fat AABBs that overlap, by (first, second).
  const std::vector<Pair>& pairs() const { return pairs_; }
  std::size_t moved_proxy_count() const { return moved_proxies_.size(); }
  /// Ticks since all was built.
  std::uint32_t ticks_held() const { return ticks_held_; }
  /// Another number for each list.
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
  std::uint32_t ticks_held_ = 0;       // since all was built
  std::uint32_t suspended_ticks_ = 0;  // for so many no list is made
  std::vector<Box> fat_boxes_;         // [proxy]
  std::vector<Pair> pairs_;
  std::vector<std::uint8_t> is_moved_proxy_;  // [proxy] has left the fat AABB that is in the tree; 2: in this tick
  std::vector<std::uint32_t> moved_proxies_;
  BoxTree moving_tree_;
  BoxTree static_tree_;
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
