// Other programs as judges of traces: a build of ticktrue, or a program with a session of the C interface.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "tool/experiment/reduce/predicate.h"

namespace ticktrue::reduce {

/// What stands for the trace in the words of a program.
inline constexpr const char* trace_mark = "{}";

/// The words with the trace in them, behind the last one where no word has the mark.
std::vector<std::string> words_with_trace(const std::vector<std::string>& words, const std::string& trace);

/// Runs the program on the trace. It prints a report of schema ticktrue.verify/2, or writes one to the file that
/// TICKTRUE_RESULT names (`folder`/result.json). A program that does neither says match by exit code 0 and failure
/// by 1. Errors: what keeps the trace from being judged (a program that does not start or end, a trace it cannot
/// compare).
TraceJudge program_judge(const std::vector<std::string>& words, const std::string& folder, double time_s);

/// The failure that a report of schema ticktrue.verify/2 tells; nothing for a match. Errors: unsupported (no such
/// report); incompatible (a verdict that judges nothing).
Result<std::optional<Failure>> failure_of_report(const std::string& json);

}  // namespace ticktrue::reduce
