// Ticks that run twice: from a save on, and again after the save was loaded. Keeps the result of the first run.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "base/bytes.h"
#include "base/state/kept_state.h"
#include "base/state/state_view.h"

namespace ticktrue {

/// A tick of the first run.
struct FirstRunTick {
  double dt = 0;  // s
  Bytes inputs;
  std::optional<KeptState> state;  // after the tick; nothing: the copies of all ticks became too large
  std::uint64_t root_hash = 0;     // of this state, if it is not stored

  bool is_same(const StateView& now) const {
    return state ? state->is_same(now) : root_hash == ticktrue::root_hash(now);
  }
};

/// A save, and the state that the program or simulation must have after it was loaded.
struct SecondRunBegin {
  std::uint64_t tick = 0;
  Bytes save;
  KeptState state;
};

class SecondRun {
 public:
  /// The simulation is in `state`, with `tick` ticks done; `save` brings it back.
  void open(std::uint64_t tick, Bytes save, const StateView& state);
  void close();
  bool is_open() const { return begin_.has_value(); }
  bool is_second() const { return is_second_; }

  // Requires: is_open().
  std::uint64_t first() const { return begin_->tick; }                   // number of ticks before the save
  std::uint64_t behind() const { return begin_->tick + ticks_.size(); }  // number of ticks after the first run
  ByteView save() const { return begin_->save; }
  const KeptState& state() const { return begin_->state; }

  /// Adds the next finished tick of the first run.
  void add(double dt, const Bytes& inputs, const StateView& state);
  bool has_room() const { return size_ < size_max; }
  /// Removes the ticks from `tick` on: they will run again.
  void drop_from(std::uint64_t tick);

  void begin_second() { is_second_ = true; }
  const FirstRunTick& at(std::uint64_t tick) const { return ticks_[static_cast<std::size_t>(tick - begin_->tick)]; }

 private:
  static constexpr std::size_t size_max = std::size_t{64} << 20;  // bytes of copied states
  std::optional<SecondRunBegin> begin_;
  std::deque<FirstRunTick> ticks_;
  std::size_t size_ = 0;  // bytes of the states of the ticks
  bool is_second_ = false;
};

}  // namespace ticktrue
