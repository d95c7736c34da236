// The end of a comparison of several traces: who went wrong, likely causes, verdict and commands.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "verifier/compare/many/diff_many.h"
#include "verifier/compare/many/trace_groups.h"

namespace ticktrue::verifier {

/// Completes the report after all traces were read and compared. `comparable`: the compared traces.
void conclude_diff(std::span<const OpenedTrace> traces, const TraceGroup& comparable, const DiffOptions& options,
                   DiffManyReport& report);

}  // namespace ticktrue::verifier
