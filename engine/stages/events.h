// The stage that reports begin and end of contacts, and of overlaps with sensors.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "engine/model/model.h"
#include "engine/model/poison.h"
#include "engine/model/stage.h"
#include "engine/model/state.h"
#include "engine/model/tick_lists.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct EventWork {
  std::vector<TouchRow> now_touching;  // the rows that replace State::touching, then State::sensors
  std::vector<TouchRow> touch_buffer;
};

template <typename Visit>
void list_fields(EventWork& of, const Visit& visit) {
  auto& [now_touching, touch_buffer] = of;
  visit(now_touching, touch_buffer);
}

class EventFinder final : public Stage {
 public:
  void run(const Model& model, State& state, TickLists& tick, Real dt) override;
  void poison() override { list_fields(work_, Poison{}); }

 private:
  EventWork work_;
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
