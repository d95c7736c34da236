// The segments of a part, and sums of the reports of parts.
// SPDX-License-Identifier: MIT
#include "verifier/verify/parts.h"

#include <algorithm>

#include "verifier/verify/comparable.h"

namespace ticktrue::verifier {

std::size_t count_parts(replay::TraceReader& reader, const VerifyOptions& options, std::size_t count_max) {
  ReaderSource source(reader);
  reader.rewind();
  const WalkContext context{source.setup(), options};
  Findings findings;
  if (options.mode != VerifyMode::replay || options.simulation == nullptr || !options.in_segments) return 1;
  if (reader.first_tick() > 0) return 1;
  if (!check_comparable(context, findings) || loads_saves(context) || !can_load(context, findings)) return 1;
  const SegmentPlan plan = plan_segments(context, source, Start{}, segment_count_max);
  if (!plan.tail || plan.tail->condition != replay::TraceCondition::complete) return 1;
  return std::clamp<std::size_t>(count_max, 1, plan.segment_begins.size());
}

SegmentPlan plan_of_part(const SegmentPlan& whole, const TracePart& part) {
  SegmentPlan plan;
  const std::size_t segment_count = whole.segment_begins.size();
  if (part.count == 0 || part.index >= part.count || part.count > segment_count) return plan;
  const std::size_t first = part.index * segment_count / part.count;
  const std::size_t end = (part.index + 1) * segment_count / part.count;
  plan.starts = whole.starts;
  for (std::size_t i = first; i < end; ++i) plan.segment_begins.push_back(whole.segment_begins[i]);
  if (end < segment_count)
    plan.stop = whole.starts[whole.segment_begins[end]].tick;
  else
    plan.tail = whole.tail;
  plan.is_continuation = first > 0;
  return plan;
}

Report sum_of_parts(const std::vector<const Report*>& parts) {
  Report sum = *parts.back();
  sum.first_tick = parts.front()->first_tick;
  sum.warnings.clear();
  sum.notes.clear();
  sum.ticks_compared = sum.checkpoints_compared = sum.segments = 0;
  sum.compared = {};
  sum.wall_s = 0;
  sum.state_changed = false;
  for (const Report* part : parts) {
    sum.ticks_compared += part->ticks_compared;
    sum.checkpoints_compared += part->checkpoints_compared;
    sum.compared += part->compared;
    sum.segments += part->segments;
    sum.wall_s += part->wall_s;
    sum.state_changed = sum.state_changed || part->state_changed;
    sum.warnings.insert(sum.warnings.end(), part->warnings.begin(), part->warnings.end());
    sum.notes.insert(sum.notes.end(), part->notes.begin(), part->notes.end());
  }
  return sum;
}

std::optional<Report> join_parts(const std::vector<const Report*>& parts) {
  std::uint64_t tick = 0;
  for (const Report* part : parts) {
    if (part == nullptr || part->verdict != Verdict::match || part->first_tick != tick) return std::nullopt;
    tick += part->ticks_compared;
  }
  if (parts.empty() || !parts.back()->end || parts.back()->ticks_recorded != tick) return std::nullopt;
  Report whole = sum_of_parts(parts);
  if (!whole.state_changed) whole.warnings.push_back(unchanged_state_warning(whole.ticks_compared));
  return whole;
}

}  // namespace ticktrue::verifier
