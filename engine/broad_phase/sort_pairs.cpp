// The order of pairs: two counting sorts, by `second` and then, stable, by `first`.
// SPDX-License-Identifier: MIT
// Source: Knuth, "The Art of Computer Programming", volume 3, 1998, section 5.2 (sorting by counting); Shi, Schaeffer,
// "Parallel Sorting by Regular Sampling", 1992 (ranges of keys for threads).
#include <algorithm>
#include <array>

#include "engine/broad_phase/broad_phase.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// Proxies first..end-1.
struct ProxyRange {
  std::uint32_t first;
  std::uint32_t end;
};

/// Sorts by a key that lies in `keys`, stable.
void sort_by(std::uint32_t Pair::*key, ProxyRange keys, std::span<const Pair> from, Pair* to,
             std::vector<std::uint32_t>& start) {
  start.assign(keys.end - keys.first + 1, 0);
  for (const Pair& pair : from) ++start[pair.*key - keys.first + 1];
  for (std::size_t i = 1; i < start.size(); ++i) start[i] += start[i - 1];
  for (const Pair& pair : from) to[start[pair.*key - keys.first]++] = pair;
}

/// Sorts pairs whose `first` lie in `firsts`.
void sort_range(ProxyRange firsts, std::uint32_t proxy_count, std::span<const Pair> from, Pair* to,
                PairSorter& sorter) {
  sorter.by_second.resize(from.size());
  sort_by(&Pair::second, {0, proxy_count}, from, sorter.by_second.data(), sorter.start);
  sort_by(&Pair::first, firsts, sorter.by_second, to, sorter.start);
}

/// Picks the pairs whose `first` lie in `firsts`, without branches, since the outcome is hard to predict.
void pick(ProxyRange firsts, std::span<const Pair> from, std::vector<Pair>& to) {
  to.resize(from.size() + 1);
  std::size_t count = 0;
  for (const Pair& pair : from) {
    to[count] = pair;
    count += static_cast<std::size_t>((firsts.first <= pair.first) & (pair.first < firsts.end));
  }
  to.resize(count);
}

constexpr std::size_t pair_sample_count = 512;
constexpr std::uint32_t bin_count = 256;

/// Finds ends of ranges of `first` with about equally many pairs each, from a sample.
void split(std::span<const Pair> pairs, std::uint32_t proxy_count, std::span<std::uint32_t> ends) {
  const std::uint32_t bin_size = proxy_count / bin_count + 1;
  std::array<std::uint32_t, bin_count> bins{};
  const std::size_t step = pairs.size() / pair_sample_count + 1;
  std::size_t sampled = 0;
  for (std::size_t i = 0; i < pairs.size(); i += step, ++sampled) ++bins[pairs[i].first / bin_size];
  std::size_t below = 0;
  std::uint32_t bin = 0;
  for (std::size_t part = 0; part < ends.size(); ++part) {
    while (bin < bin_count && below * ends.size() < sampled * (part + 1)) below += bins[bin++];
    ends[part] = part + 1 == ends.size() ? proxy_count : std::min(bin * bin_size, proxy_count);
  }
}

constexpr std::size_t part_count_max = 64;

}  // namespace

void sort_pairs(const Parallel& parallel, BroadPhaseWork& work, std::size_t proxy_count, std::vector<Pair>& out) {
  const std::span<const Pair> pairs = work.unsorted_pairs;
  const auto key_end = static_cast<std::uint32_t>(proxy_count);
  const std::size_t chunk_size = parallel.chunk_size(pairs.size(), 2048);
  const std::size_t width = parallel.runner == nullptr ? 1 : parallel.runner->width();
  const std::size_t part_count = std::min({Parallel::chunk_count(pairs.size(), chunk_size), width, part_count_max});
  if (work.pair_sorters.size() < std::max<std::size_t>(part_count, 1))
    work.pair_sorters.resize(std::max<std::size_t>(part_count, 1));
  out.resize(pairs.size());
  if (part_count <= 1) return sort_range({0, key_end}, key_end, pairs, out.data(), work.pair_sorters[0]);
  // Each part picks its pairs. The places of the pairs are known once all parts have picked.
  std::array<std::uint32_t, part_count_max> ends{};
  split(pairs, key_end, {ends.data(), part_count});
  const auto range_of = [&](std::size_t part) { return ProxyRange{part == 0 ? 0 : ends[part - 1], ends[part]}; };
  parallel.for_chunks(part_count, 1, [&](const Chunk& chunk) {
    pick(range_of(chunk.index), pairs, work.pair_sorters[chunk.index].pairs);
  });
  parallel.for_chunks(part_count, 1, [&](const Chunk& chunk) {
    std::size_t place = 0;
    for (std::size_t part = 0; part < chunk.index; ++part) place += work.pair_sorters[part].pairs.size();
    PairSorter& sorter = work.pair_sorters[chunk.index];
    sort_range(range_of(chunk.index), key_end, sorter.pairs, out.data() + place, sorter);
  });
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
