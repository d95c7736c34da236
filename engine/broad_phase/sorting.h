// Sorting of broad phases: entries by an unsigned key, stable.
// SPDX-License-Identifier: MIT
// Source: Knuth, "The Art of Computer Programming", volume 3, 1998, sections 5.2.1 (insertion) and 5.2.5 (radix sort,
// least digit first).
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct SortEntry {
  std::uint64_t key;
  std::uint32_t proxy;
};

/// Up to this number of entries insertion is faster, since a radix sort must clear its counters.
inline constexpr std::size_t inserted_count_max = 32;

inline void insert_entries(std::vector<SortEntry>& entries) {
  for (std::size_t i = 1; i < entries.size(); ++i) {
    const SortEntry entry = entries[i];
    std::size_t at = i;
    for (; at > 0 && entries[at - 1].key > entry.key; --at) entries[at] = entries[at - 1];
    entries[at] = entry;
  }
}

/// Sorts by `key`, of which only the low `key_bits` bits may be set; equal keys stay in their order. `buffer` is
/// overwritten.
inline void sort_entries(std::vector<SortEntry>& entries, std::vector<SortEntry>& buffer, int key_bits) {
  if (entries.size() <= inserted_count_max) {
    insert_entries(entries);
    return;
  }
  constexpr int digit_bits = 11;
  constexpr std::size_t digit_count = 1u << digit_bits;
  buffer.resize(entries.size());
  std::uint32_t start[digit_count];
  for (int shift = 0; shift < key_bits; shift += digit_bits) {
    for (std::uint32_t& s : start) s = 0;
    for (const SortEntry& e : entries) ++start[(e.key >> shift) & (digit_count - 1)];
    std::uint32_t sum = 0;
    for (std::uint32_t& s : start) {
      const std::uint32_t count = s;
      s = sum;
      sum += count;
    }
    for (const SortEntry& e : entries) buffer[start[(e.key >> shift) & (digit_count - 1)]++] = e;
    entries.swap(buffer);
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
