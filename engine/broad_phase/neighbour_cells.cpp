// Cells larger than the boxes in them: boxes of neighbouring cells are compared.
// SPDX-License-Identifier: MIT
// Source: Ericson, "Real-Time Collision Detection", 2005, section 7.1 (an object in one cell, half of its neighbours);
// Knuth, "The Art of Computer Programming", volume 3, 1998, section 5.2 (sorting by counting).
//
// A box belongs to the cell of its lower corner. All boxes that overlap it are then in the same cell or in one of the
// eight around it. A few boxes are larger than a cell or far from the others. They are compared with each other and
// with the boxes of the cells that they overlap.
//
// Fast proxies (Proxy::ccd_margin > 0) have boxes without CCD margins in these cells. Their whole boxes are compared
// with CCD targets only, which have cells of their own.
#include "engine/broad_phase/neighbour_cells.h"

#include <algorithm>

#include "engine/broad_phase/pair_listing.h"
#include "engine/simd/realx4.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr Real cell_margin_share = Real(1.02);     // far more than the rounding of a cell index
constexpr Real cells_in_line_max = Real(1 << 15);  // with more cells in a line, boxes are unsuited
constexpr Real cells_per_box = 2;                  // the largest number of cells per box
constexpr Real cell_ratio_max = 8;                 // of a cell to its boxes
constexpr Real size_ratio_max = 4;                 // of the largest of these boxes to the median
constexpr std::size_t few = 12;                    // this many boxes may always be larger than a cell
constexpr int side_fraction_bits_dropped = 20;

Real side_of(const Box& box) {
  return larger(box.upper.x - box.lower.x, box.upper.y - box.lower.y);
}
/// False for a box with a NaN.
bool fits_into(const Box& box, Real side) {
  return box.upper.x - box.lower.x <= side && box.upper.y - box.lower.y <= side;
}

/// The largest number of boxes that may be larger than a cell. Comparing these with each other takes two tests per box.
std::size_t large_count_max(std::size_t count) {
  return few + static_cast<std::size_t>(2 * square_root(static_cast<Real>(count)));
}

/// The largest side of the boxes that are not large, m; 0 if sides differ too much. Sides are counted in bins of an
/// eighth of a power of two.
Real common_side(const std::vector<Box>& boxes, std::vector<std::uint32_t>& counts) {
  counts.assign(1u << 11, 0);
  for (const Box& box : boxes) {
    const Real side = smaller(side_of(box), Real(1e38));
    ++counts[bits_of(static_cast<float>(side)) >> side_fraction_bits_dropped & 0x7ffu];
  }
  if (boxes.size() <= 2 * large_count_max(boxes.size())) return 0;
  const auto side_above = [&](std::size_t rank) {
    std::uint32_t bin = 0;
    for (std::size_t seen = counts[0]; seen <= rank && bin < 0x7efu; seen += counts[bin]) ++bin;
    return static_cast<Real>(float_of_bits((bin + 1) << side_fraction_bits_dropped));
  };
  const Real most = side_above(boxes.size() - 1 - large_count_max(boxes.size()));
  return most <= size_ratio_max * side_above(boxes.size() / 2) && most > Real(1e-30) && most < Real(1e30) ? most : 0;
}

constexpr std::uint32_t looked_at_least = 3;  // boxes of the next row that are tested without a branch
constexpr std::uint32_t in_no_cell = 0xffffffffu;

/// Cells in rows, with an empty cell before and after each row, and an empty row at the end.
struct Cells {
  Vec2 lowest;  // m
  Real inv_size;
  std::uint32_t columns;  // with the empty ones
  std::uint32_t rows;     // with the empty one
};

bool contains_corner(const Spread& spread, Vec2 corner) {
  return corner.x >= spread.lowest.x && corner.x <= spread.highest.x && corner.y >= spread.lowest.y &&
         corner.y <= spread.highest.y;
}

Spread of_both(const Spread& a, const Spread& b) {
  return {{smaller(a.lowest.x, b.lowest.x), smaller(a.lowest.y, b.lowest.y)},
          {larger(a.highest.x, b.highest.x), larger(a.highest.y, b.highest.y)}};
}

constexpr std::size_t boxes_per_chunk_least = 256;

