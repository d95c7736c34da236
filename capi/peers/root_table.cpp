// Stores and compares roots. Either side's root can come first.
// SPDX-License-Identifier: MIT
#include "capi/peers/root_table.h"

#include <algorithm>

namespace ticktrue::capi {

const RootTable::Entry* RootTable::find(const Ring& ring, std::uint64_t tick) {
  if (ring.empty()) return nullptr;
  const Entry& entry = ring[static_cast<std::size_t>(tick % kept_root_count)];
  return entry.tick_and_one == tick + 1 ? &entry : nullptr;
}

std::optional<std::uint64_t> RootTable::at(std::uint64_t tick) const {
  const Entry* entry = find(own_, tick);
  return entry == nullptr ? std::nullopt : std::optional(entry->root);
}

std::optional<std::uint64_t> RootTable::at(std::uint32_t player, std::uint64_t tick) const {
  const auto ring = rings_.find(player);
  const Entry* entry = ring == rings_.end() ? nullptr : find(ring->second, tick);
  return entry == nullptr ? std::nullopt : std::optional(entry->root);
}

void RootTable::judge(std::uint32_t player, std::uint64_t tick, std::uint64_t here, std::uint64_t there) {
  PeerCount& count = counts_[player];
  // After the first difference all ticks differ: only earlier ticks matter.
  if (count.differing && tick >= *count.differing) return;
  ++count.compared;
  if (here == there) {
    count.agreed = std::max(count.agreed.value_or(0), tick);
    return;
  }
  count.differing = tick;
  if (!differing_ || tick < *differing_) differing_ = tick;
}

void RootTable::add(std::uint64_t tick, std::uint64_t root) {
  if (own_.empty()) own_.resize(kept_root_count);
  if (tick != end_) {
    std::fill(own_.begin(), own_.end(), Entry());
    first_ = tick;
  }
  end_ = tick + 1;
  own_[static_cast<std::size_t>(tick % kept_root_count)] = {tick + 1, root};
  for (const auto& [player, ring] : rings_)
    if (const Entry* entry = find(ring, tick)) judge(player, tick, root, entry->root);
}

void RootTable::add_peer(std::uint32_t player, std::uint64_t tick, std::uint64_t root) {
  PeerCount& count = counts_[player];
  const bool is_near = tick < end_ ? end_ - tick <= kept_root_count : tick - end_ < kept_root_count;
  if (!is_near) return;
  Ring& ring = rings_[player];
  if (ring.empty()) ring.resize(kept_root_count);
  Entry& entry = ring[static_cast<std::size_t>(tick % kept_root_count)];
  if (entry.tick_and_one == tick + 1) {
    if (entry.root != root) ++count.changed;
    return;
  }
  if (entry.tick_and_one > tick + 1) return;  // a later tick occupies this entry
  entry = {tick + 1, root};
  if (const auto own = at(tick)) judge(player, tick, *own, root);
}

}  // namespace ticktrue::capi
