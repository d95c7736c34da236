// The verify run: what can be compared, how to walk the trace, and the verdict.
// SPDX-License-Identifier: MIT
#include "verifier/verify/verify.h"

#include <algorithm>
#include <utility>
#include <variant>
#include <vector>

#include "base/count_text.h"
#include "verifier/locate/locate_cells.h"
#include "verifier/peers/bundle.h"
#include "verifier/verify/comparable.h"
#include "verifier/verify/parts.h"
#include "verifier/verify/rerun.h"
#include "verifier/verify/segments.h"
#include "verifier/verify/single_change.h"
#include "verifier/verify/sync_test.h"
#include "verifier/verify/twice.h"
#include "verifier/verify/walk.h"

namespace ticktrue::verifier {
namespace {

using replay::CheckpointRecord;
using replay::TraceCondition;

// For mode `threads`, besides 1. It includes more threads than cores: those disturb each other.
constexpr unsigned compared_thread_counts[] = {2, 4, 8};

/// The finding of a run that began at a checkpoint. It is a divergence only if a run from the setup also has a finding.
struct UnconfirmedFinding {
  Start start;
  WalkResult found;
};

/// The tick of a finding: the tick that ended differently, or the number of ticks before the finding.
std::uint64_t tick_of(const WalkResult& result) {
  return result.mismatch ? result.mismatch->expected.tick : result.tick;
}

class Verifier {
 public:
  Verifier(TraceSource& source, const VerifyOptions& options)
      : source_(source), setup_(source.setup()), options_(options), context_{setup_, options_} {}

  Report run() {
    report_.title = setup_.title;
    report_.simulation = setup_.simulation;
    for (const VerifyModeInfo& info : verify_modes)
      if (info.mode == options_.mode) report_.mode = info.name;
    report_.ticks_recorded = source_.tick_count_hint();
    const std::uint64_t first_tick = source_.first_tick();
    if (report_.ticks_recorded) *report_.ticks_recorded -= std::min(first_tick, *report_.ticks_recorded);
    report_.first_tick = std::max(first_tick, options_.from);
    if (check_comparable(context_, findings_) && find_begin()) {
      switch (options_.mode) {
        case VerifyMode::replay:
          if (options_.part)
            run_part(*options_.part);
          else if (options_.sync_ticks > 0)
            run_sync_test();
          else
            run_replay();
          break;
        case VerifyMode::restore:
          run_restore();
          break;
        case VerifyMode::twice:
          take(walk_twice(context_, source_, begin_));
          break;
        case VerifyMode::threads:
          run_threads();
          break;
      }
    }
    conclude();
    return std::move(report_);
  }

 private:
  void not_comparable(const std::string& reason, const std::string& hint = "") {
    findings_.decide(Verdict::not_comparable, reason, hint);
  }

  /// Sets begin_. False: the trace begins late, and a run can begin at none of its checkpoints.
  bool find_begin() {
    const std::uint64_t first_tick = source_.first_tick();
    if (first_tick == 0) return true;
    if (!can_load(context_, findings_)) {
      if (!findings_.decided)
        not_comparable(
            "begins at tick " + std::to_string(first_tick) + " and holds no state that this program can load",
            "show lists what it holds; diff compares it with another trace");
      return false;
    }
    source_.rewind();
    const auto* checkpoint = std::get_if<CheckpointRecord>(&source_.next());
    if (checkpoint != nullptr && is_start(context_, *checkpoint)) {
      begin_ = start_at(*checkpoint, checkpoint->time_s.value_or(0));
      return true;
    }
    if (checkpoint != nullptr)
      not_comparable("begins at tick " + std::to_string(first_tick) + " with a checkpoint without a save");
    return false;
  }

  /// The last checkpoint at or before `tick`, or else the begin.
  Start find_start(std::uint64_t tick) {
    if (tick > begin_.tick && can_load(context_, findings_)) {
      if (const CheckpointRecord* checkpoint = seek_start(tick)) {
        if (checkpoint->time_s) return start_at(*checkpoint, *checkpoint->time_s);
        const std::uint64_t found = checkpoint->tick;
        // Ticks may have different dt: the time of a checkpoint is the sum of the dt before it.
        double time_s = 0;
        source_.rewind();
        for (;;) {
          const auto& item = source_.next();
          if (const auto* record = std::get_if<replay::TickRecord>(&item)) time_s += record->dt;
          const auto* again = std::get_if<CheckpointRecord>(&item);
          if (again != nullptr && again->tick == found) return start_at(*again, time_s);
          if (std::holds_alternative<std::monostate>(item)) break;
        }
      }
    }
    return begin_;
  }

