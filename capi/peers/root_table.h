// The roots of confirmed ticks, here and of the other players, and the first tick at which they differ.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "replay/format/trace.h"

namespace ticktrue::capi {

inline constexpr std::uint64_t kept_root_count = 4'096;  // ticks
using replay::player_max;

/// The comparison with one other player.
struct PeerCount {
  std::uint64_t compared = 0;              // ticks
  std::optional<std::uint64_t> agreed;     // the last equal tick
  std::optional<std::uint64_t> differing;  // the first differing tick
  std::uint64_t changed = 0;               // roots that came again with another value; the first value counts
};

class RootTable {
 public:
  /// Adds the next confirmed tick of this player. If a tick is skipped, the table forgets the earlier ticks.
  void add(std::uint64_t tick, std::uint64_t root);
  /// Adds a root of another player, in any order and any number of times. Ticks too far from this player's ticks are
  /// ignored.
  void add_peer(std::uint32_t player, std::uint64_t tick, std::uint64_t root);

  std::optional<std::uint64_t> at(std::uint64_t tick) const;
  std::optional<std::uint64_t> at(std::uint32_t player, std::uint64_t tick) const;
  std::uint64_t first_kept() const { return end_ > kept_root_count + first_ ? end_ - kept_root_count : first_; }
  std::uint64_t end() const { return end_; }  // one after the last tick

  /// The first tick at which another player has another root; nothing: no difference so far.
  std::optional<std::uint64_t> differing() const { return differing_; }
  const std::map<std::uint32_t, PeerCount>& peers() const { return counts_; }
  /// Records that the player takes part, with or without roots.
  void know(std::uint32_t player) { counts_[player]; }

 private:
  struct Entry {
    std::uint64_t tick_and_one = 0;  // 0: empty
    std::uint64_t root = 0;
  };
  using Ring = std::vector<Entry>;  // [tick % kept_root_count]
  static const Entry* find(const Ring& ring, std::uint64_t tick);
  void judge(std::uint32_t player, std::uint64_t tick, std::uint64_t here, std::uint64_t there);

  Ring own_;
  std::map<std::uint32_t, Ring> rings_;  // of other players
  std::map<std::uint32_t, PeerCount> counts_;
  std::uint64_t first_ = 0;  // ticks here are first_..end_ - 1
  std::uint64_t end_ = 0;
  std::optional<std::uint64_t> differing_;
};

}  // namespace ticktrue::capi
