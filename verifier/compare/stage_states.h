// One tick of a trace in full detail: the states before it and after each of its stages, as this build computes them.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/state/simulation.h"
#include "verifier/verify/trace_source.h"

namespace ticktrue::verifier {

struct StageState {
  std::string stage;  // empty: the state before the tick
  std::uint64_t root_hash = 0;
  Bytes image;
};

struct StageStates {
  std::uint64_t tick = 0;
  std::uint64_t start_tick = 0;  // the checkpoint at which the run began; 0: the setup
  bool as_recorded = true;       // the state before the tick has the recorded hash
  std::string inputs;            // of the tick, as JSON Lines
  std::vector<StageState> states;
};

/// Runs from the last checkpoint at or before `tick` through this tick.
/// Errors: usage (no such tick), incompatible (this build refuses inputs or a checkpoint), the errors of make and of
/// Simulation::step.
Result<StageStates> stage_states(TraceSource& source, const SimulationInfo& info, std::uint64_t tick);

/// JSON Lines, schema ticktrue.stages/1: a head, and a line for each state with its image in hexadecimal.
std::string stage_states_lines(const StageStates& states);
/// Errors: corrupt.
Result<StageStates> parse_stage_states(std::string_view lines);

}  // namespace ticktrue::verifier