  /// Reads the last checkpoint at or before `tick` at which a run can begin; null: the begin.
  const CheckpointRecord* seek_start(std::uint64_t tick) {
    while (source_.seek(tick)) {
      const auto* checkpoint = std::get_if<CheckpointRecord>(&source_.next());
      if (checkpoint == nullptr || checkpoint->tick <= begin_.tick || checkpoint->tick > tick) return nullptr;
      if (is_start(context_, *checkpoint)) return checkpoint;
      tick = checkpoint->tick - 1;
    }
    return nullptr;
  }

  /// Adds the result of a walk to the report.
  void take(WalkResult result) {
    report_.ticks_compared += result.ticks_compared;
    report_.checkpoints_compared += result.checkpoints_compared;
    report_.compared += result.compared;
    report_.time_s = result.last_tick_s;
    if (result.root_hash) report_.root_hash = *result.root_hash;
    changed_ = changed_ || result.changed;
    tick_ = result.tick;
    if (result.trace_end && !report_.end) report_.end = std::move(result.trace_end);
    take(std::move(result.findings));
  }
  void take(Findings found) {
    for (std::string& warning : found.warnings) findings_.warnings.push_back(std::move(warning));
    for (std::string& note : found.notes) findings_.notes.push_back(std::move(note));
    if (found.non_finite) findings_.non_finite = std::move(found.non_finite);
    if (!found.decided) return;
    findings_.decide(found.verdict, std::move(found.reason), std::move(found.hint));
    findings_.divergence = std::move(found.divergence);
  }

  /// Whether ticks were compared that only the checks of their records prove: that is never a match.
  bool compared_salvaged() const { return source_.salvaged_from() && tick_ > *source_.salvaged_from(); }

  void read_tail() {
    if (report_.end || (options_.to && !compared_salvaged())) return;
    while (!std::holds_alternative<std::monostate>(source_.next())) {
    }
    report_.end = TraceEnd{source_.tail(), ""};
  }

  void run_replay() {
    const Start first = find_start(options_.from);
    if (findings_.decided) return;
    std::optional<UnconfirmedFinding> unconfirmed;
    if (walks_segments() && replay_segments(first, unconfirmed)) return;
    if (findings_.decided) return;
    if (first.tick == begin_.tick) return run_from_setup(std::move(unconfirmed));
    note_saves();
    WalkResult result = walk_from(first);
    if (!is_clean(result, true)) return run_from_setup(UnconfirmedFinding{first, std::move(result)});
    if (unconfirmed) return run_from_setup(std::move(unconfirmed));
    take(std::move(result));
  }

  /// In order, from `start` to the end.
  WalkResult walk_from(const Start& start, std::uint64_t sync_ticks = 0) {
    Segment whole;
    whole.sync_ticks = sync_ticks;
    whole.start = start;
    whole.count_from = options_.from;
    whole.progress = options_.progress;
    if (!go_to_start(source_, whole.start)) source_.rewind();
    return walk(context_, source_, whole);
  }

  /// Confirms a finding by a run from the setup, or from the first checkpoint of a trace that begins late. The finding
  /// of a run from a later checkpoint is a divergence only if the run from the setup also has a finding.
  void run_from_setup(std::optional<UnconfirmedFinding> unconfirmed) {
    if (unconfirmed && !options_.confirm_from_start)
      return conclude_walk(std::move(unconfirmed->found), unconfirmed->start);
    WalkResult from_setup = walk_from(begin_);
    if (!unconfirmed) return conclude_walk(std::move(from_setup), begin_);
    report_.ticks_compared = report_.checkpoints_compared = 0;
    report_.compared = {};
    if (is_clean(from_setup, true)) {
      take(std::move(from_setup));
      return judge_unconfirmed(*unconfirmed);
    }
    const std::uint64_t tick = tick_of(from_setup);
    if (tick >= options_.from) return conclude_walk(std::move(from_setup), begin_);
    findings_.notes.push_back("the run from the start leaves the recording at tick " + std::to_string(tick) +
                              ", before the first tick compared");
    conclude_walk(std::move(unconfirmed->found), unconfirmed->start);
  }

