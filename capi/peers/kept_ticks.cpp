// Stores the last states within their budget.
// SPDX-License-Identifier: MIT
#include "capi/peers/kept_ticks.h"

#include <algorithm>
#include <utility>

namespace ticktrue::capi {

void KeptTicks::add(std::uint64_t tick, double dt, ByteView inputs, const StateView& state, double time_s) {
  if (!ticks_.empty() && ticks_.back().tick + 1 != tick) {
    ticks_.clear();
    size_ = 0;
  }
  ticks_.push_back({tick, inputs_of(dt, inputs), KeptState(state), Bytes(inputs.begin(), inputs.end()), time_s});
  size_ += size_of(ticks_.back());
  while (ticks_.size() > 1 && (size_ > size_max_ || ticks_.size() > count_max)) {
    size_ -= size_of(ticks_.front());
    ticks_.pop_front();
  }
  if (ticks_.front().tick > 0) initial_.reset();
}

const KeptTick* KeptTicks::find(std::uint64_t tick) const {
  if (ticks_.empty() || tick < ticks_.front().tick || tick > ticks_.back().tick) return nullptr;
  return &ticks_[static_cast<std::size_t>(tick - ticks_.front().tick)];
}

}  // namespace ticktrue::capi