/// Fills work.inner_boxes; finds the CCD margins and the range of the boxes of at most this side.
BoxOutline outline_of(const Parallel& parallel, BroadPhaseWork& work, std::span<const Proxy> proxies,
                      const std::vector<Box>& boxes, Real side) {
  const std::size_t count = boxes.size();
  const std::size_t size = parallel.chunk_size(count, boxes_per_chunk_least);
  work.inner_boxes.resize(count);
  work.outlines.assign(Parallel::chunk_count(count, size), {});
  parallel.for_chunks(count, size, [&](const Chunk& chunk) {
    BoxOutline outline;
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const Real ccd_margin = proxies[i].ccd_margin;
      outline.farthest = larger(outline.farthest, ccd_margin);
      outline.any_ccd_target |= ccd_margin < 0;
      const Box box = inner_box(boxes[i], ccd_margin);
      work.inner_boxes[i] = box;
      if (fits_into(box, side)) outline.spread = of_both(outline.spread, {box.lower, box.lower});
    }
    work.outlines[chunk.index] = outline;
  });
  BoxOutline all;
  for (const BoxOutline& part : work.outlines)
    all = {of_both(all.spread, part.spread), larger(all.farthest, part.farthest),
           all.any_ccd_target || part.any_ccd_target};
  return all;
}

/// Removes corners farther than some deviations from the mean, several times, since outliers affect the first mean.
Spread without_outliers(const std::vector<Box>& boxes, Real side, Spread spread) {
  constexpr Real deviations = 4;
  const auto for_each = [&](auto use) {
    for (const Box& box : boxes)
      if (fits_into(box, side) && contains_corner(spread, box.lower)) use(box.lower);
  };
  for (int pass = 0; pass < 3; ++pass) {
    Real count = 0;
    Vec2 mean;
    for_each([&](Vec2 corner) {
      mean = mean + corner;
      ++count;
    });
    mean = (1 / larger(count, 1)) * mean;
    Vec2 deviation;
    for_each([&](Vec2 corner) {
      deviation = deviation + Vec2{absolute(corner.x - mean.x), absolute(corner.y - mean.y)};
    });
    const Vec2 extent = (deviations / larger(count, 1)) * deviation;
    spread = {mean - extent, mean + extent};
  }
  return spread;
}

/// Cells of this side for `count` boxes within `spread`; without rows if boxes are unsuited.
Cells cells_in(const Spread& spread, Real side, std::size_t count) {
  const Vec2 extent = spread.highest - spread.lowest;
  const Real area_per_cell = extent.x * extent.y / (cells_per_box * static_cast<Real>(count));
  const Real size = larger(cell_margin_share * side, square_root(area_per_cell));
  if (!(size <= cell_ratio_max * side)) return {};
  const Real inv_size = 1 / size;
  if (!(extent.x * inv_size < cells_in_line_max) || !(extent.y * inv_size < cells_in_line_max)) return {};
  return {spread.lowest, inv_size, static_cast<std::uint32_t>(extent.x * inv_size) + 3,
          static_cast<std::uint32_t>(extent.y * inv_size) + 2};
}

/// Cells for the boxes of at most this side, or for all but a few outliers, which `spread` then excludes. Without rows
/// if boxes are unsuited.
Cells cells_for(const std::vector<Box>& boxes, Real side, Spread& spread) {
  const Cells cells = cells_in(spread, side, boxes.size());
  if (cells.rows > 0) return cells;
  spread = without_outliers(boxes, side, spread);
  return cells_in(spread, side, boxes.size());
}

/// Writes to work.counts the cell of each box of at most this side within `spread`. Lists the other boxes in
/// work.large.
void find_cells(const Parallel& parallel, BroadPhaseWork& work, const std::vector<Box>& boxes, Real side,
                const Spread& spread, const Cells& cells) {
  std::vector<std::uint32_t>& cell_of = work.counts;
  cell_of.resize(boxes.size());
  parallel.for_chunks(boxes.size(), parallel.chunk_size(boxes.size(), boxes_per_chunk_least), [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      cell_of[i] = in_no_cell;
      if (!fits_into(boxes[i], side) || !contains_corner(spread, boxes[i].lower)) continue;
      const Vec2 place = cells.inv_size * (boxes[i].lower - cells.lowest);
      const auto row = static_cast<std::uint32_t>(static_cast<std::int32_t>(place.y));
      const auto column = static_cast<std::uint32_t>(static_cast<std::int32_t>(place.x)) + 1;
      cell_of[i] = row * cells.columns + column;
    }
  });
  work.large.clear();
  for (std::uint32_t i = 0; i < boxes.size(); ++i)
    if (cell_of[i] == in_no_cell) work.large.push_back(i);
}

