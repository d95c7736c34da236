// What verifying a trace costs: learned from earlier verdicts of the store, by size where nothing is known.
// SPDX-License-Identifier: MIT
//
// Costs decide order and shares, never a verdict.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "verifier/store/history.h"

namespace ticktrue::tool {

struct TraceCost {
  std::optional<double> learned_s;  // of the last verification, by any build
  std::uint64_t size = 0;           // bytes of the trace
};

/// Of the last verification in this mode.
std::optional<double> learned_cost(const verifier::History& history, const std::string& trace, std::string_view mode);

/// Seconds of each. Where none was learned, bytes cost what the bytes of the others cost.
std::vector<double> estimated_costs(const std::vector<TraceCost>& costs);

/// For each cost its share, from 1 to `share_count`: the largest first, each to the share that has the least so far.
std::vector<std::uint32_t> share_out(const std::vector<double>& costs, std::uint32_t share_count);

/// Into how many parts a trace is cut, so that none costs more than `part_s`.
std::size_t wanted_parts(double cost_s, double part_s);

}  // namespace ticktrue::tool
