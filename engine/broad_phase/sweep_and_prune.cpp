// Sweep and prune: boxes are sorted by their lower x, and each is compared with the boxes that begin before it ends.
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

}  // namespace

void sweep_and_prune(const Model& model, State& state, TickLists& tick, BroadPhaseWork& work, Real dt) {
  make_proxies(model, state, tick, work, dt);
  const std::span<const Proxy> proxies = tick.proxies;
  std::vector<SortEntry>& entries = work.sort_entries;
  entries.clear();
  for (std::uint32_t i = 0; i < proxies.size(); ++i) entries.push_back({sort_key(work.boxes[i].lower.x), i});
  sort_entries(entries, work.sort_buffer, sizeof(Real) == 4 ? 32 : 64);

  // The sweep reads packed boxes in sorted order, so the inner loop reads nothing else.
  std::vector<Box>& boxes = work.swept_boxes;
  boxes.clear();
  for (const SortEntry& e : entries) boxes.push_back(work.boxes[e.proxy]);
  work.unsorted_pairs.clear();
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const Box box = boxes[i];
    for (std::size_t j = i + 1; j < entries.size() && boxes[j].lower.x <= box.upper.x; ++j) {
      if (boxes[j].lower.y > box.upper.y || box.lower.y > boxes[j].upper.y) continue;
      const std::uint32_t a = entries[i].proxy;
      const std::uint32_t b = entries[j].proxy;
      if (are_pair(proxies[a], proxies[b], box, boxes[j]))
        work.unsorted_pairs.push_back(a < b ? Pair{a, b} : Pair{b, a});
    }
    if (are_too_many(tick, work.unsorted_pairs.size())) return;
  }
  list_sorted(tick, work, proxies.size());
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
