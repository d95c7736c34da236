// Uniform grid: a box is in each square cell that it overlaps; boxes that share a cell are compared.
// SPDX-License-Identifier: MIT
// Source: Ericson, "Real-Time Collision Detection", 2005, sections 7.1.1 to 7.1.3 (cell size, hashed cells); Teschner
// et al., "Optimized Spatial Hashing for Collision Detection of Deformable Objects", 2003.
#include "engine/broad_phase/broad_phase.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr std::int64_t cells_max = 16;  // of one proxy; a proxy in more cells is compared with every proxy
constexpr Real coordinate_limit = Real(1 << 30);

/// Side of a cell, m: twice the median of the boxes' larger sides, or more if many boxes are much larger. Sides are
/// counted in bins of an eighth of a power of two: the exponent of the float and three bits of its fraction.
Real cell_size(const std::vector<Box>& boxes, std::vector<std::uint32_t>& counts) {
  constexpr int fraction_bits_dropped = 20;
  counts.assign(1u << 11, 0);
  for (const Box& box : boxes) {
    const Vec2 extent = box.upper - box.lower;
    const Real side = smaller(larger(extent.x, extent.y), Real(1e38));
    ++counts[bits_of(static_cast<float>(side)) >> fraction_bits_dropped & 0x7ffu];
  }
  const auto side_above = [&](std::size_t share_of_16) {
    const std::size_t rank = boxes.size() * share_of_16 / 16;
    std::uint32_t bin = 0;
    for (std::size_t seen = counts[0]; seen <= rank && bin < 0x7efu; seen += counts[bin]) ++bin;
    return static_cast<Real>(float_of_bits((bin + 1) << fraction_bits_dropped));
  };
  const Real size = larger(2 * side_above(8), side_above(15) / 2);
  return smaller(larger(size, Real(1e-30)), Real(1e30));
}

CellRange cells_of(const Box& box, Real inv_size) {
  return {
      clamped_floor(box.lower.x * inv_size, coordinate_limit), clamped_floor(box.lower.y * inv_size, coordinate_limit),
      clamped_floor(box.upper.x * inv_size, coordinate_limit), clamped_floor(box.upper.y * inv_size, coordinate_limit)};
}

bool is_large(const CellRange& range) {
  const std::int64_t columns = std::int64_t{range.last_x} - range.first_x + 1;
  const std::int64_t rows = std::int64_t{range.last_y} - range.first_y + 1;
  return columns > cells_max || rows > cells_max || columns * rows > cells_max;
}

/// Cells of a row lie side by side in the table; rows are spread.
std::uint32_t bucket_of(std::int32_t x, std::int32_t y, std::uint32_t mask) {
  return (static_cast<std::uint32_t>(x) + static_cast<std::uint32_t>(y) * 0x9e3779b1u) & mask;
}

template <typename Use>
void for_each_cell(const CellRange& range, Use use) {
  for (std::int32_t y = range.first_y; y <= range.last_y; ++y)
    for (std::int32_t x = range.first_x; x <= range.last_x; ++x) use(x, y);
}

/// Counting sort of (cell, proxy) by bucket; within a bucket dynamic proxies come first. Returns the mask of buckets.
std::uint32_t fill_cells(const TickLists& tick, BroadPhaseWork& work) {
  const std::span<const Proxy> proxies = tick.proxies;
  std::vector<std::uint32_t>& starts = work.cell_starts;
  std::uint32_t bucket_count = 16;
  while (bucket_count < 2 * proxies.size()) bucket_count *= 2;
  const std::uint32_t mask = bucket_count - 1;
  starts.assign(bucket_count + 1, 0);
  for (std::size_t i = 0, next_large = 0; i < proxies.size(); ++i) {
    if (next_large < work.large.size() && work.large[next_large] == i)
      ++next_large;
    else
      for_each_cell(work.cell_ranges[i], [&](std::int32_t x, std::int32_t y) { ++starts[bucket_of(x, y, mask)]; });
  }
  std::uint32_t sum = 0;
  for (std::uint32_t& start : starts) {
    const std::uint32_t count = start;
    start = sum;
    sum += count;
  }
  work.cell_entries.resize(sum);
  for (const bool is_static : {false, true})
    for (std::uint32_t i = 0, next_large = 0; i < proxies.size(); ++i) {
      if (next_large < work.large.size() && work.large[next_large] == i)
        ++next_large;
      else if (proxies[i].is_static == is_static)
        for_each_cell(work.cell_ranges[i], [&](std::int32_t x, std::int32_t y) {
          work.cell_entries[starts[bucket_of(x, y, mask)]++] = {x, y, i};
        });
    }
  return mask;
}

