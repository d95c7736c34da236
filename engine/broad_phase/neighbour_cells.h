// The pairs of one tick, without a cache, for scenes in which most bodies move.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "engine/broad_phase/broad_phase.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

enum class CellListing { done, too_many, unsuited };

/// Fills work.unsorted_pairs with the pairs that may touch and whose boxes overlap. `too_many`: more pairs than a tick
/// may have. `unsuited`: boxes differ too much in size or lie too far apart, and no pair is listed. `boxes`: [proxy].
/// `side`: of the boxes that share cells, m; 0: to be found. A side of a few ticks ago saves the search.
CellListing list_by_cells(const TickLists& tick, BroadPhaseWork& work, std::span<const Proxy> proxies,
                          const std::vector<Box>& boxes, Real& side);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