/// Sorts the boxes that are not in work.large by cell. Requires: find_cells.
void fill_cells(BroadPhaseWork& work, const std::vector<Box>& boxes, const Cells& cells) {
  std::vector<std::uint32_t>& start = work.cell_starts;
  const std::vector<std::uint32_t>& cell_of = work.counts;
  start.assign(std::size_t{cells.columns} * cells.rows + 1, 0);
  for (const std::uint32_t cell : cell_of)
    if (cell != in_no_cell) ++start[cell + 1];
  for (std::size_t i = 1; i < start.size(); ++i) start[i] += start[i - 1];
  work.swept_boxes.resize(boxes.size() + looked_at_least);
  work.swept_places.resize(boxes.size());
  // Each start moves to the end of its cell, which is the start of the next cell.
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    if (cell_of[i] == in_no_cell) continue;
    const std::uint32_t place = start[cell_of[i]]++;
    work.swept_boxes[place] = boxes[i];
    work.swept_places[place] = {i, cell_of[i]};
  }
  for (std::size_t i = 0; i < looked_at_least; ++i)
    work.swept_boxes[boxes.size() - work.large.size() + i] = boxes[0];  // read, but never counted
}

/// A box that is compared with many others.
struct Query {
  Realx4 most;  // upper bounds of lower corners, and of negated upper corners

  explicit Query(const Box& box) {
    const Real corners[4] = {box.upper.x, box.upper.y, -box.lower.x, -box.lower.y};
    most = load_x4(corners);
  }
  /// overlaps(), without a branch.
  bool overlaps(const Box& other) const {
    const Real signs[4] = {1, 1, -1, -1};
    return all_at_most(load_x4(signs) * load_x4(&other.lower.x), most);
  }
};
static_assert(sizeof(Box) == 4 * sizeof(Real));

/// Writes to `out` the pairs of a box with the overlapping boxes of begin..end-1; returns their end. The first `least`
/// tests have no branches, since number and outcome are hard to predict.
template <std::uint32_t least>
Pair* meet(const Box* boxes, const Query& query, std::uint32_t i, std::uint32_t begin, std::uint32_t end, Pair* out) {
  const auto test = [&](std::uint32_t j, bool counts) {
    *out = {i, j};
    out += static_cast<std::size_t>(counts & query.overlaps(boxes[j]));
  };
  for (std::uint32_t k = 0; k < least; ++k) test(begin + k, begin + k < end);
  for (std::uint32_t j = begin + least; j < end; ++j) test(j, true);
  return out;
}

/// The list of a chunk: appends pairs that may touch, until there are too many.
struct PairsOfChunk {
  const BroadPhaseWork& work;
  std::span<const Proxy> proxies;
  PairListing& listing;
  std::vector<Pair>& pairs;
  std::size_t count;

  void reserve(std::size_t more) {
    if (pairs.size() < count + more) pairs.resize(2 * (count + more));
  }
  /// Adds a pair of overlapping inner boxes. Pairs of a fast proxy and a CCD target are listed separately. Requires:
  /// capacity.
  bool add_inner(std::uint32_t a, std::uint32_t b) {
    const Real margin_a = proxies[a].ccd_margin;
    const Real margin_b = proxies[b].ccd_margin;
    return (margin_a < 0 && margin_b > 0) || (margin_a > 0 && margin_b < 0) || add(a, b);
  }
  /// Adds a pair. Requires: capacity.
  bool add(std::uint32_t a, std::uint32_t b) {
    if (!may_touch(proxies[a], proxies[b])) return true;
    pairs[count++] = a < b ? Pair{a, b} : Pair{b, a};
    return listing.goes_on(count);
  }
};

