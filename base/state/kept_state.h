// A copy of a state that stays valid whatever the simulation does.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "base/bytes.h"
#include "base/state/state_view.h"

namespace ticktrue {

class KeptState {
 public:
  KeptState() = default;
  explicit KeptState(const StateView& state);
  KeptState(KeptState&&) = default;
  KeptState& operator=(KeptState&&) = default;

  const StateView& view() const { return view_; }
  bool is_same(const StateView& state) const;
  std::size_t size() const { return size_; }  // bytes of all rows

 private:
  std::vector<Bytes> rows_;
  StateView view_;
  std::size_t size_ = 0;
};

}  // namespace ticktrue
