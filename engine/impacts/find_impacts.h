// The stage that selects the pairs whose impacts are located in time.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "engine/impacts/impacts.h"
#include "engine/model/poison.h"
#include "engine/model/stage.h"
#include "engine/model/tick_lists.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct ImpactFinderWork {
  std::vector<std::uint8_t> is_fast;           // [body] may pass through something in this tick
  std::vector<std::vector<ImpactPair>> parts;  // [chunk]
};

template <typename Visit>
void list_fields(ImpactFinderWork& of, const Visit& visit) {
  auto& [is_fast, parts] = of;
  visit(is_fast, in_place(parts));
}

class ImpactFinder final : public Stage {
 public:
  void run(const Model& model, State& state, TickLists& tick, Real dt) override;
  void poison() override { list_fields(work_, Poison{}); }

 private:
  ImpactFinderWork work_;
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
