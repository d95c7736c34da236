// Runs over the units of a corpus: rounds, what the store knows, reports.
// SPDX-License-Identifier: MIT
#include "tool/corpus/run/corpus_run.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "base/hash.h"
#include "base/parallel/jobs.h"
#include "tool/corpus/run/corpus_run_impl.h"
#include "verifier/store/agreement.h"
#include "verifier/store/renamed_report.h"
#include "verifier/verify/parts.h"

namespace ticktrue::tool {
namespace {

constexpr double poll_s_max = 0.5;  // between two looks at units that other workers have
constexpr double polls_in_lease = 20;

}  // namespace

verifier::Report refused_report(const std::string& file, const std::string& reason, const std::string& hint) {
  return verifier::open_error_report(file, Error{ErrorCode::io, reason, hint});
}

verifier::Report conflict_report(const std::string& file, const verifier::FoundVerdict& found) {
  verifier::Report report = refused_report(file, found.what, "find out which is right; then remove " + found.file);
  report.verdict = verifier::Verdict::not_reproducible;
  return report;
}

Result<std::vector<CorpusUnit>> CorpusRun::verify() {
  // A process with plug-ins forks, and has no second thread.
  if (options_.claims && !has_plugins_) claims_.start_heartbeat();
  if (const Status status = options_.shard ? take_shard_units() : Status(); !status) return status.error();
  if (const Status status = for_each_unit([&](std::size_t i) { begin_unit(i); }); !status) return status.error();
  if (const Status status = for_each_unit([&](std::size_t i) { cut_unit(i); }); !status) return status.error();
  std::vector<Job> jobs = most_expensive_first();
  while (!jobs.empty() && !stops()) {
    const std::size_t decided_before = decided_count();
    const Status status = run_jobs(jobs.size(), thread_count(), [&](std::size_t job) { advance(jobs[job]); });
    if (!status) return status.error();
    jobs.erase(std::remove_if(jobs.begin(), jobs.end(), [&](const Job& job) { return is_over(job); }), jobs.end());
    if (jobs.empty() || stops()) break;
    if (decided_count() != decided_before) continue;
    const double poll_s = std::min(poll_s_max, options_.lease_s / polls_in_lease);
    std::this_thread::sleep_for(std::chrono::duration<double>(poll_s));
  }
  for (std::size_t i = 0; i < files_.size(); ++i)
    if (states_[i].is_mine && !states_[i].is_done)
      units_[i].report = refused_report(files_[i], files_[i] + ": not verified: the command was stopped before",
                                        "start it again: what is done stays done");
  save_index();
  return my_units();
}

Result<std::vector<CorpusUnit>> CorpusRun::look_up() {
  if (const Status status = for_each_unit([&](std::size_t i) { look_up_unit(i); }); !status) return status.error();
  return std::move(units_);
}

Result<std::vector<double>> CorpusRun::open_costs() {
  Status status = for_each_unit([&](std::size_t i) {
    if (identify(i) && ask_store(units_[i].key, i).kind != StoreWord::Kind::green) learn_cost(i);
  });
  if (!status) return status.error();
  estimate_costs();
  save_index();
  std::vector<double> costs;
  for (const State& state : states_) costs.push_back(state.has_cost ? state.cost_s : 0);
  return costs;
}

Status CorpusRun::for_each_unit(const std::function<void(std::size_t)>& job) {
  return run_jobs(files_.size(), thread_count(), [&](std::size_t i) {
    if (states_[i].is_mine && !states_[i].is_done && !stops()) job(i);
  });
}

void CorpusRun::save_index() {
  // A store that cannot keep its index is slower, no more.
  if (const Status saved = index_.save(); !saved && !units_.empty())
    units_.front().warnings.push_back(saved.error().message);
}

std::vector<CorpusUnit> CorpusRun::my_units() {
  std::vector<CorpusUnit> mine;
  for (std::size_t i = 0; i < units_.size(); ++i)
    if (states_[i].is_mine) mine.push_back(std::move(units_[i]));
  return mine;
}

std::size_t CorpusRun::decided_count() {
  const std::lock_guard<std::mutex> guard(lock_);
  return decided_count_;
}

void CorpusRun::done(std::size_t i, UnitSource source, verifier::Report report) {
  const std::lock_guard<std::mutex> guard(lock_);
  if (std::exchange(states_[i].is_done, true)) return;
  units_[i].source = source;
  units_[i].report = std::move(report);
  rename_file(units_[i].report, files_[i]);  // the store has the name under which its bytes were first verified
  ++done_count_;
  ++decided_count_;
  if (options_.progress) options_.progress(done_count_, my_count_.value_or(files_.size()));
}

bool CorpusRun::is_done(std::size_t i) {
  const std::lock_guard<std::mutex> guard(lock_);
  return states_[i].is_done;
}

bool CorpusRun::identify(std::size_t i) {
  State& state = states_[i];
  if (state.identity) return true;
  Result<TraceIdentity> identity = identify_trace(files_[i], index_, is_in_sample(i));
  if (!identity) {
    done(i, UnitSource::missing, verifier::open_error_report(files_[i], identity.error()));
    return false;
  }
  state.identity = *identity;
  units_[i].key = names_of(i).whole();
  return true;
}

bool CorpusRun::is_in_sample(std::size_t i) const {
  constexpr std::uint64_t steps = 1'000'000;
  const std::string& file = files_[i];
  const std::uint64_t place =
      hash64({reinterpret_cast<const std::uint8_t*>(file.data()), file.size()}, sample_seed_) % steps;
  return static_cast<double>(place) < options_.recheck * static_cast<double>(steps);
}

CorpusRun::StoreWord CorpusRun::ask_store(const std::string& key, std::size_t i) {
  Result<verifier::FoundVerdict> found = store_.find(key);
  const std::lock_guard<std::mutex> guard(lock_);
  if (!found) {
    units_[i].problems.push_back(found.error());
    return {};
  }
  switch (found->kind) {
    case verifier::FoundVerdict::Kind::none:
      return {};
    case verifier::FoundVerdict::Kind::damaged:
      units_[i].warnings.push_back(found->what);
      return {};
    case verifier::FoundVerdict::Kind::conflict:
      return {StoreWord::Kind::conflict, conflict_report(files_[i], *found)};
    case verifier::FoundVerdict::Kind::verdict:
      const bool is_green = found->report->verdict == verifier::Verdict::match;
      return {is_green ? StoreWord::Kind::green : StoreWord::Kind::red, std::move(*found->report)};
  }
  return {};
}

bool CorpusRun::is_done_by_store(std::size_t i) {
  StoreWord word = ask_store(key_of(i), i);
  State& state = states_[i];
  bool is_first = false;
  {
    const std::lock_guard<std::mutex> guard(lock_);
    is_first = !std::exchange(state.was_looked_up, true);
    if (word.kind == StoreWord::Kind::nothing) return false;
    if (is_first) {
      state.was_red = word.kind == StoreWord::Kind::red;
      state.is_recheck = word.kind == StoreWord::Kind::green && is_in_sample(i) && !is_shared_by_shards(state);
    }
    if (state.is_recheck || (word.kind == StoreWord::Kind::red && state.was_red)) return false;
  }
  // Without claims it is another file with the same bytes.
  done(i, is_first || !options_.claims ? UnitSource::cached : UnitSource::other_worker, std::move(word.report));
  return true;
}

bool CorpusRun::is_shared_by_shards(const State& state) {
  return std::any_of(state.parts.begin(), state.parts.end(), [](const Part& part) { return !part.is_mine; });
}

void CorpusRun::look_up_unit(std::size_t i) {
  if (!identify(i)) return;
  StoreWord word = ask_store(key_of(i), i);
  if (word.kind != StoreWord::Kind::nothing) {
    done(i, UnitSource::cached, std::move(word.report));
    return;
  }
  std::string missing = "verdict of this build";
  if (look_up_parts(i, missing)) return;
  const std::string& store = store_.folder().path();
  done(i, UnitSource::missing,
       refused_report(files_[i], files_[i] + ": found no " + missing + " in " + store + ", expected one",
                      "ticktrue corpus verify " + verifier::shell_word(files_[i]) + " --cache " +
                          verifier::shell_word(store) + (options_.program ? " --command with the same words" : "")));
}

bool CorpusRun::look_up_parts(std::size_t i, std::string& missing) {
  const Result<std::optional<Bytes>> agreed = find_agreement(store_.folder(), names_of(i).parts());
  const std::optional<std::size_t> count = agreed && *agreed ? read_part_count(**agreed) : std::nullopt;
  if (!count) return false;
  std::vector<verifier::Report> reports(*count);
  std::vector<const verifier::Report*> all;
  for (std::size_t p = 0; p < *count; ++p) {
    StoreWord word = ask_store(names_of(i).part({p, *count}), i);
    if (word.kind == StoreWord::Kind::conflict) {
      done(i, UnitSource::cached, std::move(word.report));
      return true;
    }
    if (word.kind != StoreWord::Kind::green) {
      missing = word.kind == StoreWord::Kind::red
                    ? "verdict of a run from tick 0 (" + part_words({p, *count}) + " is no match)"
                    : "verdict of " + part_words({p, *count}) + " by this build";
      return false;
    }
    reports[p] = std::move(word.report);
    all.push_back(&reports[p]);
  }
  std::optional<verifier::Report> whole = join_parts(all);
  if (whole) done(i, UnitSource::cached, std::move(*whole));
  return whole.has_value();
}

Result<std::vector<CorpusUnit>> verify_corpus(const std::vector<std::string>& files, const std::string& traces,
                                              const verifier::VerdictStore& store, const CorpusOptions& options) {
  Result<BuildSubject> build = build_subject(options.mode, options.program.get());
  if (!build) return build.error();
  if (!options.program) return CorpusRun(files, traces, store, options, std::move(*build)).verify();
  Result<std::unique_ptr<ProgramRuns>> program = ProgramRuns::make(*options.program, options.stops);
  if (!program) return program.error();
  return CorpusRun(files, traces, store, options, std::move(*build), program->get()).verify();
}

Result<std::vector<CorpusUnit>> look_up_corpus(const std::vector<std::string>& files, const std::string& traces,
                                               const verifier::VerdictStore& store, const CorpusOptions& options) {
  Result<BuildSubject> build = build_subject(options.mode, options.program.get());
  if (!build) return build.error();
  return CorpusRun(files, traces, store, options, std::move(*build)).look_up();
}

Result<std::vector<double>> open_costs(const std::vector<std::string>& files, const std::string& traces,
                                       const verifier::VerdictStore& store, const CorpusOptions& options) {
  Result<BuildSubject> build = build_subject(options.mode, options.program.get());
  if (!build) return build.error();
  return CorpusRun(files, traces, store, options, std::move(*build)).open_costs();
}

int corpus_exit_code(const std::vector<CorpusUnit>& units, bool allow_truncated) {
  std::vector<int> codes;
  for (const CorpusUnit& unit : units) {
    codes.push_back(unit.report.exit_code(allow_truncated));
    if (!unit.problems.empty()) codes.push_back(verifier::exit_usage);
  }
  return verifier::worst_exit_code(codes);
}

}  // namespace ticktrue::tool
