// Checks of a world by way of a trace: recorded, verified in some mode, and loaded by a fresh process.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "tool/experiment/oracle/runs.h"

namespace ticktrue::verifier::soak {

struct TraceFiles {
  std::string path;  // of the trace that is written and removed again
  std::string tool;  // the program that check `process` runs; empty: it finds nothing
};

/// Records the world and verifies the trace: detail, checkpoint interval, mode and threads follow from the variant.
/// For the checks trace and process.
std::optional<Finding> run_trace_variant(const RunContext& context, const BaseRun& base, const Variant& variant,
                                         const TraceFiles& files);

/// What verify is asked for by a variant of check trace, as options of the command line.
std::string trace_variant_text(const Variant& variant, std::uint64_t tick_count);

}  // namespace ticktrue::verifier::soak
