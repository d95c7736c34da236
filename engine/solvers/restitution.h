// The stage after the solver that gives contacts their bounce.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model/scratch.h"
#include "engine/model/stage.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

class Restitution final : public Stage {
 public:
  void run(const Model& model, State& state, TickLists& tick, Real dt) override;
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
