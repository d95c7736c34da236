// Words for the condition of a trace, in text and in JSON, and the exit code they mean.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "replay/trace.h"

namespace ticktrue::cli {

/// "complete", "truncated" or "damaged".
std::string_view condition_name(replay::TraceCondition condition);
std::string_view end_reason_name(replay::EndReason reason);
int exit_code_of_condition(replay::TraceCondition condition);
/// "ticks 800..1599 (from the checkpoint inside on)"
std::string intact_range_text(const replay::IntactRange& range);

}  // namespace ticktrue::cli
