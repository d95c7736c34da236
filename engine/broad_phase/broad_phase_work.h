// The workspaces of broad phases.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "engine/broad_phase/sorting.h"
#include "engine/math/vec2.h"
#include "engine/model/enclosures.h"
#include "engine/model/poison.h"
#include "engine/model/proxies.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The range of lower corners, m.
struct Spread {
  Vec2 lowest{Real(1e38), Real(1e38)};
  Vec2 highest{Real(-1e38), Real(-1e38)};
};

/// Common bounds of boxes.
struct BoxOutline {
  Spread spread;      // of boxes that fit into cells
  Real farthest = 0;  // m, the largest CCD margin
  bool any_ccd_target = false;
};

/// The workspace in which a range of pairs is sorted.
struct PairSorter {
  std::vector<Pair> pairs;
  std::vector<Pair> by_second;
  std::vector<std::uint32_t> start;  // [proxy]
};

template <typename Visit>
void list_fields(PairSorter& of, const Visit& visit) {
  auto& [pairs, by_second, start] = of;
  visit(pairs, by_second, start);
}

/// The origin of a box in the order of cells.
struct SweptPlace {
  std::uint32_t proxy;
  std::uint32_t cell;
};

/// The cells of the uniform grid that a proxy's box overlaps, both ends included.
struct CellRange {
  std::int32_t first_x;
  std::int32_t first_y;
  std::int32_t last_x;
  std::int32_t last_y;
};

/// A proxy in one cell.
struct CellEntry {
  std::int32_t x;
  std::int32_t y;
  std::uint32_t proxy;
};

/// The workspace of a broad phase in a tick.
struct BroadPhaseWork {
  std::vector<Proxy> proxy_rows;
  std::vector<Box> boxes;       // [proxy] m, around the shapes with their margins; not filled by aabb_tree
  std::vector<Circle> circles;  // [proxy], bounding_circle
  std::vector<Pair> pair_rows;  // of this tick, if pairs are not cached
  std::vector<Pair> unsorted_pairs;
  std::vector<std::vector<Pair>> pair_parts;  // [chunk] aabb_tree, neighbour_cells
  std::vector<PairSorter> pair_sorters;       // [part]
  std::vector<std::uint32_t> part_counts;     // [chunk]
  std::vector<std::uint32_t> counts;
  std::vector<SortEntry> sort_entries;  // sweep_and_prune, aabb_tree
  std::vector<SortEntry> sort_buffer;
  std::vector<std::uint32_t> leaving;            // aabb_tree: proxies that are not inside their fat boxes
  std::vector<Pair> merged;                      // aabb_tree: the pairs that replace those of the list
  std::vector<Box> swept_boxes;                  // sweep_and_prune: in sweep order; neighbour_cells: by cell
  std::vector<SweptPlace> swept_places;          // neighbour_cells: origins of swept_boxes
  std::vector<CellRange> cell_ranges;            // uniform_grid, [proxy]
  std::vector<CellEntry> cell_entries;           // uniform_grid, by bucket, dynamic ones first
  std::vector<std::uint32_t> cell_starts;        // uniform_grid, [bucket]; neighbour_cells, [cell]
  std::vector<std::uint32_t> large;              // uniform_grid, neighbour_cells: proxies in no cell, ascending
  std::vector<Box> inner_boxes;                  // neighbour_cells, [proxy] without the margin for CCD
  std::vector<BoxOutline> outlines;              // neighbour_cells, [chunk]
  std::vector<std::uint32_t> ccd_target_starts;  // neighbour_cells: [cell]
  std::vector<std::uint32_t> ccd_target_places;  // neighbour_cells: proxies for CCD alone, by cell
};

template <typename Visit>
void list_fields(BroadPhaseWork& of, const Visit& visit) {
  auto& [proxy_rows, boxes, circles, pair_rows, unsorted_pairs, pair_parts, pair_sorters, part_counts, counts,
         sort_entries, sort_buffer, leaving, merged, swept_boxes, swept_places, cell_ranges, cell_entries, cell_starts,
         large, inner_boxes, outlines, ccd_target_starts, ccd_target_places] = of;
  visit(proxy_rows, boxes, circles, pair_rows, unsorted_pairs, in_place(pair_parts), in_place(pair_sorters),
        part_counts, counts, sort_entries, sort_buffer, leaving, merged, swept_boxes, swept_places, cell_ranges,
        cell_entries, cell_starts, large, inner_boxes, outlines, ccd_target_starts, ccd_target_places);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
