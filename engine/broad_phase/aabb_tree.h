// The broad phase that follows bodies from tick to tick.
// SPDX-License-Identifier: MIT
//
// A list of pairs of fat AABBs holds every pair that may touch (pair_list.h). The pairs of a tick are the listed pairs
// whose tight boxes overlap. They are the pairs of any other broad phase and a few more, since boxes of slow bodies
// have a margin. If more fat AABBs overlap than a tick may have pairs, only the pairs of tight boxes are listed, and
// nothing is cached. If lists stay valid for a few ticks only, as in a gas, pairs are listed by cells
// (neighbour_cells.h) for some ticks.
#pragma once

#include "engine/broad_phase/pair_list.h"
#include "engine/model/stage.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The listed pairs whose tight boxes overlap. Key: the revisions of the list and of the boxes.
class PresentPairs final : public TickCache {
 public:
  PresentPairs() : TickCache(CacheKind::present_pairs) {}
  bool valid_for(const PairList& list, const ProxyBoxes& boxes) const;
  void rebuild(const PairList& list, const ProxyBoxes& boxes, const Parallel& parallel,
               std::vector<std::uint32_t>& part_counts);
  void count(bool was_hit) { count_use(was_hit); }
  void invalidate() override { is_valid_ = false; }
  std::span<const Pair> pairs() const { return pairs_; }

 private:
  bool is_valid_ = false;
  std::uint64_t list_revision_ = 0;
  std::uint64_t box_revision_ = 0;
  std::vector<Pair> pairs_;
};

/// The side of the cells by which pairs are listed. Any side gives the same pairs, so a side stays valid for a few
/// ticks.
class CellSide final : public TickCache {
 public:
  CellSide() : TickCache(CacheKind::cell_side) {}
  /// The side, m; 0: it must be found again.
  Real take();
  void rebuild(Real side) {
    side_ = side;
    ticks_left_ = ticks_per_side;
  }
  void renew(Real side) { side_ = side; }
  void invalidate() override { side_ = 0; }

 private:
  static constexpr std::uint32_t ticks_per_side = 8;
  Real side_ = 0;
  std::uint32_t ticks_left_ = 0;
};

class AabbTree final : public Stage {
 public:
  void run(const Model& model, State& state, TickLists& tick, Real dt) override;
  void list_caches(std::vector<TickCache*>& caches) override;
  void poison() override { list_fields(work_, Poison{}); }

  PairList& pair_list() { return pair_list_; }

 private:
  bool list_present_by_cells(const Model& model, const State& state, TickLists& tick, const MotionBounds& bounds);

  BodySet bodies_;
  ProxyBoxes boxes_;
  PairList pair_list_;
  PresentPairs present_;
  CellSide cell_side_;
  BroadPhaseWork work_;
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
