// Listing of pairs in chunks up to a common limit.
// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstddef>

#include "engine/broad_phase/broad_phase_work.h"
#include "engine/model/tick_lists.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The limit of pairs. All chunks add to one count, a block at a time. If the sum is too large, every chunk stops, so
/// that the order of chunks has no effect.
struct PairListing {
  std::size_t count_max;
  std::atomic<std::size_t> count{0};  // in whole blocks
  static constexpr std::size_t block_size = 4096;

  bool goes_on(std::size_t listed_here) {
    if (listed_here % block_size != 0) return true;
    return count.fetch_add(block_size, std::memory_order_relaxed) + block_size <= count_max;
  }
};

/// Fills work.unsorted_pairs. list(chunk, listing, pairs) appends the pairs of a chunk of `count` elements and asks the
/// listing after each element whether to continue. False: there are more than `count_max` pairs, and not all are
/// listed.
template <typename List>
bool list_in_chunks(const TickLists& tick, BroadPhaseWork& work, std::size_t count, std::size_t chunk_size,
                    const List& list) {
  PairListing listing{tick.pair_count_max};
  work.unsorted_pairs.clear();
  const std::size_t chunk_count = Parallel::chunk_count(count, chunk_size);
  if (chunk_count <= 1) {
    list(Chunk{0, 0, count}, listing, work.unsorted_pairs);
    return work.unsorted_pairs.size() <= listing.count_max;
  }
  if (work.pair_parts.size() < chunk_count) work.pair_parts.resize(chunk_count);
  tick.parallel.for_chunks(count, chunk_size, [&](const Chunk& chunk) {
    work.pair_parts[chunk.index].clear();
    list(chunk, listing, work.pair_parts[chunk.index]);
  });
  std::size_t pair_count = 0;
  for (std::size_t i = 0; i < chunk_count; ++i) pair_count += work.pair_parts[i].size();
  if (pair_count > listing.count_max) return false;
  for (std::size_t i = 0; i < chunk_count; ++i)
    work.unsorted_pairs.insert(work.unsorted_pairs.end(), work.pair_parts[i].begin(), work.pair_parts[i].end());
  return true;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
