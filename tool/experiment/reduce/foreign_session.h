// Sessions of plug-ins: their ticks and inputs are reduced, as bytes that only the plug-in understands.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/state/simulation.h"
#include "replay/format/trace.h"
#include "tool/experiment/reduce/reduce.h"

namespace ticktrue::reduce {

struct ForeignTick {
  double dt = 0;  // s
  Bytes inputs;
};

struct ForeignSession {
  replay::TraceSetup setup;
  std::vector<ForeignTick> ticks;

  std::size_t input_count() const;  // ticks with inputs
};

/// At most `tick_count` ticks of a trace. Errors: what TraceReader::open refuses.
Result<ForeignSession> read_foreign_session(const std::string& path, std::optional<std::uint64_t> tick_count);

struct ForeignResult {
  ForeignSession smallest;
  Failure first;
  Failure last;
  std::size_t run_count = 0;
  bool ended_early = false;
};

/// Sessions are recorded by `recorder` to a file in `folder`, and the judge finds a difference. Inputs and then ticks
/// are left out by delta debugging; what the simulation does not accept does not count. Errors: those of recording and
/// of the judge on the whole session; usage (it does not fail).
Result<ForeignResult> reduce_foreign(const ForeignSession& session, const SimulationInfo& recorder,
                                     const TraceJudge& judge, const std::string& folder, const ReduceOptions& options);

/// Records the session with the state and the stages of every tick, over an older file. Errors: those of the simulation
/// and of replay::record.
Status record_foreign(const ForeignSession& session, const SimulationInfo& recorder, const std::string& path);

/// As `ticktrue record` of a plug-in reads inputs: {"tick":3,"bytes":"0aff","dt":0.016} a line.
std::string foreign_inputs_text(const ForeignSession& session);

}  // namespace ticktrue::reduce
