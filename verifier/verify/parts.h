// A trace in parts: runs that share its segments, on any machines, and the report that they make up.
// SPDX-License-Identifier: MIT
//
// Verified: the joined report is that of one run, as long as every part is a match. A part that is none says nothing
// about the trace: the whole has to be verified.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "replay/trace_reader.h"
#include "verifier/report/report.h"
#include "verifier/verify/segments.h"
#include "verifier/verify/verify.h"

namespace ticktrue::verifier {

/// How many parts the trace can have, at most `count_max`. 1: it is damaged, cut or without checkpoints, or the
/// simulation cannot load states. Reads the whole trace.
std::size_t count_parts(replay::TraceReader& reader, const VerifyOptions& options, std::size_t count_max);

/// The segments of one part. Empty: the plan has no such part.
SegmentPlan plan_of_part(const SegmentPlan& whole, const TracePart& part);

/// The report of the whole trace, from the reports of all parts in order (VerifyOptions::part). Nothing: a part is
/// missing or no match, or a part does not begin where the part before it ends.
std::optional<Report> join_parts(const std::vector<const Report*>& parts);

/// Of these parts alone, which are matches; they may have gaps. Requires: at least one.
Report sum_of_parts(const std::vector<const Report*>& parts);

}  // namespace ticktrue::verifier