void add_pair(BroadPhaseWork& work, std::uint32_t a, std::uint32_t b) {
  work.unsorted_pairs.push_back(a < b ? Pair{a, b} : Pair{b, a});
}

/// Lists the pairs of a bucket. Two proxies that share several cells are a pair in the lowest shared cell alone. False:
/// too many pairs, as in the functions below.
bool find_pairs_in_bucket(TickLists& tick, BroadPhaseWork& work, std::uint32_t begin, std::uint32_t end) {
  const std::span<const Proxy> proxies = tick.proxies;
  for (std::uint32_t i = begin; i < end; ++i) {
    const CellEntry entry = work.cell_entries[i];
    const Proxy& a = proxies[entry.proxy];
    if (a.is_static) return true;  // and so are all later entries
    const CellRange& cells = work.cell_ranges[entry.proxy];
    for (std::uint32_t j = i + 1; j < end; ++j) {
      const CellEntry other = work.cell_entries[j];
      if (other.x != entry.x || other.y != entry.y) continue;
      const Proxy& b = proxies[other.proxy];
      const Box& box_a = work.boxes[entry.proxy];
      const Box& box_b = work.boxes[other.proxy];
      if (!overlaps(box_a, box_b) || !are_pair(a, b, box_a, box_b)) continue;
      const CellRange& other_cells = work.cell_ranges[other.proxy];
      const bool is_lowest_x = entry.x == cells.first_x || entry.x == other_cells.first_x;
      const bool is_lowest_y = entry.y == cells.first_y || entry.y == other_cells.first_y;
      if (is_lowest_x && is_lowest_y) add_pair(work, entry.proxy, other.proxy);
    }
    if (are_too_many(tick, work.unsorted_pairs.size())) return false;
  }
  return true;
}

bool find_pairs_of_large(TickLists& tick, BroadPhaseWork& work) {
  const std::span<const Proxy> proxies = tick.proxies;
  for (std::size_t k = 0; k < work.large.size(); ++k) {
    const std::uint32_t a = work.large[k];
    std::size_t next_large = 0;
    for (std::uint32_t b = 0; b < proxies.size(); ++b) {
      if (next_large < work.large.size() && work.large[next_large] == b) {
        // Two large proxies meet once.
        if (next_large++ <= k) continue;
      }
      if (overlaps(work.boxes[a], work.boxes[b]) && are_pair(proxies[a], proxies[b], work.boxes[a], work.boxes[b]))
        add_pair(work, a, b);
    }
    if (are_too_many(tick, work.unsorted_pairs.size())) return false;
  }
  return true;
}

}  // namespace

void uniform_grid(const Model& model, State& state, TickLists& tick, BroadPhaseWork& work, Real dt) {
  make_proxies(model, state, tick, work, dt);
  const std::span<const Proxy> proxies = tick.proxies;
  const Real inv_size = Real(1) / cell_size(work.boxes, work.counts);
  work.cell_ranges.clear();
  work.large.clear();
  for (std::uint32_t i = 0; i < proxies.size(); ++i) {
    work.cell_ranges.push_back(cells_of(work.boxes[i], inv_size));
    if (is_large(work.cell_ranges.back())) work.large.push_back(i);
  }
  const std::uint32_t mask = fill_cells(tick, work);
  work.unsorted_pairs.clear();
  for (std::uint32_t bucket = 0, begin = 0; bucket <= mask; ++bucket) {
    const std::uint32_t end = work.cell_starts[bucket];  // fill_cells moved it to the end of the bucket
    if (!find_pairs_in_bucket(tick, work, begin, end)) return;
    begin = end;
  }
  if (!find_pairs_of_large(tick, work)) return;
  list_sorted(tick, work, proxies.size());
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
