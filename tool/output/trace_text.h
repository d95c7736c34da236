// The condition of a trace as text and in JSON, and its exit code.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"
#include "replay/format/trace.h"

namespace ticktrue::cli {

/// "complete", "truncated" or "damaged".
std::string_view condition_name(replay::TraceCondition condition);
std::string_view end_reason_name(replay::EndReason reason);
int exit_code_of_condition(replay::TraceCondition condition);
/// Refuses a tick that a complete trace does not have. A damaged trace has no count and is not checked. Errors: usage.
Status check_tick(const std::string& option, std::uint64_t tick, std::optional<std::uint64_t> tick_count);
/// "ticks 800..1599 (from the checkpoint inside on)"
std::string intact_range_text(const replay::IntactRange& range);

}  // namespace ticktrue::cli
