// Sweep and prune: boxes sorted by their lower x, each compared with those that begin before it ends.
// SPDX-License-Identifier: MIT
// Source: Baraff, "Dynamic Simulation of Non-Penetrating Rigid Bodies", 1992, section 2.3 (one axis of it).
#include "engine/broad_phase/broad_phase.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// An unsigned integer that orders like the float.
std::uint64_t sort_key(Real value) {
  if constexpr (sizeof(Real) == 4) {
    const std::uint32_t bits = bits_of(static_cast<float>(value));
    return (bits & 0x80000000u) != 0 ? ~bits & 0xffffffffu : bits | 0x80000000u;
  } else {
    const std::uint64_t bits = bits_of(static_cast<double>(value));
    return (bits >> 63) != 0 ? ~bits : bits | 0x8000000000000000ull;
  }
}

struct Entry {
  std::uint64_t key;
  std::uint32_t proxy;
};

/// Least-significant-digit radix sort, 11 bits a pass; stable, so that equal keys stay in proxy order.
void sort_entries(std::vector<Entry>& entries, std::vector<Entry>& buffer) {
  constexpr int digit_bits = 11;
  constexpr std::size_t digit_count = 1u << digit_bits;
  constexpr int key_bits = sizeof(Real) == 4 ? 32 : 64;
  buffer.resize(entries.size());
  std::uint32_t start[digit_count];
  for (int shift = 0; shift < key_bits; shift += digit_bits) {
    for (std::uint32_t& s : start) s = 0;
    for (const Entry& e : entries) ++start[(e.key >> shift) & (digit_count - 1)];
    std::uint32_t sum = 0;
    for (std::uint32_t& s : start) {
      const std::uint32_t count = s;
      s = sum;
      sum += count;
    }
    for (const Entry& e : entries) buffer[start[(e.key >> shift) & (digit_count - 1)]++] = e;
    entries.swap(buffer);
  }
}

}  // namespace

void sweep_and_prune(const Model& model, State& state, Scratch& scratch, Real) {
  make_proxies(model, state, scratch);
  const std::vector<Proxy>& proxies = scratch.proxies;
  std::vector<Entry> entries;
  std::vector<Entry> buffer;
  entries.reserve(proxies.size());
  for (std::uint32_t i = 0; i < proxies.size(); ++i) entries.push_back({sort_key(proxies[i].box.lower.x), i});
  sort_entries(entries, buffer);

  // The sweep reads boxes in sorted order, packed: the inner loop touches nothing else.
  std::vector<Box> boxes;
  boxes.reserve(entries.size());
  for (const Entry& e : entries) boxes.push_back(proxies[e.proxy].box);
  scratch.unsorted_pairs.clear();
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const Box box = boxes[i];
    for (std::size_t j = i + 1; j < entries.size() && boxes[j].lower.x <= box.upper.x; ++j) {
      if (boxes[j].lower.y > box.upper.y || box.lower.y > boxes[j].upper.y) continue;
      const std::uint32_t a = entries[i].proxy;
      const std::uint32_t b = entries[j].proxy;
      if (may_touch(proxies[a], proxies[b])) scratch.unsorted_pairs.push_back(a < b ? Pair{a, b} : Pair{b, a});
    }
  }
  sort_pairs(scratch);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