/// Lists the pairs of the sorted boxes begin..end-1 with later boxes.
bool meet_neighbours(const Cells& cells, std::size_t begin, std::size_t end, PairsOfChunk& out) {
  const BroadPhaseWork& work = out.work;
  const Box* boxes = work.swept_boxes.data();
  const std::uint32_t* end_of = work.cell_starts.data();  // [cell] its end: fill_cells has moved it
  for (std::size_t place = begin; place < end; ++place) {
    const auto i = static_cast<std::uint32_t>(place);
    const std::uint32_t cell = work.swept_places[i].cell;
    const std::uint32_t right_end = end_of[cell + 1];
    const std::uint32_t next_begin = end_of[cell + cells.columns - 2];
    const std::uint32_t next_end = end_of[cell + cells.columns + 1];
    out.reserve((right_end - i) + (next_end - next_begin) + 2 * looked_at_least);
    const Query query(boxes[i]);
    Pair* found = out.pairs.data() + out.count;
    Pair* found_end = meet<2>(boxes, query, i, i + 1, right_end, found);
    found_end = meet<looked_at_least>(boxes, query, i, next_begin, next_end, found_end);
    for (; found < found_end; ++found)
      if (!out.add_inner(work.swept_places[found->first].proxy, work.swept_places[found->second].proxy)) return false;
  }
  return true;
}

/// The index of a row or column for a coordinate, below `count`; the last for a NaN.
std::uint32_t clamped(Real place, std::uint32_t count) {
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(larger(0, smaller(place, static_cast<Real>(count - 1)))));
}

/// Calls use(place) for the entries whose boxes may overlap `box`, row by row, until `use` returns false. `end_of`:
/// [cell] the end of the entries of the cell.
template <typename Reserve, typename Use>
bool for_cells_of(const Cells& cells, const std::vector<std::uint32_t>& end_of, const Box& box, Reserve reserve,
                  Use use) {
  // A box that overlaps `box` begins in a cell of `box`, or one cell before.
  const Vec2 first = cells.inv_size * (box.lower - cells.lowest);
  const Vec2 last = cells.inv_size * (box.upper - cells.lowest);
  const std::uint32_t first_column = clamped(first.x - 1, cells.columns - 2) + 1;
  const std::uint32_t last_column = clamped(last.x, cells.columns - 2) + 1;
  const std::uint32_t last_row = clamped(last.y, cells.rows - 1);
  for (std::uint32_t row = clamped(first.y - 1, cells.rows - 1); row <= last_row; ++row) {
    const std::uint32_t end = end_of[row * cells.columns + last_column];
    std::uint32_t place = end_of[row * cells.columns + first_column - 1];
    if (place < end) reserve(end - place);
    for (; place < end; ++place)
      if (!use(place)) return false;
  }
  return true;
}

/// Fast proxies and CCD targets of this tick.
struct FastProxies {
  const std::vector<Box>& boxes;  // [proxy] with CCD margins
  Real farthest = 0;              // m, the largest CCD margin
  bool any_ccd_target = false;
};

/// Lists the pairs of a fast proxy with CCD targets in cells.
bool meet_ccd_targets(const Cells& cells, const FastProxies& fast, std::uint32_t index, PairsOfChunk& out) {
  const BroadPhaseWork& work = out.work;
  const Query query(fast.boxes[index]);
  return for_cells_of(
      cells, work.ccd_target_starts, fast.boxes[index], [&](std::size_t more) { out.reserve(more); },
      [&](std::uint32_t place) {
        const std::uint32_t other = work.ccd_target_places[place];
        return !query.overlaps(fast.boxes[other]) || out.add(index, other);
      });
}

/// Lists the pairs of a large CCD target with fast proxies.
bool meet_fast(const Cells& cells, const FastProxies& fast, std::uint32_t index, PairsOfChunk& out) {
  const BroadPhaseWork& work = out.work;
  const Box& box = fast.boxes[index];
  const Query query(box);
  const auto test = [&](std::uint32_t other) {
    if (!(out.proxies[other].ccd_margin > 0) || !query.overlaps(fast.boxes[other])) return true;
    return out.add(index, other);
  };
  out.reserve(work.large.size());
  for (const std::uint32_t large : work.large)
    if (!test(large)) return false;
  const Vec2 far{larger(absolute(box.lower.x), absolute(box.upper.x)),
                 larger(absolute(box.lower.y), absolute(box.upper.y))};
  const Vec2 farthest{fast.farthest, fast.farthest};
  const Vec2 extent = farthest + 16 * epsilon * (far + farthest);
  const Box around{box.lower - extent, box.upper + extent};
  const Query around_query(around);
  return for_cells_of(
      cells, work.cell_starts, around, [&](std::size_t more) { out.reserve(more); },
      [&](std::uint32_t place) {
        return !around_query.overlaps(work.swept_boxes[place]) || test(work.swept_places[place].proxy);
      });
}

