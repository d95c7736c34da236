// What the builds that a store knows said about one trace, and which of them changed its bits first.
// SPDX-License-Identifier: MIT
//
// Verified: rows are checked when they are read. Not verified: their order, which is that of the clocks of the machines
// that verified; and commits that nobody verified have no row.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "verifier/store/history.h"

namespace ticktrue::tool {

struct TraceLog {
  std::vector<verifier::HistoryRow> rows;  // the oldest first
  std::optional<std::size_t> last_match;   // before `changed`, where there is such a row; else of all
  std::optional<std::size_t> changed;      // the first that gave other bits
  std::vector<std::string> warnings;       // damaged rows
};

/// Of the rows of one mode.
TraceLog log_of(verifier::TraceHistory history, std::string_view mode);

/// Errors: io (the trace cannot be read).
Result<TraceLog> read_trace_log(const std::string& file, const verifier::StoreFolder& folder, std::string_view mode);

/// "2026-11-23 15:04:05", UTC.
std::string time_text(std::int64_t when_s);

}  // namespace ticktrue::tool
