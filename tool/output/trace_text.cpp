// The condition of a trace as text.
// SPDX-License-Identifier: MIT
#include "tool/output/trace_text.h"

#include "verifier/report/exit_codes.h"

namespace ticktrue::cli {

std::string_view condition_name(replay::TraceCondition condition) {
  switch (condition) {
    case replay::TraceCondition::complete:
      return "complete";
    case replay::TraceCondition::truncated:
      return "truncated";
    case replay::TraceCondition::damaged:
      return "damaged";
  }
  return "unknown";
}

std::string_view end_reason_name(replay::EndReason reason) {
  for (const replay::EndReasonInfo& info : replay::end_reasons)
    if (info.reason == reason) return info.name;
  return "unknown";
}

int exit_code_of_condition(replay::TraceCondition condition) {
  switch (condition) {
    case replay::TraceCondition::complete:
      return verifier::exit_ok;
    case replay::TraceCondition::truncated:
      return verifier::exit_incomplete;
    case replay::TraceCondition::damaged:
      return verifier::exit_damaged;
  }
  return verifier::exit_damaged;
}

Status check_tick(const std::string& option, std::uint64_t tick, std::optional<std::uint64_t> tick_count) {
  if (!tick_count || tick < *tick_count) return {};
  return Error{ErrorCode::usage,
               option + ": no such tick: found " + std::to_string(tick) + ", expected " +
                   (*tick_count == 0 ? "none: the trace has no ticks" : "0.." + std::to_string(*tick_count - 1)),
               ""};
}

std::string intact_range_text(const replay::IntactRange& range) {
  return "ticks " + std::to_string(range.first_tick) + ".." + std::to_string(range.last_tick) +
         (range.has_checkpoint ? " (verifiable from a checkpoint inside)" : " (without a checkpoint)");
}

}  // namespace ticktrue::cli
