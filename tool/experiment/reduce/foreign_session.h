// Reduces ticks and inputs of plug-in sessions. Inputs are bytes that only the plug-in understands.
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

/// At most `tick_count` ticks of a trace. Errors: those of TraceReader::open.
Result<ForeignSession> read_foreign_session(const std::string& path, std::optional<std::uint64_t> tick_count);

struct ForeignResult {
  ForeignSession smallest;
  Failure first;
  Failure last;
  std::size_t run_count = 0;
  bool ended_early = false;
};

/// Reduces a session of a plug-in. `recorder` records candidates to a file in `folder`, and `judge` looks for a
/// difference. Delta debugging removes inputs and then ticks. A candidate that the simulation refuses does not fail.
/// Errors: those of recording and of the judge on the whole session; usage (the session does not fail).
Result<ForeignResult> reduce_foreign(const ForeignSession& session, const SimulationInfo& recorder,
                                     const TraceJudge& judge, const std::string& folder, const ReduceOptions& options);

/// Records the session with the state and the stages of every tick. Replaces an existing file. Errors: those of the
/// simulation and of replay::record.
Status record_foreign(const ForeignSession& session, const SimulationInfo& recorder, const std::string& path);

/// The inputs in the form that `ticktrue record` reads for a plug-in: lines of {"tick":3,"bytes":"0aff","dt":0.016}.
std::string foreign_inputs_text(const ForeignSession& session);

}  // namespace ticktrue::reduce
