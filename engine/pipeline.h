// The pipeline: a list of stages, composed once from the scene and the inputs that it declares.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/engine.h"
#include "engine/model/model.h"
#include "engine/model/stage.h"
#include "engine/model/state.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct PipelineStage {
  std::string name;
  std::unique_ptr<Stage> stage;
};

struct Pipeline {
  std::vector<PipelineStage> stages;
  std::vector<StageDescription> description;  // including stages that are left out
  StateTables tables;
};

/// `full`: every stage, needed or not. Changes no bit of the columns that both pipelines have.
Pipeline compose(const Model& model, BroadPhaseKind broad_phase, bool full);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
