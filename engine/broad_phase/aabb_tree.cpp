// The broad phase that follows bodies from tick to tick.
// SPDX-License-Identifier: MIT
#include "engine/broad_phase/aabb_tree.h"

#include "engine/broad_phase/broad_phase.h"
#include "engine/broad_phase/neighbour_cells.h"
#include "engine/model/selection.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

// If more than one in this many bodies that are not static has an unchanged pose, the narrow phase looks for contacts
// that it can keep.
constexpr std::size_t bodies_per_unchanged = 4;

/// Copies the pairs whose boxes overlap; returns their number. No shape has a CCD margin. The loop has no branch, since
/// the outcome is hard to predict.
std::size_t copy_overlapping(std::span<const Pair> pairs, const Box* boxes, Pair* out) {
  std::size_t count = 0;
  for (const Pair pair : pairs) {
    const Box& a = boxes[pair.first];
    const Box& b = boxes[pair.second];
    out[count] = pair;
    count += static_cast<std::size_t>((a.lower.x <= b.upper.x) & (b.lower.x <= a.upper.x) & (a.lower.y <= b.upper.y) &
                                      (b.lower.y <= a.upper.y));
  }
  return count;
}

/// Copies the pairs of this tick; returns how many.
std::size_t copy_present(std::span<const Pair> pairs, const ProxyBoxes& boxes, Pair* out) {
  const Box* tight = boxes.boxes().data();
  if (!boxes.any_ccd_margin()) return copy_overlapping(pairs, tight, out);
  const Proxy* proxies = boxes.proxies().data();
  std::size_t count = 0;
  for (const Pair pair : pairs) {
    const Box& a = tight[pair.first];
    const Box& b = tight[pair.second];
    if (overlaps(a, b) && are_pair(proxies[pair.first], proxies[pair.second], a, b)) out[count++] = pair;
  }
  return count;
}

}  // namespace

bool PresentPairs::valid_for(const PairList& list, const ProxyBoxes& boxes) const {
  return is_valid_ && list_revision_ == list.revision() && box_revision_ == boxes.revision();
}

void PresentPairs::rebuild(const PairList& list, const ProxyBoxes& boxes, const Parallel& parallel,
                           std::vector<std::uint32_t>& part_counts) {
  const std::span<const Pair> pairs = list.pairs();
  pairs_.resize(pairs.size());
  pairs_.resize(select_in_chunks(parallel, part_counts, pairs.size(), 512, pairs_.data(),
                                 [&](std::size_t begin, std::size_t end, Pair* out) {
                                   return copy_present(pairs.subspan(begin, end - begin), boxes, out);
                                 }));
  is_valid_ = true;
  list_revision_ = list.revision();
  box_revision_ = boxes.revision();
}

Real CellSide::take() {
  const bool is_hit = side_ > 0 && ticks_left_ > 0;
  count_use(is_hit);
  if (!is_hit) return 0;
  --ticks_left_;
  return side_;
}

/// Lists the pairs of this tick alone, by cells. False: the scene does not suit cells.
bool AabbTree::list_present_by_cells(const Model& model, const State& state, TickLists& tick,
                                     const MotionBounds& bounds) {
  Real side = cell_side_.take();
  const bool had_side = side > 0;
  const auto list = [&] { return list_by_cells(tick, work_, boxes_.proxies(), boxes_.boxes(), side); };
  CellListing listing = list();
  if (listing == CellListing::unsuited && had_side) {
    side = 0;
    listing = list();
  }
  if (!had_side || listing == CellListing::unsuited) cell_side_.rebuild(side);
  if (listing == CellListing::too_many) {
    boxes_.make_tight(model, state, bounds);
    listing = list();
  }
  if (listing == CellListing::unsuited) return false;
  if (listing == CellListing::too_many)
    are_too_many(tick, tick.pair_count_max + 1);
  else
    list_sorted(tick, work_, boxes_.proxies().size());
  return true;
}

void AabbTree::run(const Model& model, State& state, TickLists& tick, Real dt) {
  const MotionBounds bounds = motion_bounds_of_tick(model, state, dt);
  bodies_.follow(model, state, tick.parallel);
  const BoxKey key{bodies_.generation(), dt, gravity_displacement_of_tick(model, state), bounds.farthest};
  const bool has_list = pair_list_.valid_for(key.body_generation);
  const bool was_suspended = pair_list_.is_suspended();
  boxes_.follow(model, state, tick.parallel, work_, bounds, key,
                !was_suspended && !bounds.locates_impacts && !bounds.speculates,
                has_list ? pair_list_.fat_boxes() : std::span<const Box>());
  tick.proxies = boxes_.proxies();
  tick.changes = {true, key.body_generation, boxes_.is_unchanged(), false, boxes_.any_swept(), false};
  std::size_t unchanged_count = 0;
  for (const std::uint8_t is_unchanged : tick.changes.is_unchanged) unchanged_count += is_unchanged;
  const std::size_t moving_count = state.bodies.size() - bodies_.static_count();
  tick.changes.many_are_unchanged = bodies_per_unchanged * (unchanged_count - bodies_.static_count()) > moving_count;

  const bool are_many_moved = pair_list_.are_many_moved(work_.leaving.size());
  if (model.is_composed && has_list && are_many_moved && pair_list_.is_short_lived()) pair_list_.suspend();
  bool builds = !has_list || are_many_moved;
  if (pair_list_.is_suspended()) {
    pair_list_.pass_suspended_tick();
    if (list_present_by_cells(model, state, tick, bounds)) return;
    pair_list_.resume();
    builds = true;
  }
  pair_list_.count(!builds);
  if (builds || !pair_list_.follow(model, state, tick, work_, boxes_)) {
    cell_side_.invalidate();
    const PairList::Built built = pair_list_.rebuild(model, state, tick, work_, boxes_, bounds);
    if (built == PairList::Built::too_many) {
      are_too_many(tick, tick.pair_count_max + 1);
      return;
    }
    if (built == PairList::Built::tight) {
      bodies_.invalidate();
      tick.changes.is_known = false;
    }
  }
  tick.changes.same_pairs = present_.valid_for(pair_list_, boxes_);
  present_.count(tick.changes.same_pairs);
  if (!tick.changes.same_pairs) present_.rebuild(pair_list_, boxes_, tick.parallel, work_.part_counts);
  tick.pairs = present_.pairs();
}

void AabbTree::list_caches(std::vector<TickCache*>& caches) {
  for (TickCache* cache : std::initializer_list<TickCache*>{&bodies_, &boxes_, &pair_list_, &present_, &cell_side_})
    caches.push_back(cache);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
