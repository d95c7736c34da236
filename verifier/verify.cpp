// The verify run: what can be compared at all, which way to walk the trace, and the verdict.
// SPDX-License-Identifier: MIT
#include "verifier/verify.h"

#include <algorithm>
#include <utility>
#include <variant>
#include <vector>

#include "base/float_behaviour.h"
#include "verifier/locate_cells.h"
#include "verifier/rerun.h"
#include "verifier/schema_difference.h"
#include "verifier/segments.h"
#include "verifier/single_change.h"
#include "verifier/twice.h"
#include "verifier/walk.h"

namespace ticktrue::verifier {
namespace {

using replay::CheckpointRecord;
using replay::TraceCondition;

// Enough that threads end together and a finding is met early; few enough that loading costs nothing beside walking.
constexpr std::size_t stretches_per_thread = 32;

// For mode `threads`, beside one. More than there are cores, too: then they are in each other's way.
constexpr unsigned compared_thread_counts[] = {2, 4, 8};

std::string count_text(std::uint64_t count, const char* noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

/// What differs between two schemas, in words; empty if nothing does.
std::string schema_difference(const StateSchema& recorded, const StateSchema& here) {
  const auto difference = first_schema_difference(recorded, here);
  if (!difference) return "";
  return "schema: " + difference->place + ": recorded " + difference->a + ", here " + difference->b;
}

std::string stage_difference(std::span<const std::string> recorded, std::span<const std::string> here) {
  if (std::equal(recorded.begin(), recorded.end(), here.begin(), here.end())) return "";
  const auto list = [](std::span<const std::string> names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
  };
  return "stages: recorded " + list(recorded) + "; here " + list(here);
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
    report_.first_tick = options_.from;
    if (is_available()) {
      switch (options_.mode) {
        case VerifyMode::replay:
          run_replay();
          break;
        case VerifyMode::restore:
          run_restore();
          break;
        case VerifyMode::twice:
          take(walk_twice(context_, source_));
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

  bool is_available() {
    if (const Status floats = check_float_behaviour(); !floats) {
      not_comparable(floats.error().message, floats.error().hint);
      return false;
    }
    const SimulationInfo* info = options_.simulation;
    if (info == nullptr || info->name != setup_.simulation) {
      not_comparable("simulation " + setup_.simulation + " is not available in this build");
      return false;
    }
    if (options_.mode == VerifyMode::threads && !info->make_on_threads) {
      not_comparable("threads: " + setup_.simulation + " of this build has one thread: there is nothing to compare",
                     "--mode replay compares with the recording");
      return false;
    }
    if (info->physics_version != setup_.physics_version &&
        !tolerates("physics version: recorded with " + std::to_string(setup_.physics_version) + ", here " +
                   std::to_string(info->physics_version)))
      return false;
    const auto simulation = make_simulation(context_, findings_);
    if (!simulation) return false;
    for (const std::string& text : {schema_difference(setup_.schema, *simulation->state().schema),
                                    stage_difference(setup_.stages, simulation->stage_names())})
      if (!text.empty() && !tolerates(text)) return false;
    return true;
  }

  /// A build that is not the recorded one may be compared with itself, and with nothing else.
  bool tolerates(const std::string& difference) {
    if (options_.mode == VerifyMode::twice) {
      report_.warnings.push_back(difference);
      return true;
    }
    not_comparable(difference, "build the version that recorded it, or record again");
    return false;
  }

  /// The last checkpoint at or before `tick`; else the setup's state.
  Start find_start(std::uint64_t tick) {
    if (tick > 0 && can_load(context_, findings_) && source_.seek(tick)) {
      if (const auto* checkpoint = std::get_if<CheckpointRecord>(&source_.next());
          checkpoint != nullptr && checkpoint->tick > 0) {
        const std::uint64_t found = checkpoint->tick;
        // Ticks may have different dt: the time of the checkpoint is known only by adding them up.
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
    return Start{};
  }

  /// Adds what a walk found to the report.
  void take(WalkResult result) {
    report_.ticks_compared += result.ticks_compared;
    report_.checkpoints_compared += result.checkpoints_compared;
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

  void read_tail() {
    if (report_.end || options_.to) return;
    while (!std::holds_alternative<std::monostate>(source_.next())) {
    }
    report_.end = TraceEnd{source_.tail(), ""};
  }

  void run_replay() {
    const Start first = find_start(options_.from);
    if (findings_.decided) return;
    const bool in_parallel = options_.thread_count > 1 && options_.reopen && !options_.wrap;
    if (in_parallel && can_load(context_, findings_) && replay_in_stretches(first)) return;
    if (findings_.decided) return;
    Stretch whole;
    whole.start = first;
    whole.count_from = options_.from;
    whole.progress = options_.progress;
    if (!go_to_start(source_, whole.start)) source_.rewind();
    WalkResult result = walk(context_, source_, whole);
    const std::optional<Mismatch> mismatch = std::move(result.mismatch);
    const Start near{result.last_checkpoint, result.last_checkpoint_s, true, {}, 0};
    take(std::move(result));
    if (mismatch) {
      read_tail();
      judge(*mismatch, first, near);
    } else if (unconfirmed_ && !findings_.decided) {
      findings_.warnings.push_back("a run begun at the checkpoint of tick " + std::to_string(*unconfirmed_) +
                                   " does not match, the run from the start does: --mode restore tells where");
    }
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
      Stretch whole;
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

  /// The second run begins at the checkpoint next to the mismatch; only where it ends in another state than the first
  /// the whole is run again.
  void judge(const Mismatch& mismatch, const Start& first, const Start& near) {
    Rerun rerun;
    if (near.tick > first.tick) {
      Findings of_shortcut;
      rerun = run_again(context_, source_, near, mismatch, of_shortcut, {});
    }
    if (!rerun.same) rerun = run_again(context_, source_, first, mismatch, findings_, options_.progress);
    conclude_mismatch(mismatch, rerun);
  }

  void conclude_mismatch(const Mismatch& mismatch, const Rerun& rerun) {
    judge_mismatch(context_, mismatch, rerun, findings_);
    const bool is_open = findings_.verdict == Verdict::diverged && findings_.divergence->rows.empty();
    if (!options_.search_single_bit || !is_open || mismatch.expected.image) return;
    const auto recorded =
        find_single_bit(setup_.schema, mismatch.got, mismatch.expected.root_hash, options_.thread_count);
    if (!recorded || !*recorded) return;
    const auto simulation = make_simulation(context_, findings_);
    if (simulation == nullptr) return;
    const bool has_names = simulation->load(mismatch.got).has_value();
    Findings named;
    describe_lanes(context_, *simulation, **recorded, mismatch.got, *findings_.divergence, named);
    if (!has_names)
      for (LaneReport& row : findings_.divergence->rows) row.name.clear();
    findings_.divergence->stage_note = "after the last one, or in what no later stage of the tick reads";
    findings_.notes.push_back(
        "one bit: of all states that differ from the one here in a single bit, this one has the recorded hash");
    findings_.hint = "a single bit is what failing memory and stray writes change: test the recording machine";
  }

  /// False: nothing is decided, the trace has to be walked in order.
  bool replay_in_stretches(const Start& first) {
    const StretchPlan plan =
        plan_stretches(context_, source_, first, stretches_per_thread * std::size_t{options_.thread_count});
    if (plan.cuts.size() < 2) return false;
    auto results = walk_stretches(context_, source_, plan, {options_.thread_count});
    if (!results) {
      not_comparable(results.error().message, results.error().hint);
      return true;
    }
    std::size_t found = 0;
    while (found + 1 < results->size() && is_clean((*results)[found], false)) ++found;
    WalkResult& last = (*results)[found];
    const bool clean = is_clean(last, found + 1 == results->size());
    std::optional<Rerun> rerun;
    if (!clean && found > 0) {
      // What was found begins with a loaded state: it counts if a run that came over the seam finds the same.
      if (last.mismatch) {
        Findings of_shortcut;
        rerun = run_again(context_, source_, plan.marks[plan.cuts[found] - 1], *last.mismatch, of_shortcut, {});
      }
      if (!rerun || !rerun->same) {
        unconfirmed_ = plan.marks[plan.cuts[found]].tick;
        return false;
      }
    }
    const std::optional<Mismatch> mismatch = last.mismatch;
    const Start near{last.last_checkpoint, last.last_checkpoint_s, true, {}, 0};
    for (std::size_t i = 0; i <= found; ++i) take(std::move((*results)[i]));
    if (plan.tail && !report_.end) report_.end = TraceEnd{*plan.tail, ""};
    report_.stretches = found + 1;
    if (!mismatch) return true;
    if (rerun)
      conclude_mismatch(*mismatch, *rerun);
    else
      judge(*mismatch, first, near);
    return true;
  }

  void run_restore() {
    // The start of the whole is a checkpoint too: the one at tick 0 is loaded, not made.
    Start first = find_start(options_.from);
    if (findings_.decided) return;
    if (!first.loaded) {
      source_.rewind();
      const auto* checkpoint = std::get_if<CheckpointRecord>(&source_.next());
      if (checkpoint == nullptr) {
        findings_.reason = "no checkpoint could be read";
        return;
      }
      first = start_at(*checkpoint, 0);
    }
    const StretchPlan plan = plan_stretches(context_, source_, first, std::numeric_limits<std::size_t>::max());
    if (!restore_stretches(plan, {options_.thread_count, false, true, true}) || !options_.to_end) return;
    // Each tick counts once: the runs to the end are only compared.
    StretchPlan later = plan;
    later.cuts.erase(later.cuts.begin());
    if (!later.cuts.empty()) restore_stretches(later, {options_.thread_count, true, false, true});
  }

  /// False: something was found.
  bool restore_stretches(const StretchPlan& plan, const StretchOptions& stretch_options) {
    auto results = walk_stretches(context_, source_, plan, stretch_options);
    if (!results) {
      not_comparable(results.error().message, results.error().hint);
      return false;
    }
    for (std::size_t i = 0; i < results->size(); ++i) {
      WalkResult& result = (*results)[i];
      const bool clean = is_clean(result, i + 1 == results->size() || stretch_options.to_end);
      const std::optional<Mismatch> mismatch = std::move(result.mismatch);
      take(std::move(result));
      if (plan.tail && !report_.end) report_.end = TraceEnd{*plan.tail, ""};
      if (mismatch) {
        const Rerun rerun = run_again(context_, source_, plan.marks[plan.cuts[i]], *mismatch, findings_, {});
        judge_mismatch(context_, *mismatch, rerun, findings_);
      }
      if (!clean) return false;
    }
    return true;
  }

  void conclude() {
    read_tail();
    if (!report_.ticks_recorded && report_.end) report_.ticks_recorded = report_.end->tail.ticks_intact;
    if (!findings_.decided) judge_end();
    report_.verdict = findings_.verdict;
    report_.reason = findings_.reason;
    report_.hint = findings_.hint;
    report_.divergence = std::move(findings_.divergence);
    report_.non_finite = std::move(findings_.non_finite);
    for (std::string& note : findings_.notes) report_.notes.push_back(std::move(note));
    for (std::string& warning : findings_.warnings) report_.warnings.push_back(std::move(warning));
  }

  /// All that was compared is the same: how much was it?
  void judge_end() {
    const replay::TraceTail* tail = report_.end ? &report_.end->tail : nullptr;
    const bool any = report_.ticks_compared > 0;
    if (tail != nullptr && tail->condition == TraceCondition::damaged) {
      findings_.verdict = Verdict::damaged;
      findings_.reason = tail->message;
      if (any)
        findings_.hint = "ticks " + std::to_string(options_.from) + ".." + std::to_string(tick_ - 1) +
                         " are intact and match: verify them alone with --to " + std::to_string(tick_ - 1);
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
    if (any && !changed_)
      findings_.warnings.push_back("no state outside table world changed in " +
                                   count_text(report_.ticks_compared, "tick") +
                                   ": does the simulation show all of its state?");
  }

  TraceSource& source_;
  const replay::TraceSetup& setup_;
  const VerifyOptions& options_;
  const WalkContext context_;
  Report report_;
  Findings findings_;
  bool changed_ = false;
  std::uint64_t tick_ = 0;                    // ticks done
  std::optional<std::uint64_t> unconfirmed_;  // a stretch begun here found what a run over the seam did not
};

/// The commands that would tell more.
void suggest(const replay::TraceSetup& setup, const VerifyOptions& options, Report& report) {
  const std::string file = shell_word(report.file);
  const std::string verify_words = options.tool + " verify " + file;
  if (report.verdict == Verdict::not_reproducible && options.mode != VerifyMode::twice)
    report.again.push_back(verify_words + " --mode twice");
  if (report.verdict == Verdict::incomplete && report.end &&
      report.end->tail.condition == replay::TraceCondition::truncated)
    report.again.push_back("ticktrue recover " + file + " -o WHOLE.ttr");
  if (report.verdict != Verdict::diverged || !report.divergence) return;
  const std::uint64_t tick = report.divergence->tick;
  const std::uint64_t interval = setup.checkpoint_interval;
  const std::uint64_t from = interval == 0 ? 0 : tick / interval * interval;
  report.again.push_back(verify_words + " --mode " + report.mode + " --from " + std::to_string(from) + " --to " +
                         std::to_string(tick));
  if (report.divergence->rows.empty()) report.again.push_back(more_detail_command(report.file, tick, options.tool));
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
  report.recorded_build = reader.facts();
  suggest(reader.setup(), options, report);
  return report;
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