  /// Requires: the run from the setup agrees with the recording.
  void judge_unconfirmed(const UnconfirmedFinding& unconfirmed) {
    const Start& start = unconfirmed.start;
    const WalkResult& found = unconfirmed.found;
    if (found.mismatch) {
      read_tail();
      judge_mismatch(*found.mismatch, run_again(context_, source_, start, *found.mismatch, findings_, {}), findings_);
    } else {
      take(found.findings);
    }
    if (findings_.verdict == Verdict::not_reproducible) return;
    report_.checkpoint = start.tick;
    const bool by_save = loads_saves(context_);
    const std::string what = findings_.reason.empty() ? "" : ": " + findings_.reason;
    findings_.decide(Verdict::state_incomplete,
                     std::string("the run from the start matches, the run from the ") +
                         (by_save ? "save" : "checkpoint") + " of tick " + std::to_string(start.tick) + " does not" +
                         what,
                     by_save ? "something that a later tick reads is not in the save, or load does not bring it back: "
                               "find what these values are computed from, and save and load all of it"
                             : "something that a later tick reads is in no column, or load does not restore it: find "
                               "what these values are computed from, and show and load all of it");
    if (findings_.divergence) return;
    Divergence divergence;
    divergence.tick = tick_of(found);
    divergence.time_s = found.time_s;
    divergence.stage_note =
        std::string("not known: the run from the ") + (by_save ? "save" : "checkpoint") + " could not do this tick";
    findings_.divergence = std::move(divergence);
  }

  void conclude_walk(WalkResult result, const Start& first) {
    const std::optional<Mismatch> mismatch = std::move(result.mismatch);
    const Start near{result.last_checkpoint, result.last_checkpoint_s, true, {}, {}, 0};
    take(std::move(result));
    if (!mismatch) return;
    read_tail();
    judge(*mismatch, first, near);
  }

  /// Replays, and each tick runs twice. What the walk finds in a first run is a divergence only if a run without second
  /// runs has a finding too: load may have left a state that goes on otherwise.
  void run_sync_test() {
    if (!options_.simulation->has_saves && !can_load(context_, findings_)) {
      if (!findings_.decided) refuse_loading(context_, findings_);
      return;
    }
    const Start first = find_start(options_.from);
    if (findings_.decided) return;
    WalkResult result = walk_from(first, options_.sync_ticks);
    if (result.sync_begin) {
      report_.checkpoint = *result.sync_begin;
      return take(std::move(result));
    }
    if (is_clean(result, true)) {
      findings_.notes.push_back("sync test: " + count_text(result.sync_tick_count, "tick") + " ran twice" +
                                (result.sync_tick_count > 0 ? " with the same state" : ""));
      if (result.sync_missing_saves > 0)
        sync_gap_ = "sync test: " + count_text(result.sync_missing_saves, "time") + " there was no save";
      else if (result.sync_tick_count == 0)
        sync_gap_ = "sync test: no tick ran twice";
      return take(std::move(result));
    }
    WalkResult plain = walk_from(begin_);
    if (!is_clean(plain, true)) return conclude_walk(std::move(plain), begin_);
    take(std::move(plain));
    judge_sync_mismatch(result);
  }

  /// Called if the run without second runs agrees with the recording.
  void judge_sync_mismatch(const WalkResult& found) {
    if (!found.sync_last_load)
      return findings_.not_reproducible("two runs here differ from tick " + std::to_string(tick_of(found)) + " on");
    report_.checkpoint = found.sync_last_load;
    findings_.decide(
        Verdict::state_incomplete,
        "tick " + std::to_string(tick_of(found)) +
            " is as recorded where no tick runs twice, and not behind the second run that began with tick " +
            std::to_string(*found.sync_last_load) + (found.findings.reason.empty() ? "" : ": " + found.findings.reason),
        sync_hint(options_.simulation->has_saves ? BroughtBackBy::save : BroughtBackBy::image));
    Divergence divergence;
    if (found.mismatch) divergence = found.mismatch->divergence;
    divergence.tick = tick_of(found);
    if (!found.mismatch) divergence.time_s = found.time_s;
    findings_.divergence = std::move(divergence);
  }

