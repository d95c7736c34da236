// The pipeline: a list of stages, composed once from the scene and what it declares may come later.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "engine/engine.h"
#include "engine/model/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// One stage: advances part of a tick. `dt` is the tick's, in s.
using StageFunction = void (*)(const Model& model, State& state, Scratch& scratch, Real dt);

struct Stage {
  std::string name;
  StageFunction run;
  std::string why;
};

struct Pipeline {
  std::vector<Stage> stages;
  std::vector<StageDescription> description;  // those left out too
  StateTables tables;
};

/// `full`: every stage, whether the scene needs it or not. Changes no bit of the columns both pipelines have.
Pipeline compose(const Model& model, BroadPhaseKind broad_phase, bool full);

// The stages. Each is in the file of its name below stages/, broad_phase/, narrow_phase/ or solvers/.
void apply_inputs(const Model& model, State& state, Scratch& scratch, Real dt);
void cull(const Model& model, State& state, Scratch& scratch, Real dt);
void find_contacts(const Model& model, State& state, Scratch& scratch, Real dt);
void find_impacts(const Model& model, State& state, Scratch& scratch, Real dt);
void find_islands(const Model& model, State& state, Scratch& scratch, Real dt);
void measure_idle_time(const Model& model, State& state, Scratch& scratch, Real dt);
void find_events(const Model& model, State& state, Scratch& scratch, Real dt);
void apply_restitution(const Model& model, State& state, Scratch& scratch, Real dt);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
