// One step of a unit or a part: claim it, verify it, store the verdict.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <chrono>

#include "base/build_info.h"
#include "tool/corpus/run/corpus_run_impl.h"
#include "verifier/store/mapped_libraries.h"
#include "verifier/verify/parts.h"

namespace ticktrue::tool {

bool CorpusRun::is_over(const Job& job) {
  const std::lock_guard<std::mutex> guard(lock_);
  const State& state = states_[job.unit];
  return state.is_done || (job.part && (state.needs_whole || state.parts[*job.part].result != PartResult::open));
}

void CorpusRun::advance(const Job& job) {
  if (stops() || is_over(job)) return;
  const std::size_t i = job.unit;
  if (job.part) {
    advance_part(i, *job.part);
    return;
  }
  {
    const std::lock_guard<std::mutex> guard(lock_);
    if (!states_[i].parts.empty() && !states_[i].needs_whole) return;
  }
  if (is_done_by_store(i)) return;
  if (states_[i].is_recheck || !options_.claims) {
    run_unit(i, states_[i].is_recheck ? UnitSource::rechecked : UnitSource::verified);
    return;
  }
  if (!claim(key_of(i), i)) return;
  // Between the look at the store and the claim its last owner may have ended.
  if (!is_done_by_store(i)) run_unit(i, UnitSource::verified);
  release(key_of(i), i);
}

bool CorpusRun::claim(const std::string& key, std::size_t i) {
  const Result<verifier::Claims::Answer> answer = claims_.try_claim(key);
  if (!answer) done(i, UnitSource::missing, refused_report(files_[i], answer.error().message, answer.error().hint));
  return answer && *answer == verifier::Claims::Answer::won;
}

void CorpusRun::release(const std::string& key, std::size_t i) {
  bool is_stored = false;
  {
    const std::lock_guard<std::mutex> guard(lock_);
    is_stored = units_[i].problems.empty() && (!states_[i].is_done || units_[i].source != UnitSource::missing);
  }
  if (is_stored)
    claims_.finish(key);
  else
    claims_.give_up(key);
}

void CorpusRun::advance_part(std::size_t i, std::size_t p) {
  if (is_done_by_store(i) || is_part_done_by_store(i, p)) return;
  if (!options_.claims) {
    run_part_of_unit(i, p);
    return;
  }
  const std::string key = names_of(i).part({p, states_[i].parts.size()});
  if (!claim(key, i)) return;
  if (!is_part_done_by_store(i, p)) run_part_of_unit(i, p);
  release(key, i);
}

bool CorpusRun::is_part_done_by_store(std::size_t i, std::size_t p) {
  StoreWord word = ask_store(names_of(i).part({p, states_[i].parts.size()}), i);
  switch (word.kind) {
    case StoreWord::Kind::nothing:
      return false;
    case StoreWord::Kind::conflict:
      done(i, UnitSource::verified, std::move(word.report));
      return true;
    case StoreWord::Kind::green:
    case StoreWord::Kind::red:
      part_is_decided(i, p, std::move(word.report));
      return true;
  }
  return false;
}

void CorpusRun::run_part_of_unit(std::size_t i, std::size_t p) {
  const verifier::TracePart part{p, states_[i].parts.size()};
  std::optional<PluginVerification> found = verify_unchanged(i, part);
  if (!found) return;
  if (found->report.verdict == verifier::Verdict::error) {
    done(i, UnitSource::verified, std::move(found->report));
    return;
  }
  const Result<verifier::FoundVerdict> stored = store_.add(names_of(i).part(part), found->report);
  if (stored && stored->kind == verifier::FoundVerdict::Kind::conflict) {
    done(i, UnitSource::verified, conflict_report(files_[i], *stored));
    return;
  }
  if (!stored) {
    const std::lock_guard<std::mutex> guard(lock_);
    units_[i].problems.push_back(stored.error());
  }
  part_is_decided(i, p, std::move(found->report));
}

void CorpusRun::part_is_decided(std::size_t i, std::size_t p, verifier::Report report) {
  {
    const std::lock_guard<std::mutex> guard(lock_);
    State& state = states_[i];
    Part& part = state.parts[p];
    if (part.result != PartResult::open) return;
    part.result = report.verdict == verifier::Verdict::match ? PartResult::match : PartResult::other;
    part.report = std::move(report);
    ++decided_count_;
    if (part.result == PartResult::other && part.is_mine) {
      state.needs_whole = true;
      if (!state.red_part) state.red_part = part.report;
    }
    if (state.needs_whole || !part.is_mine) return;
    const bool is_last = std::all_of(state.parts.begin(), state.parts.end(), [](const Part& each) {
      return !each.is_mine || each.result == PartResult::match;
    });
    if (!is_last) return;
  }
  finish_parts(i);
}

void CorpusRun::finish_parts(std::size_t i) {
  State& state = states_[i];
  for (std::size_t p = 0; p < state.parts.size(); ++p)
    if (!state.parts[p].is_mine && !is_part_done_by_store(i, p)) break;
  if (is_done(i)) return;
  std::vector<const verifier::Report*> all, found;
  for (const Part& part : state.parts) {
    all.push_back(part.result == PartResult::match ? &part.report : nullptr);
    if (all.back() != nullptr && part.is_mine) found.push_back(all.back());
  }
  if (std::optional<verifier::Report> whole = join_parts(all)) {
    store_joined(i, std::move(*whole));
    return;
  }
  if (!is_shared_by_shards(state)) {
    const std::lock_guard<std::mutex> guard(lock_);
    state.needs_whole = true;
    return;
  }
  verifier::Report report = sum_of_parts(found);
  report.notes.push_back(std::to_string(found.size()) + " of " + std::to_string(all.size()) +
                         " parts of the trace: the report of the corpus says whether the others are there");
  done(i, UnitSource::partial, std::move(report));
}

PluginVerification CorpusRun::verify_file(const std::string& file, const std::optional<verifier::TracePart>& part) {
  if (program_ != nullptr) return program_->verify(file);
  TraceVerification how;
  how.mode = options_.mode;
  how.part = part;
  // With claims a process beats while another one works: a process with threads should not fork.
  if (!needs_plugin(file) && !(has_plugins_ && options_.claims)) {
    Result<replay::TraceReader> reader = replay::TraceReader::open(file);
    if (!reader) return {verifier::open_error_report(file, reader.error()), true};
    return {verify_trace(*reader, file, how), true};
  }
  verifier::SharedCount later_libraries;  // counted where the plug-in maps more while it runs
  const auto work = [&](verifier::SharedCount& compared) {
    how.compared = &compared;
    Result<replay::TraceReader> reader = replay::TraceReader::open(file);
    if (!reader) return verifier::open_error_report(file, reader.error());
    verifier::Report report = verify_trace(*reader, file, how);
    const auto libraries = verifier::mapped_libraries();
    if (!libraries || libraries_digest(*libraries) != build_.libraries) later_libraries.add_tick(0);
    return report;
  };
  PluginVerification found =
      tool::verify_by_plugin(file, mode_name(options_.mode), work, [&] { claims_.beat_when_due(); });
  if (later_libraries.ticks() > 0) {
    found.is_verdict = false;
    found.report.notes.push_back("not stored: the plug-in mapped more libraries while it ran");
  }
  return found;
}

std::optional<PluginVerification> CorpusRun::verify_unchanged(std::size_t i,
                                                              const std::optional<verifier::TracePart>& part) {
  const std::string& file = files_[i];
  const auto start = std::chrono::steady_clock::now();
  PluginVerification found = verify_file(file, part);
  found.report.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (const std::string warning = program_ == nullptr ? "" : program_->take_warning(); !warning.empty()) {
    const std::lock_guard<std::mutex> guard(lock_);
    units_[i].warnings.push_back(warning);
  }
  const std::optional<replay::FileFacts> after = replay::file_facts(file);
  if (after && verifier::is_unchanged(states_[i].identity->facts, *after)) return found;
  done(i, UnitSource::missing, verifier::open_error_report(file, changed_trace_error(file)));
  return std::nullopt;
}

void CorpusRun::run_unit(std::size_t i, UnitSource source) {
  std::optional<PluginVerification> found = verify_unchanged(i, {});
  if (!found) return;
  if (found->report.verdict == verifier::Verdict::error || !found->is_verdict) {
    done(i, source, std::move(found->report));
    return;
  }
  // A part that is no match is never forgotten: a whole that is one makes two verdicts that differ.
  if (const std::optional<verifier::Report> red = red_part_of(i);
      red && found->report.verdict == verifier::Verdict::match) {
    if (const Result<verifier::FoundVerdict> kept = store(i, *red); !kept) {
      const std::lock_guard<std::mutex> guard(lock_);
      units_[i].problems.push_back(kept.error());
      found->report.verdict = verifier::Verdict::not_reproducible;
      found->report.reason = "the run from tick 0 matches, a run from a checkpoint did not: " + red->reason;
    }
  }
  store_report(i, source, std::move(found->report));
}

std::optional<verifier::Report> CorpusRun::red_part_of(std::size_t i) {
  const std::lock_guard<std::mutex> guard(lock_);
  return states_[i].red_part;
}

void CorpusRun::store_joined(std::size_t i, verifier::Report report) {
  const Result<verifier::FoundVerdict> stored = store(i, report);
  const bool is_mine = !stored || stored->is_new || !options_.claims;
  finish_stored(i, is_mine ? UnitSource::verified : UnitSource::other_worker, std::move(report), stored);
}

void CorpusRun::store_report(std::size_t i, UnitSource source, verifier::Report report) {
  const Result<verifier::FoundVerdict> stored = store(i, report);
  // After a lease that expired, another worker may have done the same: the verdict counts for one of the two.
  const bool is_late = options_.claims && source == UnitSource::verified && !was_red(i) && stored &&
                       stored->kind == verifier::FoundVerdict::Kind::verdict && !stored->is_new;
  finish_stored(i, is_late ? UnitSource::other_worker : source, std::move(report), stored);
}

bool CorpusRun::was_red(std::size_t i) {
  const std::lock_guard<std::mutex> guard(lock_);
  return states_[i].was_red;
}

Result<verifier::FoundVerdict> CorpusRun::store(std::size_t i, const verifier::Report& report) {
  const Status kept = history_.add(names_of(i).history(), history_row(i, report));
  if (!kept && !store_.folder().exists(verifier::spread_name(key_of(i)))) return kept.error();
  return store_.add(key_of(i), report);
}

void CorpusRun::finish_stored(std::size_t i, UnitSource source, verifier::Report report,
                              const Result<verifier::FoundVerdict>& stored) {
  if (stored && stored->kind == verifier::FoundVerdict::Kind::conflict) {
    done(i, source, conflict_report(files_[i], *stored));
    return;
  }
  if (!stored) {
    const std::lock_guard<std::mutex> guard(lock_);
    units_[i].problems.push_back(stored.error());
  }
  done(i, source, std::move(report));
}

verifier::HistoryRow CorpusRun::history_row(std::size_t i, const verifier::Report& report) const {
  verifier::HistoryRow row;
  row.key = key_of(i);
  row.engine = build_.engine;
  row.libraries = build_.libraries;
  row.options = build_.options;
  row.mode = mode_name(options_.mode);
  row.commit = options_.program ? options_.program->choice().version : build_info().commit;
  row.build = build_line();
  row.when_s =
      std::chrono::duration_cast<std::chrono::seconds>(std::chrono::system_clock::now().time_since_epoch()).count();
  row.seconds = report.wall_s;
  row.verdict = verdict_info(report.verdict).name;
  row.ticks_recorded = report.ticks_recorded.value_or(0);
  row.ticks_compared = report.ticks_compared;
  row.root_hash = report.root_hash;
  if (report.divergence) row.diverged = report.divergence->tick;
  return row;
}

}  // namespace ticktrue::tool