  /// Replays with one thread, then with each other number of them.
  void run_threads() {
    run_replay();
    if (findings_.decided) return;
    read_tail();
    for (const unsigned thread_count : compared_thread_counts) {
      SimulationInfo info = *options_.simulation;
      info.make = [&](ByteView setup) { return options_.simulation->make_on_threads(setup, thread_count); };
      VerifyOptions options = options_;
      options.simulation = &info;
      const WalkContext context{setup_, options};
      Segment whole;
      whole.start = find_start(options_.from);
      whole.progress = options_.progress;
      if (!go_to_start(source_, whole.start)) source_.rewind();
      WalkResult result = walk(context, source_, whole);
      const std::string with = "with " + std::to_string(thread_count) + " threads: ";
      if (result.mismatch) {
        findings_.not_reproducible(with + "tick " + std::to_string(result.mismatch->expected.tick) +
                                   " ends in another state than with one");
        findings_.divergence = std::move(result.mismatch->divergence);
      } else if (result.findings.decided) {
        findings_.decide(result.findings.verdict, with + result.findings.reason, result.findings.hint);
        findings_.divergence = std::move(result.findings.divergence);
      }
      if (findings_.decided) return;
    }
    findings_.notes.push_back("the same with 1, 2, 4 and 8 threads");
  }

  /// The second run begins at the last checkpoint before the mismatch. If it ends in another state than the first run,
  /// the whole trace is run again.
  void judge(const Mismatch& mismatch, const Start& first, const Start& near) {
    Rerun rerun;
    if (near.tick > first.tick) {
      Findings of_shortcut;
      rerun = run_again(context_, source_, near, mismatch, of_shortcut, {});
    }
    if (!rerun.same) rerun = run_again(context_, source_, first, mismatch, findings_, options_.progress);
    judge_mismatch(mismatch, rerun, findings_);
    if (options_.search_single_bit) explain_by_single_bit(context_, mismatch, findings_);
  }

  /// A checkpoint of columns is compared as a whole, so matching segments prove a matching run. A save is not compared:
  /// a run from a save can match, although the run up to the save would continue differently.
  bool walks_segments() {
    const bool wanted = (options_.thread_count > 1 && options_.reopen) || options_.in_segments;
    return wanted && !options_.wrap && !loads_saves(context_) && can_load(context_, findings_);
  }

  /// False: some ticks must be walked in order. A finding after a loaded checkpoint is not confirmed yet.
  bool replay_segments(const Start& first, std::optional<UnconfirmedFinding>& unconfirmed) {
    const SegmentPlan plan = plan_segments(context_, source_, first, segment_count_max);
    if (plan.segment_begins.size() < 2) return false;
    auto results = walk_segments(context_, source_, plan, {options_.thread_count});
    if (!results) {
      not_comparable(results.error().message, results.error().hint);
      return true;
    }
    std::size_t found = 0;
    while (found + 1 < results->size() && is_clean((*results)[found], false)) ++found;
    WalkResult& last = (*results)[found];
    const Start& start = plan.starts[plan.segment_begins[found]];
    if (!is_clean(last, found + 1 == results->size()) && start.tick != begin_.tick) {
      if (last.mismatch || last.findings.decided) unconfirmed = UnconfirmedFinding{start, std::move(last)};
      return false;
    }
    for (std::size_t i = 0; i < found; ++i) take(std::move((*results)[i]));
    if (plan.tail && !last.trace_end) report_.end = TraceEnd{*plan.tail, ""};
    report_.segments = found + 1;
    conclude_walk(std::move(last), first);
    return true;
  }

  void run_part(const TracePart& part) {
    const SegmentPlan plan = plan_of_part(plan_segments(context_, source_, begin_, segment_count_max), part);
    if (plan.segment_begins.empty())
      return findings_.decide(Verdict::incomplete, "the trace has no part " + std::to_string(part.index + 1) + " of " +
                                                       std::to_string(part.count));
    auto results = walk_segments(context_, source_, plan, {options_.thread_count});
    if (!results) return not_comparable(results.error().message, results.error().hint);
    report_.first_tick = plan.starts[plan.segment_begins[0]].tick;
    report_.segments = results->size();
    for (std::size_t i = 0; i < results->size(); ++i) {
      WalkResult& result = (*results)[i];
      const Start& start = plan.starts[plan.segment_begins[i]];
      if (!is_clean(result, i + 1 == results->size() && !plan.stop)) {
        conclude_walk(std::move(result), start);
        if (!findings_.decided) findings_.decide(Verdict::incomplete, "the part could not be walked to its end");
        return;
      }
      take(std::move(result));
    }
    if (plan.tail && !report_.end) report_.end = TraceEnd{*plan.tail, ""};
  }

