// Selecting rows of a range in chunks, in the order of the range.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstring>
#include <vector>

#include "base/parallel/parallel.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Moves the parts of a list that chunks have written together and returns the length. `begin_of(chunk)`: the begin of
/// a part. `counts`: [chunk].
template <typename Row, typename Begin>
std::size_t put_together(Row* rows, const std::vector<std::uint32_t>& counts, Begin begin_of) {
  std::size_t total = counts.empty() ? 0 : counts[0];
  for (std::size_t chunk = 1; chunk < counts.size(); ++chunk) {
    const std::size_t begin = begin_of(chunk);
    if (begin != total && counts[chunk] > 0) std::memmove(rows + total, rows + begin, counts[chunk] * sizeof(Row));
    total += counts[chunk];
  }
  return total;
}

/// Selects rows in chunks of at least `least` elements. select(begin, end, out) writes at most one row for each element
/// of begin..end-1 and returns the number of rows. Returns the number of rows in `out`, which has capacity for one row
/// per element. `counts` is overwritten.
template <typename Row, typename Select>
std::size_t select_in_chunks(const Parallel& parallel, std::vector<std::uint32_t>& counts, std::size_t count,
                             std::size_t least, Row* out, const Select& select) {
  const std::size_t size = parallel.chunk_size(count, least);
  counts.assign(Parallel::chunk_count(count, size), 0);
  parallel.for_chunks(count, size, [&](const Chunk& chunk) {
    counts[chunk.index] = static_cast<std::uint32_t>(select(chunk.begin, chunk.end, out + chunk.begin));
  });
  return put_together(out, counts, [size](std::size_t chunk) { return chunk * size; });
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
