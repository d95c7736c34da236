// The states of the last confirmed ticks, within a budget of bytes: what a desync is located in.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

#include "base/bytes.h"
#include "base/state/kept_state.h"

namespace ticktrue::capi {

inline constexpr std::size_t input_begin_max = 64;  // bytes of the inputs of a tick that reports print

/// The inputs that a tick took, as players compare them.
struct TickInputs {
  double dt = 0;  // s
  std::uint64_t size = 0;
  std::uint64_t hash = 0;
  Bytes begin;

  bool operator==(const TickInputs&) const = default;
};
TickInputs inputs_of(double dt, ByteView inputs);

struct KeptTick {
  std::uint64_t tick = 0;
  TickInputs inputs;
  KeptState state;  // after it
};

class KeptTicks {
 public:
  static constexpr std::size_t size_default = std::size_t{16} << 20;
  static constexpr std::size_t count_max = 4'096;

  explicit KeptTicks(std::size_t size_max) : size_max_(size_max) {}
  /// Forgets the oldest ticks that have no room any more. The newest is always kept.
  void add(std::uint64_t tick, double dt, ByteView inputs, const StateView& state);
  /// Null: not kept.
  const KeptTick* find(std::uint64_t tick) const;
  std::size_t count() const { return ticks_.size(); }

 private:
  static std::size_t size_of(const KeptTick& tick) { return tick.state.size() + sizeof(KeptTick) + input_begin_max; }

  std::size_t size_max_;  // bytes
  std::size_t size_ = 0;
  std::deque<KeptTick> ticks_;
};

}  // namespace ticktrue::capi
