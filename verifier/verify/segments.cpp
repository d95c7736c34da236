// Plans the segments of one trace and walks them.
// SPDX-License-Identifier: MIT
#include "verifier/verify/segments.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>
#include <variant>

#include "base/parallel/jobs.h"

namespace ticktrue::verifier {
namespace {

using replay::CheckpointRecord;

/// The read position of one thread. It reads forward, and rewinds only if the start is before the position.
class SegmentReader {
 public:
  explicit SegmentReader(TraceSource& source) : source_(source) {}
  TraceSource& source() { return source_; }

  /// Moves directly after the checkpoint of `start` and copies its image. False: the checkpoint is missing.
  bool go_to(Start& start) {
    if (!start.loaded) {
      source_.rewind();
      return true;
    }
    if (boundary_ && boundary_->tick == start.tick) {
      start.image = std::move(boundary_->image);
      start.save = std::move(boundary_->save);
      boundary_.reset();
      return true;
    }
    if (ticks_read_ >= start.tick) source_.rewind();
    for (;;) {
      const auto& item = source_.next();
      if (std::holds_alternative<std::monostate>(item)) return false;
      const auto* checkpoint = std::get_if<CheckpointRecord>(&item);
      if (checkpoint == nullptr || checkpoint->tick != start.tick) continue;
      start = start_at(*checkpoint, start.time_s);
      return true;
    }
  }
  void walked(WalkResult& result) {
    boundary_.reset();
    if (result.boundary) boundary_ = std::make_unique<Start>(std::move(*result.boundary));
    result.boundary.reset();
    ticks_read_ = result.tick + (boundary_ ? 0 : 1);
  }

 private:
  TraceSource& source_;
  std::uint64_t ticks_read_ = std::numeric_limits<std::uint64_t>::max();  // the initial position is unknown
  std::unique_ptr<Start> boundary_;  // the checkpoint just before the read position
};

class SegmentPool {
 public:
  SegmentPool(const WalkContext& context, const SegmentPlan& plan, const SegmentOptions& options)
      : context_(context), plan_(plan), options_(options), results_(plan.segment_begins.size()) {
    for (WalkResult& result : results_) result.end = WalkEnd::abandoned;
  }

  Result<std::vector<WalkResult>> run(TraceSource& source) {
    const std::size_t wanted = std::min<std::size_t>(std::max(1u, options_.thread_count), results_.size());
    std::vector<std::unique_ptr<TraceSource>> others;
    while (others.size() + 1 < wanted && context_.options.reopen) {
      auto other = context_.options.reopen();
      if (other == nullptr) break;  // fewer threads, the same results
      others.push_back(std::move(other));
    }
    const Status status = run_jobs(others.size() + 1, static_cast<unsigned>(others.size() + 1),
                                   [&](std::size_t i) { work(i == 0 ? source : *others[i - 1]); });
    if (!status) return status.error();
    return std::move(results_);
  }

 private:
  void work(TraceSource& source) {
    SegmentReader reader(source);
    for (std::size_t i = next_.fetch_add(1); i < results_.size() && i <= first_finding_; i = next_.fetch_add(1)) {
      results_[i] = walk_one(reader, i);
      const bool is_last = (i + 1 == results_.size() && !plan_.stop) || options_.to_end;
      if (!is_clean(results_[i], is_last)) set_first_finding(i);
    }
  }

  WalkResult walk_one(SegmentReader& reader, std::size_t i) {
    Segment segment;
    segment.start = plan_.starts[plan_.segment_begins[i]];
    if (!reader.go_to(segment.start)) return {};
    if (!options_.to_end && i + 1 < results_.size())
      segment.stop = plan_.starts[plan_.segment_begins[i + 1]].tick;
    else if (plan_.stop)
      segment.stop = *plan_.stop;
    segment.count_from = context_.options.from;
    segment.counts = options_.counts;
    segment.counts_load = options_.counts_load || (i == 0 && !plan_.is_continuation);
    segment.is_abandoned = [this, i] { return first_finding_.load(std::memory_order_relaxed) < i; };
    if (context_.options.progress) segment.progress = [this](std::uint64_t) { tell_progress(); };
    WalkResult result = walk(context_, reader.source(), segment);
    reader.walked(result);
    return result;
  }

  void set_first_finding(std::size_t i) {
    std::size_t first = first_finding_;
    while (i < first && !first_finding_.compare_exchange_weak(first, i)) {
    }
  }

  void tell_progress() {
    const std::lock_guard<std::mutex> lock(progress_lock_);
    context_.options.progress(++ticks_done_);
  }

  const WalkContext& context_;
  const SegmentPlan& plan_;
  const SegmentOptions& options_;
  std::vector<WalkResult> results_;  // each written by the thread that took it
  std::atomic<std::size_t> next_{0};
  std::atomic<std::size_t> first_finding_{std::numeric_limits<std::size_t>::max()};
  std::mutex progress_lock_;
  std::uint64_t ticks_done_ = 0;
};

}  // namespace

SegmentPlan plan_segments(const WalkContext& context, TraceSource& source, const Start& first, std::size_t count_max) {
  SegmentPlan plan;
  plan.starts.push_back(first);
  plan.starts[0].image.clear();
  plan.starts[0].save.clear();
  source.rewind();
  double time_s = 0;
  std::uint64_t ticks = source.first_tick();
  for (;;) {
    if (context.options.to && ticks > *context.options.to) break;
    const auto& item = source.next();
    if (std::holds_alternative<std::monostate>(item)) {
      plan.tail = source.tail();
      break;
    }
    if (const auto* record = std::get_if<replay::TickRecord>(&item)) {
      time_s += record->dt;
      ++ticks;
    } else {
      const auto& checkpoint = std::get<CheckpointRecord>(item);
      if (checkpoint.time_s) time_s = *checkpoint.time_s;
      if (checkpoint.tick > first.tick && is_start(context, checkpoint))
        plan.starts.push_back({checkpoint.tick, time_s, true, {}, {}, checkpoint.root_hash});
    }
  }
  // A checkpoint after the last tick ends a segment and begins no other.
  if (plan.starts.size() > 1 && plan.starts.back().tick >= ticks) plan.starts.pop_back();
  const std::size_t count = std::min(plan.starts.size(), std::max<std::size_t>(1, count_max));
  for (std::size_t i = 0; i < count; ++i) plan.segment_begins.push_back(i * plan.starts.size() / count);
  return plan;
}

bool is_clean(const WalkResult& result, bool is_last) {
  if (result.findings.decided || result.mismatch) return false;
  return result.end == WalkEnd::reached_stop || (is_last && result.end == WalkEnd::end_of_trace);
}

Result<std::vector<WalkResult>> walk_segments(const WalkContext& context, TraceSource& source, const SegmentPlan& plan,
                                              const SegmentOptions& segment_options) {
  return SegmentPool(context, plan, segment_options).run(source);
}

}  // namespace ticktrue::verifier
