// Planning and walking the stretches of one trace.
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

/// One thread's way through the trace: it only reads forward, except where it must go back.
class StretchReader {
 public:
  explicit StretchReader(TraceSource& source) : source_(source) {}
  TraceSource& source() { return source_; }

  /// Stands behind the checkpoint of `start` and takes its image. False: it is not there.
  bool go_to(Start& start) {
    if (!start.loaded) {
      source_.rewind();
      return true;
    }
    if (seam_ && seam_->tick == start.tick) {
      start.image = std::move(seam_->image);
      seam_.reset();
      return true;
    }
    if (ticks_read_ >= start.tick) source_.rewind();
    for (;;) {
      const auto& item = source_.next();
      if (std::holds_alternative<std::monostate>(item)) return false;
      const auto* checkpoint = std::get_if<CheckpointRecord>(&item);
      if (checkpoint == nullptr || checkpoint->tick != start.tick) continue;
      start.image.assign(checkpoint->image.begin(), checkpoint->image.end());
      return true;
    }
  }
  void walked(WalkResult& result) {
    seam_.reset();
    if (result.seam) seam_ = std::make_unique<Start>(std::move(*result.seam));
    result.seam.reset();
    ticks_read_ = result.tick + (seam_ ? 0 : 1);
  }

 private:
  TraceSource& source_;
  std::uint64_t ticks_read_ = std::numeric_limits<std::uint64_t>::max();  // at the start it may stand anywhere
  std::unique_ptr<Start> seam_;                                           // the checkpoint behind which it stands
};

class StretchPool {
 public:
  StretchPool(const WalkContext& context, const StretchPlan& plan, const StretchOptions& options)
      : context_(context), plan_(plan), options_(options), results_(plan.cuts.size()) {
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
    StretchReader reader(source);
    for (std::size_t i = next_.fetch_add(1); i < results_.size() && i <= first_finding_; i = next_.fetch_add(1)) {
      results_[i] = walk_one(reader, i);
      const bool is_last = i + 1 == results_.size() || options_.to_end;
      if (!is_clean(results_[i], is_last)) note_finding(i);
    }
  }

  WalkResult walk_one(StretchReader& reader, std::size_t i) {
    Stretch stretch;
    stretch.start = plan_.marks[plan_.cuts[i]];
    if (!reader.go_to(stretch.start)) return {};
    if (!options_.to_end && i + 1 < results_.size()) stretch.stop = plan_.marks[plan_.cuts[i + 1]].tick;
    stretch.count_from = context_.options.from;
    stretch.counts = options_.counts;
    stretch.counts_load = options_.counts_load || i == 0;
    stretch.is_abandoned = [this, i] { return first_finding_.load(std::memory_order_relaxed) < i; };
    if (context_.options.progress) stretch.progress = [this](std::uint64_t) { tell_progress(); };
    WalkResult result = walk(context_, reader.source(), stretch);
    reader.walked(result);
    return result;
  }

  void note_finding(std::size_t i) {
    std::size_t first = first_finding_;
    while (i < first && !first_finding_.compare_exchange_weak(first, i)) {
    }
  }

  void tell_progress() {
    const std::lock_guard<std::mutex> lock(progress_lock_);
    context_.options.progress(++ticks_done_);
  }

  const WalkContext& context_;
  const StretchPlan& plan_;
  const StretchOptions& options_;
  std::vector<WalkResult> results_;  // each written by the thread that took it
  std::atomic<std::size_t> next_{0};
  std::atomic<std::size_t> first_finding_{std::numeric_limits<std::size_t>::max()};
  std::mutex progress_lock_;
  std::uint64_t ticks_done_ = 0;
};

}  // namespace

StretchPlan plan_stretches(const WalkContext& context, TraceSource& source, const Start& first,
                           std::size_t stretch_count_max) {
  StretchPlan plan;
  plan.marks.push_back(first);
  plan.marks[0].image.clear();
  source.rewind();
  double time_s = 0;
  std::uint64_t ticks = 0;
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
    } else if (const auto* checkpoint = std::get_if<CheckpointRecord>(&item); checkpoint->tick > first.tick) {
      plan.marks.push_back({checkpoint->tick, time_s, true, {}, checkpoint->root_hash});
    }
  }
  // A checkpoint behind the last tick ends a stretch and begins none.
  if (plan.marks.size() > 1 && plan.marks.back().tick >= ticks) plan.marks.pop_back();
  const std::size_t count = std::min(plan.marks.size(), std::max<std::size_t>(1, stretch_count_max));
  for (std::size_t i = 0; i < count; ++i) plan.cuts.push_back(i * plan.marks.size() / count);
  return plan;
}

bool is_clean(const WalkResult& result, bool is_last) {
  if (result.findings.decided || result.mismatch) return false;
  return result.end == WalkEnd::reached_stop || (is_last && result.end == WalkEnd::end_of_trace);
}

Result<std::vector<WalkResult>> walk_stretches(const WalkContext& context, TraceSource& source, const StretchPlan& plan,
                                               const StretchOptions& stretch_options) {
  return StretchPool(context, plan, stretch_options).run(source);
}

}  // namespace ticktrue::verifier
