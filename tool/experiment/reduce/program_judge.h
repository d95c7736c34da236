// Other programs as judges of traces: a build of ticktrue, or a program with a session of the C API.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "tool/experiment/reduce/predicate.h"

namespace ticktrue::reduce {

/// Placeholder of the trace in the words of a program.
inline constexpr const char* trace_mark = "{}";

/// Replaces the placeholder by the trace. Without a placeholder, the trace is added after the last word.
std::vector<std::string> words_with_trace(const std::vector<std::string>& words, const std::string& trace);

/// Runs the program on the trace. The program prints a report of schema ticktrue.verify/2, or writes the report to the
/// file that TICKTRUE_RESULT names (`folder`/result.json). Without a report, exit code 0 means match and 1 means
/// failure. Errors: the trace cannot be judged (the program does not start or end, or cannot compare the trace).
TraceJudge program_judge(const std::vector<std::string>& words, const std::string& folder, double time_s);

/// The failure in a report of schema ticktrue.verify/2; absent for a match. Errors: unsupported (no such report);
/// incompatible (a verdict without a comparison).
Result<std::optional<Failure>> failure_of_report(const std::string& json);

}  // namespace ticktrue::reduce
