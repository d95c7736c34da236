// Verifies one trace on several threads: the trace is split into segments at its checkpoints.
// SPDX-License-Identifier: MIT
//
// Each segment is walked independently. Its final state is compared with the checkpoint at which the next segment
// begins. If every segment agrees, the whole trace agrees: the state at each boundary is the recorded one.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "verifier/verify/walk.h"

namespace ticktrue::verifier {

/// The division of a trace into segments. A plan takes one read of the trace and no simulation.
struct SegmentPlan {
  std::vector<Start> starts;                // the first start, and each later checkpoint; without images
  std::vector<std::size_t> segment_begins;  // indices into `starts`; ascending, the first is 0
  std::optional<replay::TraceTail> tail;    // absent: not read to the end (options.to)
  std::optional<std::uint64_t> stop;        // checkpoint at which the last segment ends; absent: the end of the trace
  bool is_continuation = false;             // another run compares the checkpoint at which the first segment begins
};

/// Many segments let threads end together and find a mismatch early. Few segments keep the time for loading small. The
/// number of threads has no influence, so that the same checkpoints are always loaded.
inline constexpr std::size_t segment_count_max = 128;

/// Reads `source` from its start. Makes at most `count_max` segments, with about the same number of checkpoints each.
SegmentPlan plan_segments(const WalkContext& context, TraceSource& source, const Start& first, std::size_t count_max);

struct SegmentOptions {
  unsigned thread_count = 1;
  bool to_end = false;       // each segment runs from its start to the end of the trace
  bool counts = true;        // Segment::counts
  bool counts_load = false;  // Segment::counts_load
};

/// Walks the segments; result i belongs to segment i. After a finding in one segment, later segments are abandoned:
/// their results have WalkEnd::abandoned. One thread uses `source`; the others use context.options.reopen.
/// Errors: those of check_float_behaviour.
Result<std::vector<WalkResult>> walk_segments(const WalkContext& context, TraceSource& source, const SegmentPlan& plan,
                                              const SegmentOptions& segment_options);

/// Whether the walk reached the end of its segment without a finding.
bool is_clean(const WalkResult& result, bool is_last);

}  // namespace ticktrue::verifier
