// Facts about setups and programs with different values, grouped by value.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "verifier/compare/many/diff_many.h"

namespace ticktrue::verifier {

/// The traces that can be compared: the largest group with one simulation, physics version and schema. The choice
/// between groups of equal size depends on their content, not on their order.
TraceGroup comparable_traces(std::span<const OpenedTrace> traces);

/// The facts that differ from the setup of the trace `reference`.
std::vector<TraceFact> setup_facts(std::span<const OpenedTrace> traces, std::size_t reference);
/// Facts about the recording programs, for traces that have such facts. Facts that change bits come first.
std::vector<TraceFact> build_facts(std::span<const OpenedTrace> traces);

/// Groups the open traces by one text per trace.
TraceFact fact_of(std::string what, const TraceGroup& traces, const std::vector<std::string>& values);

}  // namespace ticktrue::verifier
