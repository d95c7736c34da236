// A trace in parts: runs on any machines that share its segments, and the joint report of these runs.
// SPDX-License-Identifier: MIT
//
// Verified: the joint report equals that of one run, if every part is a match. A part that is not a match proves
// nothing about the trace: the whole trace must be verified.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "replay/trace_reader.h"
#include "verifier/report/report.h"
#include "verifier/verify/segments.h"
#include "verifier/verify/verify.h"

namespace ticktrue::verifier {

/// The number of parts that the trace can have, at most `count_max`. 1: the trace is damaged, truncated or without
/// checkpoints, or the simulation cannot load states. Reads the whole trace.
std::size_t count_parts(replay::TraceReader& reader, const VerifyOptions& options, std::size_t count_max);

/// The segments of one part. Empty: the plan has no such part.
SegmentPlan plan_of_part(const SegmentPlan& whole, const TracePart& part);

/// The report of the whole trace, from the reports of all parts in order (VerifyOptions::part). Nothing: a part is
/// missing or not a match, or a part does not begin at the end of the part before it.
std::optional<Report> join_parts(const std::vector<const Report*>& parts);

/// The report of these parts alone. Requires: at least one part; each part is a match; there may be gaps.
Report sum_of_parts(const std::vector<const Report*>& parts);

}  // namespace ticktrue::verifier
