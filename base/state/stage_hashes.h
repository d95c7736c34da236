// The root hash after each stage of one step, as an observer of the step.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/state/simulation.h"

namespace ticktrue {

class StageHashes : public StageObserver {
 public:
  void after_stage(std::size_t stage, const StateView& state) override {
    if (hashes_.size() <= stage) hashes_.resize(stage + 1);
    hashes_[stage] = root_hash(state);
  }
  /// By stage index; stages that did not report have 0.
  const std::vector<std::uint64_t>& hashes() const { return hashes_; }
  void clear() { hashes_.clear(); }

 private:
  std::vector<std::uint64_t> hashes_;
};

}  // namespace ticktrue
