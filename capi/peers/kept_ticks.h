// The states of the last confirmed ticks, within a budget of bytes. A desync is located in these states.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "base/bytes.h"
#include "base/state/kept_state.h"
#include "replay/format/peer.h"

namespace ticktrue::capi {

using replay::input_begin_max;
using replay::inputs_of;
using replay::TickInputs;

struct KeptTick {
  std::uint64_t tick = 0;
  TickInputs inputs;
  KeptState state;  // after the tick
  Bytes input_bytes;
  double time_s = 0;  // simulated time before the tick
};

class KeptTicks {
 public:
  static constexpr std::size_t size_default = std::size_t{16} << 20;
  static constexpr std::size_t count_max = 4'096;

  explicit KeptTicks(std::size_t size_max) : size_max_(size_max) {}
  /// Stores the state before tick 0 for as long as tick 0 is stored.
  void begin(const StateView& state) { initial_.emplace(state); }
  /// Adds a tick, and forgets the oldest ticks until the others fit. The newest is always stored. `time_s`: simulated
  /// time before the tick.
  void add(std::uint64_t tick, double dt, ByteView inputs, const StateView& state, double time_s = 0);
  /// Null: the tick is not stored.
  const KeptTick* find(std::uint64_t tick) const;
  std::size_t count() const { return ticks_.size(); }
  const std::deque<KeptTick>& ticks() const { return ticks_; }
  /// Null: the state is not stored.
  const KeptState* initial() const { return initial_ ? &*initial_ : nullptr; }

 private:
  static std::size_t size_of(const KeptTick& tick) {
    return tick.state.size() + sizeof(KeptTick) + tick.input_bytes.size();
  }

  std::size_t size_max_;  // bytes
  std::size_t size_ = 0;
  std::deque<KeptTick> ticks_;
  std::optional<KeptState> initial_;
};

}  // namespace ticktrue::capi