  void run_restore() {
    if (!can_load(context_, findings_)) {
      if (!findings_.decided) refuse_loading(context_, findings_);
      return;
    }
    // The first segment also begins at a checkpoint: the state at tick 0 is loaded too.
    Start first = find_start(options_.from);
    if (findings_.decided) return;
    if (!first.loaded) {
      source_.rewind();
      const auto* checkpoint = std::get_if<CheckpointRecord>(&source_.next());
      if (checkpoint == nullptr) {
        findings_.reason = "no checkpoint could be read";
        return;
      }
      if (is_start(context_, *checkpoint)) first = start_at(*checkpoint, 0);
    }
    const SegmentPlan plan = plan_segments(context_, source_, first, std::numeric_limits<std::size_t>::max());
    if (!plan.starts.back().loaded)
      return not_comparable("no checkpoint has a save: there is nothing to load",
                            "save must give one at least where a checkpoint is due");
    note_saves();
    std::optional<UnconfirmedFinding> unconfirmed;
    bool clean = restore_segments(plan, {options_.thread_count, false, true, true}, unconfirmed);
    if (clean && options_.to_end) {
      // Each tick counts once: the runs to the end are compared and not counted.
      SegmentPlan later = plan;
      later.segment_begins.erase(later.segment_begins.begin());
      if (!later.segment_begins.empty())
        clean = restore_segments(later, {options_.thread_count, true, false, true}, unconfirmed);
    }
    if (unconfirmed) return run_from_setup(std::move(unconfirmed));
    if (clean && loads_saves(context_)) compare_in_order();
  }

  /// After runs that began at saves: compares the run from the begin, whose ticks are already counted.
  void compare_in_order() {
    WalkResult in_order = walk_from(begin_);
    if (is_clean(in_order, true)) return;
    report_.ticks_compared = report_.checkpoints_compared = 0;
    report_.compared = {};
    conclude_walk(std::move(in_order), begin_);
  }

  void note_saves() {
    if (loads_saves(context_))
      findings_.notes.push_back("runs from a checkpoint begin with its save, which " + setup_.simulation + " loads");
  }

  /// False: some segment was not walked completely, or has a finding.
  bool restore_segments(const SegmentPlan& plan, const SegmentOptions& segment_options,
                        std::optional<UnconfirmedFinding>& unconfirmed) {
    auto results = walk_segments(context_, source_, plan, segment_options);
    if (!results) {
      not_comparable(results.error().message, results.error().hint);
      return false;
    }
    for (std::size_t i = 0; i < results->size(); ++i) {
      WalkResult& result = (*results)[i];
      const bool clean = is_clean(result, i + 1 == results->size() || segment_options.to_end);
      if (!clean && (result.mismatch || result.findings.decided)) {
        unconfirmed = UnconfirmedFinding{plan.starts[plan.segment_begins[i]], std::move(result)};
        return false;
      }
      take(std::move(result));
      if (plan.tail && !report_.end) report_.end = TraceEnd{*plan.tail, ""};
      if (!clean) return false;
    }
    return true;
  }

  void conclude() {
    read_tail();
    if (report_.end) set_salvaged(*report_.end, source_.salvaged_from());
    if (!report_.ticks_recorded && report_.end)
      report_.ticks_recorded =
          report_.end->tail.ticks_intact - std::min(source_.first_tick(), report_.end->tail.ticks_intact);
    if (!findings_.decided) judge_end();
    if (findings_.verdict == Verdict::match && !sync_gap_.empty()) {
      findings_.verdict = Verdict::incomplete;
      findings_.reason = sync_gap_;
      findings_.hint = "save gives the state after every tick: each tick begins a second run";
    }
    report_.state_changed = changed_;
    report_.verdict = findings_.verdict;
    report_.reason = findings_.reason;
    report_.hint = findings_.hint;
    report_.divergence = std::move(findings_.divergence);
    report_.non_finite = std::move(findings_.non_finite);
    for (std::string& note : findings_.notes) report_.notes.push_back(std::move(note));
    for (std::string& warning : findings_.warnings) report_.warnings.push_back(std::move(warning));
  }