/// Lists the pairs of a large box with later large boxes and with the boxes in cells.
bool meet_large(const Cells& cells, const std::vector<Box>& boxes, const FastProxies& fast, std::size_t which,
                PairsOfChunk& out) {
  const BroadPhaseWork& work = out.work;
  const std::uint32_t index = work.large[which];
  const Query query(boxes[index]);
  out.reserve(work.large.size());
  for (std::size_t k = which + 1; k < work.large.size(); ++k)
    if (query.overlaps(boxes[work.large[k]]) && !out.add_inner(index, work.large[k])) return false;
  const bool goes_on = for_cells_of(
      cells, work.cell_starts, boxes[index], [&](std::size_t more) { out.reserve(more); },
      [&](std::uint32_t place) {
        return !query.overlaps(work.swept_boxes[place]) || out.add_inner(index, work.swept_places[place].proxy);
      });
  if (!goes_on || !fast.any_ccd_target || !(fast.farthest > 0) || out.proxies[index].ccd_margin == 0) return goes_on;
  return out.proxies[index].ccd_margin > 0 ? meet_ccd_targets(cells, fast, index, out)
                                           : meet_fast(cells, fast, index, out);
}

/// Sorts the CCD targets that are not in work.large by cell. Requires: fill_cells.
void fill_ccd_target_cells(BroadPhaseWork& work, std::span<const Proxy> proxies) {
  std::vector<std::uint32_t>& start = work.ccd_target_starts;
  const std::vector<std::uint32_t>& cell_of = work.counts;
  start.assign(work.cell_starts.size(), 0);
  const auto for_each = [&](auto use) {
    for (std::uint32_t i = 0; i < proxies.size(); ++i)
      if (proxies[i].ccd_margin < 0 && cell_of[i] != in_no_cell) use(i);
  };
  for_each([&](std::uint32_t i) { ++start[cell_of[i] + 1]; });
  for (std::size_t i = 1; i < start.size(); ++i) start[i] += start[i - 1];
  work.ccd_target_places.resize(start.back());
  for_each([&](std::uint32_t i) { work.ccd_target_places[start[cell_of[i]]++] = i; });
}

}  // namespace

CellListing list_by_cells(const TickLists& tick, BroadPhaseWork& work, std::span<const Proxy> proxies,
                          const std::vector<Box>& all_boxes, Real& side) {
  BoxOutline outline = outline_of(tick.parallel, work, proxies, all_boxes, side);
  const std::vector<Box>& boxes = work.inner_boxes;
  if (side == 0) {
    side = common_side(boxes, work.counts);
    if (side == 0) return CellListing::unsuited;
    outline = outline_of(tick.parallel, work, proxies, all_boxes, side);
  }
  const Cells cells = cells_for(boxes, side, outline.spread);
  if (cells.rows == 0) return CellListing::unsuited;
  find_cells(tick.parallel, work, boxes, side, outline.spread, cells);
  if (work.large.size() > 2 * large_count_max(boxes.size())) return CellListing::unsuited;
  fill_cells(work, boxes, cells);
  const FastProxies fast{all_boxes, outline.farthest * (1 + 64 * epsilon),
                         outline.any_ccd_target};  // the rounding of ccd_margin_of
  const bool some_are_fast = fast.farthest > 0 && fast.any_ccd_target;
  if (some_are_fast) fill_ccd_target_cells(work, proxies);
  // Boxes in cells come first, then large boxes.
  const std::size_t end_in_cells = boxes.size() - work.large.size();
  const bool fits =
      list_in_chunks(tick, work, boxes.size(), tick.parallel.chunk_size(boxes.size(), 128),
                     [&](const Chunk& chunk, PairListing& listing, std::vector<Pair>& pairs) {
                       PairsOfChunk out{work, proxies, listing, pairs, pairs.size()};
                       const std::size_t end = std::min(chunk.end, end_in_cells);
                       bool goes_on = chunk.begin >= end || meet_neighbours(cells, chunk.begin, end, out);
                       for (std::size_t place = chunk.begin; some_are_fast && goes_on && place < end; ++place) {
                         const std::uint32_t index = work.swept_places[place].proxy;
                         if (proxies[index].ccd_margin > 0) goes_on = meet_ccd_targets(cells, fast, index, out);
                       }
                       for (std::size_t i = std::max(chunk.begin, end_in_cells); goes_on && i < chunk.end; ++i)
                         goes_on = meet_large(cells, boxes, fast, i - end_in_cells, out);
                       pairs.resize(out.count);
                     });
  return fits ? CellListing::done : CellListing::too_many;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
