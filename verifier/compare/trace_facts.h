// Facts of setups and programs that are not the same for all traces, by their values.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "verifier/compare/diff_many.h"

namespace ticktrue::verifier {

/// The traces that can be compared with each other: the largest group of one simulation, physics version and schema.
/// Of groups of one size the choice depends on what they hold, not on their order.
TraceGroup comparable_traces(std::span<const OpenedTrace> traces);

/// What differs from the setup of the trace `reference`.
std::vector<TraceFact> setup_facts(std::span<const OpenedTrace> traces, std::size_t reference);
/// Facts of the programs that recorded the traces, of those that tell any; facts that change bits come first.
std::vector<TraceFact> build_facts(std::span<const OpenedTrace> traces);

/// Groups the open traces by a text of each.
TraceFact fact_of(std::string what, const TraceGroup& traces, const std::vector<std::string>& values);

}  // namespace ticktrue::verifier
