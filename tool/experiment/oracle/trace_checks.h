// Checks of a world through a trace: recorded, verified in some mode, and loaded by a fresh process.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "tool/experiment/oracle/runs.h"

namespace ticktrue::soak {

struct TraceFiles {
  std::string path;  // path of the trace, which is written and removed again
  std::string tool;  // the program that check `process` runs; empty: the check finds nothing
};

/// Records the world and verifies the trace. The variant determines detail, checkpoint interval, mode and threads.
/// Requires: check trace or process.
std::optional<Finding> run_trace_variant(const RunContext& context, const BaseRun& base, const Variant& variant,
                                         const TraceFiles& files);

}  // namespace ticktrue::soak
