// Stores the results of the first run of some ticks.
// SPDX-License-Identifier: MIT
#include "base/state/second_run.h"

#include <algorithm>
#include <utility>

namespace ticktrue {

void SecondRun::open(std::uint64_t tick, Bytes save, const StateView& state) {
  close();
  begin_.emplace();
  begin_->tick = tick;
  begin_->save = std::move(save);
  begin_->state = KeptState(state);
}

void SecondRun::close() {
  begin_.reset();
  ticks_.clear();
  size_ = 0;
  is_second_ = false;
}

void SecondRun::add(double dt, const Bytes& inputs, const StateView& state) {
  FirstRunTick& tick = ticks_.emplace_back();
  tick.dt = dt;
  tick.inputs = inputs;
  if (has_room()) {
    tick.state.emplace(state);
    size_ += tick.state->size();
  } else {
    tick.root_hash = root_hash(state);
  }
}

void SecondRun::drop_from(std::uint64_t tick) {
  for (; behind() > std::max(tick, first()); ticks_.pop_back())
    if (ticks_.back().state) size_ -= ticks_.back().state->size();
}

}  // namespace ticktrue
