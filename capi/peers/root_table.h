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

/// What was compared with one other player.
struct PeerCount {
  std::uint64_t compared = 0;              // ticks
  std::optional<std::uint64_t> agreed;     // the last of them that was the same
  std::optional<std::uint64_t> differing;  // the first that was not
  std::uint64_t changed = 0;               // roots that came again with another value; the first one counts
};

class RootTable {
 public:
  /// The next confirmed tick here. Another one than the next makes the table forget what was before.
  void add(std::uint64_t tick, std::uint64_t root);
  /// Of another player, in any order and any number of times. Ticks that are too far from those here are left out.
  void add_peer(std::uint32_t player, std::uint64_t tick, std::uint64_t root);

  std::optional<std::uint64_t> at(std::uint64_t tick) const;
  std::optional<std::uint64_t> at(std::uint32_t player, std::uint64_t tick) const;
  std::uint64_t first_kept() const { return end_ > kept_root_count + first_ ? end_ - kept_root_count : first_; }
  std::uint64_t end() const { return end_; }  // one behind the last tick

  /// The first tick at which another player has another root; nothing so far.
  std::optional<std::uint64_t> differing() const { return differing_; }
  const std::map<std::uint32_t, PeerCount>& peers() const { return counts_; }
  /// The player takes part, whether roots of it came or not.
  void know(std::uint32_t player) { counts_[player]; }

 private:
  struct Entry {
    std::uint64_t tick_and_one = 0;  // 0: none
    std::uint64_t root = 0;
  };
  using Ring = std::vector<Entry>;  // [tick % kept_root_count]
  static const Entry* find(const Ring& ring, std::uint64_t tick);
  void judge(std::uint32_t player, std::uint64_t tick, std::uint64_t here, std::uint64_t there);

  Ring own_;
  std::map<std::uint32_t, Ring> rings_;  // of others
  std::map<std::uint32_t, PeerCount> counts_;
  std::uint64_t first_ = 0;  // ticks here are first_..end_ - 1
  std::uint64_t end_ = 0;
  std::optional<std::uint64_t> differing_;
};

}  // namespace ticktrue::capi