  /// Decides the verdict after all comparisons agreed. It depends on how much was compared.
  void judge_end() {
    const replay::TraceTail* tail = report_.end ? &report_.end->tail : nullptr;
    const bool any = report_.ticks_compared > 0;
    if (tail != nullptr && tail->condition == TraceCondition::damaged) {
      findings_.verdict = Verdict::damaged;
      findings_.reason = tail->message;
      const std::string ticks = any ? "ticks " + std::to_string(std::max(source_.first_tick(), options_.from)) + ".." +
                                          std::to_string(tick_ - 1)
                                    : "";
      if (compared_salvaged())
        findings_.hint = ticks + " match: `ticktrue recover` makes a complete trace of what is before the damage";
      else if (any)
        findings_.hint = ticks + " are intact and match: verify them alone with --to " + std::to_string(tick_ - 1);
      else if (tail->ticks_intact <= source_.first_tick())
        findings_.hint = "copy the file anew from where it was recorded: nothing can be recovered from this one";
    } else if (tail != nullptr && tail->condition == TraceCondition::truncated) {
      findings_.verdict = Verdict::incomplete;
      findings_.reason = tail->message;
      if (any)
        findings_.hint =
            "every tick up to the cut matches: --allow-truncated accepts that; `ticktrue recover` makes a "
            "complete trace of it";
    } else if (!any) {
      findings_.verdict = Verdict::incomplete;
      if (findings_.reason.empty())
        findings_.reason = findings_.non_finite ? "no tick was compared: the first one is not finite, as recorded"
                                                : "no tick was compared";
    } else {
      findings_.verdict = Verdict::match;
    }
    if (any && !changed_ && !options_.part)
      findings_.warnings.push_back(unchanged_state_warning(report_.ticks_compared));
  }

  TraceSource& source_;
  const replay::TraceSetup& setup_;
  const VerifyOptions& options_;
  const WalkContext context_;
  Start begin_;  // the setup; if the trace begins late, its first checkpoint
  Report report_;
  Findings findings_;
  bool changed_ = false;
  std::uint64_t tick_ = 0;  // ticks done
  std::string sync_gap_;    // why the sync test proves less than it should; empty: it does not
};

/// Adds commands for further examination.
void suggest(const replay::TraceSetup& setup, const VerifyOptions& options, Report& report) {
  const std::string file = shell_word(report.file);
  const std::string verify_command = options.tool + " verify " + file;
  if (report.verdict == Verdict::not_reproducible && options.mode != VerifyMode::twice)
    report.again.push_back(verify_command + " --mode twice");
  if (report.end && report.ticks_compared > 0 &&
      ((report.verdict == Verdict::incomplete && report.end->tail.condition == TraceCondition::truncated) ||
       report.verdict == Verdict::damaged))
    report.again.push_back("ticktrue recover " + file + " -o WHOLE.ttr");
  const bool is_incomplete = report.verdict == Verdict::state_incomplete;
  if ((report.verdict != Verdict::diverged && !is_incomplete) || !report.divergence) return;
  const std::uint64_t tick = report.divergence->tick;
  const std::uint64_t interval = setup.checkpoint_interval;
  const std::uint64_t from = report.checkpoint.value_or(interval == 0 ? 0 : tick / interval * interval);
  const std::string way = options.sync_ticks > 0 ? " --sync-test " + std::to_string(options.sync_ticks)
                                                 : " --mode " + (is_incomplete ? "restore" : report.mode);
  report.again.push_back(verify_command + way + " --from " + std::to_string(from) + " --to " + std::to_string(tick));
  if (!report.divergence->rows.empty()) return;
  const std::string number = std::to_string(tick);
  report.again.push_back(is_incomplete ? options.tool + " record " + file + " --ticks " + std::to_string(tick + 1) +
                                             " --detail full:" + number + ".." + number + " --checkpoint-interval " +
                                             std::to_string(interval) + " -o full.ttr; then " + options.tool +
                                             " verify full.ttr --mode restore"
                                       : more_detail_command(report.file, tick, options.tool));
}

}  // namespace

Report verify_source(TraceSource& source, const VerifyOptions& options) {
  return Verifier(source, options).run();
}

Report verify(replay::TraceReader& reader, const VerifyOptions& options) {
  ReaderSource source(reader);
  reader.rewind();
  Report report = verify_source(source, options);
  report.file = reader.name();
  if (std::string note = bundle_note(reader.setup(), report.file); !note.empty() && !options.part)
    report.notes.push_back(std::move(note));
  report.recorded_build = reader.facts();
  suggest(reader.setup(), options, report);
  return report;
}

std::string unchanged_state_warning(std::uint64_t tick_count) {
  return "no state outside table world changed in " + count_text(tick_count, "tick") +
         ": does the simulation show all of its state?";
}

Report open_error_report(const std::string& file, const Error& error) {
  Report report;
  report.file = file;
  report.verdict = verdict_of_open_error(error.code);
  report.reason = error.message;
  report.hint = error.hint;
  return report;
}

}  // namespace ticktrue::verifier
