// Broad phase: pairs of shapes that may touch. Every algorithm gives the same bits: any superset of the touching pairs
// is enough, since the narrow phase decides on contacts, and pairs are sorted before it.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "engine/broad_phase/broad_phase_work.h"
#include "engine/model/enclosures.h"
#include "engine/model/model.h"
#include "engine/model/stage.h"
#include "engine/model/tick_lists.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The stage of this kind.
std::unique_ptr<Stage> make_broad_phase(BroadPhaseKind kind);

/// Appends a proxy for each shape of the body at `row` that can touch another.
void add_proxies(const Model& model, const State& state, std::uint32_t row, std::vector<Proxy>& proxies);

/// Fills tick.proxies and work.boxes from the present poses.
void make_proxies(const Model& model, const State& state, TickLists& tick, BroadPhaseWork& work, Real dt);

/// A box without its CCD margin.
inline Box inner_box(const Box& box, Real ccd_margin) {
  const Vec2 extent{ccd_margin, ccd_margin};
  return ccd_margin > 0 ? Box{box.lower + extent, box.upper - extent} : box;
}

/// Whether two proxies with overlapping boxes are a pair.
inline bool are_pair(const Proxy& a, const Proxy& b, const Box& box_a, const Box& box_b) {
  if (!may_touch(a, b)) return false;
  if (a.ccd_margin < 0 || b.ccd_margin < 0 || a.ccd_margin + b.ccd_margin <= 0) return true;
  return overlaps(inner_box(box_a, a.ccd_margin), inner_box(box_b, b.ccd_margin));
}

/// Whether `pair_count` is more than a tick may have. If so, also sets tick.has_too_many_pairs and lists no pair. Only
/// pairs (are_pair) with overlapping boxes count, so that every broad phase gives up in the same tick.
bool are_too_many(TickLists& tick, std::size_t pair_count);

/// Sorts work.unsorted_pairs (each pair once, any order) into `pairs`.
void sort_pairs(const Parallel& parallel, BroadPhaseWork& work, std::size_t proxy_count, std::vector<Pair>& pairs);
/// The same, as the pairs of this tick.
inline void list_sorted(TickLists& tick, BroadPhaseWork& work, std::size_t proxy_count) {
  sort_pairs(tick.parallel, work, proxy_count, work.pair_rows);
  tick.pairs = work.pair_rows;
}

void brute_force(const Model& model, State& state, TickLists& tick, BroadPhaseWork& work, Real dt);
void bounding_circle(const Model& model, State& state, TickLists& tick, BroadPhaseWork& work, Real dt);
void sweep_and_prune(const Model& model, State& state, TickLists& tick, BroadPhaseWork& work, Real dt);
void uniform_grid(const Model& model, State& state, TickLists& tick, BroadPhaseWork& work, Real dt);

/// The largest integer not above `value`, at most `limit` away from 0; 0 for a NaN. Never decreases as `value` rises.
/// Requires: limit is a power of two, at most 2^30.
inline std::int32_t clamped_floor(Real value, Real limit) {
  if (!(value > -limit)) return value == value ? -static_cast<std::int32_t>(limit) : 0;
  if (value >= limit) return static_cast<std::int32_t>(limit);
  const auto whole = static_cast<std::int32_t>(value);
  return static_cast<Real>(whole) > value ? whole - 1 : whole;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
