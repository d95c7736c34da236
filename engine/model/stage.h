// The interface of a stage of the pipeline.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "engine/math/real.h"
#include "engine/model/caches.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Model;
struct State;
struct TickLists;

/// One part of a tick. A stage owns its workspace, which no tick reads before writing it, and its caches.
class Stage {
 public:
  virtual ~Stage() = default;
  /// Advances the state by this part of a tick. `dt`: of the tick, s.
  virtual void run(const Model& model, State& state, TickLists& tick, Real dt) = 0;
  /// Appends the caches of the stage: all that outlives a tick.
  virtual void list_caches(std::vector<TickCache*>&) {}
  /// Fills everything except caches with bytes that make wrong results obvious (NaN, huge indices).
  virtual void poison() {}
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
