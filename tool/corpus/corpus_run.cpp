// The units of a corpus: look up, cut, share out, claim, verify, store.
// SPDX-License-Identifier: MIT
#include "tool/corpus/corpus_run.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <mutex>
#include <optional>
#include <random>
#include <string_view>
#include <thread>
#include <utility>

#include "base/build_info.h"
#include "base/hash.h"
#include "base/parallel/jobs.h"
#include "engine/engine.h"
#include "tool/corpus/costs.h"
#include "tool/corpus/program_runs.h"
#include "tool/corpus/shard_plan.h"
#include "tool/corpus/trace_identity.h"
#include "tool/session/simulations.h"
#include "verifier/plugins/plugin.h"
#include "verifier/store/agreement.h"
#include "verifier/store/claims.h"
#include "verifier/store/history.h"
#include "verifier/store/mapped_libraries.h"
#include "verifier/store/renamed_report.h"
#include "verifier/store/stat_index.h"
#include "verifier/verify/parts.h"

namespace ticktrue::verifier {
namespace {

constexpr double poll_s_max = 0.5;  // between two looks at units that other workers have
constexpr double polls_in_lease = 20;

Report refused_report(const std::string& file, const std::string& reason, const std::string& hint) {
  return open_error_report(file, Error{ErrorCode::io, reason, hint});
}

Report conflict_report(const std::string& file, const FoundVerdict& found) {
  Report report = refused_report(file, found.what, "find out which is right; then remove " + found.file);
  report.verdict = Verdict::not_reproducible;
  return report;
}

Bytes count_bytes(std::size_t count) {
  ByteWriter out;
  out.u64(count);
  return out.take();
}

/// Nothing: no such count.
std::optional<std::size_t> read_count(ByteView bytes) {
  ByteReader in(bytes);
  const std::uint64_t count = in.u64();
  if (!in.ok() || !in.at_end() || count < 1 || count > segment_count_max) return std::nullopt;
  return static_cast<std::size_t>(count);
}

class CorpusRun {
 public:
  CorpusRun(const std::vector<std::string>& files, const std::string& traces, const VerdictStore& store,
            const CorpusOptions& options, BuildSubject build, ProgramRuns* program = nullptr)
      : files_(files),
        store_(store),
        options_(options),
        build_(std::move(build)),
        program_(program),
        index_(store.folder(), traces),
        claims_(store.folder(), options.lease_s),
        history_(store.folder()),
        units_(files.size()),
        states_(files.size()),
        has_plugins_(!options.program && !plugin_simulations().empty()),
        sample_seed_(std::random_device{}()) {}

  /// All units, in rounds: a unit that another worker has is looked at again in the next one.
  Result<std::vector<CorpusUnit>> verify() {
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

  Result<std::vector<CorpusUnit>> look_up() {
    if (const Status status = for_each_unit([&](std::size_t i) { look_up_unit(i); }); !status) return status.error();
    return std::move(units_);
  }

  Result<std::vector<double>> open_costs() {
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

 private:
  struct Part {
    enum class Word { open, match, other };
    bool is_mine = true;  // of this shard
    Word word = Word::open;
    Report report;  // unless open
  };
  struct State {
    bool is_mine = true;  // of this shard, as a whole or in parts
    bool is_done = false;
    std::optional<TraceIdentity> identity;
    bool has_cost = false;
    TraceCost cost;
    double cost_s = 0;  // as estimated
    bool was_looked_up = false;
    bool was_red = false;            // before this run: such a verdict is found again
    bool is_recheck = false;         // of a verdict that is a match
    std::vector<Part> parts;         // empty: the trace is not cut
    std::optional<Report> red_part;  // the first part that is no match
    bool needs_whole = false;        // a part is no match: a run from tick 0 decides
  };
  /// A trace, or one of its parts.
  struct Job {
    std::size_t unit = 0;
    std::optional<std::size_t> part;
    double cost_s = 0;
  };
  struct StoreWord {
    enum class Kind { nothing, green, red, conflict };
    Kind kind = Kind::nothing;
    Report report;
  };

  bool stops() const { return options_.stops && options_.stops(); }
  unsigned thread_count() const { return has_plugins_ ? 1 : options_.thread_count; }
  const std::string& key_of(std::size_t i) const { return units_[i].key; }
  UnitNames names_of(std::size_t i) const { return {*states_[i].identity, build_}; }

  Status for_each_unit(const std::function<void(std::size_t)>& job) {
    return run_jobs(files_.size(), thread_count(), [&](std::size_t i) {
      if (states_[i].is_mine && !states_[i].is_done && !stops()) job(i);
    });
  }

  void save_index() {
    // A store that cannot keep its index is slower, no more.
    if (const Status saved = index_.save(); !saved && !units_.empty())
      units_.front().warnings.push_back(saved.error().message);
  }

  std::vector<CorpusUnit> my_units() {
    std::vector<CorpusUnit> mine;
    for (std::size_t i = 0; i < units_.size(); ++i)
      if (states_[i].is_mine) mine.push_back(std::move(units_[i]));
    return mine;
  }

  std::size_t decided_count() {
    const std::lock_guard<std::mutex> guard(lock_);
    return decided_count_;
  }

  void done(std::size_t i, UnitSource source, Report report) {
    const std::lock_guard<std::mutex> guard(lock_);
    if (std::exchange(states_[i].is_done, true)) return;
    units_[i].source = source;
    units_[i].report = std::move(report);
    rename_file(units_[i].report, files_[i]);  // the store has the name under which its bytes were first verified
    ++done_count_;
    ++decided_count_;
    if (options_.progress) options_.progress(done_count_, my_count_.value_or(files_.size()));
  }

  bool is_done(std::size_t i) {
    const std::lock_guard<std::mutex> guard(lock_);
    return states_[i].is_done;
  }

  /// Of the bytes as they are now; nothing where they cannot be read, with the report of the unit.
  bool identify(std::size_t i) {
    State& state = states_[i];
    if (state.identity) return true;
    Result<TraceIdentity> identity = identify_trace(files_[i], index_, is_in_sample(i));
    if (!identity) {
      done(i, UnitSource::missing, open_error_report(files_[i], identity.error()));
      return false;
    }
    state.identity = *identity;
    units_[i].key = names_of(i).whole();
    return true;
  }

  /// Read and run again, whatever the index and the store say.
  bool is_in_sample(std::size_t i) const {
    constexpr std::uint64_t steps = 1'000'000;
    const std::string& file = files_[i];
    const std::uint64_t place =
        hash64({reinterpret_cast<const std::uint8_t*>(file.data()), file.size()}, sample_seed_) % steps;
    return static_cast<double>(place) < options_.recheck * static_cast<double>(steps);
  }

  StoreWord ask_store(const std::string& key, std::size_t i) {
    Result<FoundVerdict> found = store_.find(key);
    const std::lock_guard<std::mutex> guard(lock_);
    if (!found) {
      units_[i].problems.push_back(found.error());
      return {};
    }
    switch (found->kind) {
      case FoundVerdict::Kind::none:
        return {};
      case FoundVerdict::Kind::damaged:
        units_[i].warnings.push_back(found->what);
        return {};
      case FoundVerdict::Kind::conflict:
        return {StoreWord::Kind::conflict, conflict_report(files_[i], *found)};
      case FoundVerdict::Kind::verdict:
        const bool is_green = found->report->verdict == Verdict::match;
        return {is_green ? StoreWord::Kind::green : StoreWord::Kind::red, std::move(*found->report)};
    }
    return {};
  }

  // --- before anything runs ---

  void begin_unit(std::size_t i) {
    if (!identify(i) || is_done_by_store(i)) return;
    learn_cost(i);
  }

  /// Whether the unit is done by what the store says of it. A verdict that is no match counts only if another worker
  /// stored it while this run goes on.
  bool is_done_by_store(std::size_t i) {
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

  static bool is_shared_by_shards(const State& state) {
    return std::any_of(state.parts.begin(), state.parts.end(), [](const Part& part) { return !part.is_mine; });
  }

  void learn_cost(std::size_t i) {
    State& state = states_[i];
    state.cost = {learned_cost(history_, names_of(i).history(), mode_name(options_.mode)), state.identity->facts.size};
    state.has_cost = true;
  }

  void estimate_costs() {
    std::vector<TraceCost> costs;
    for (const State& state : states_)
      if (state.has_cost) costs.push_back(state.cost);
    const std::vector<double> estimates = estimated_costs(costs);
    auto next = estimates.begin();
    for (State& state : states_)
      if (state.has_cost) state.cost_s = *next++;
  }

  /// The number of parts that all workers use. 1: the trace is not cut.
  std::size_t parts_of(std::size_t i) {
    const State& state = states_[i];
    const double cost_s = state.cost.learned_s.value_or(0);
    if (options_.mode != VerifyMode::replay || has_plugins_ || options_.program || cost_s <= options_.part_s) return 1;
    const std::string key = names_of(i).parts();
    Result<std::optional<Bytes>> found = find_agreement(store_.folder(), key);
    if (found && !*found) {
      Result<replay::TraceReader> reader = replay::TraceReader::open(files_[i]);
      if (!reader) return 1;
      const std::size_t wanted = count_trace_parts(*reader, wanted_parts(cost_s, options_.part_s));
      if (wanted == 1) return 1;
      Result<Bytes> agreed = agree_on(store_.folder(), key, count_bytes(wanted));
      if (agreed)
        found = std::optional<Bytes>(std::move(*agreed));
      else
        found = agreed.error();
    }
    if (!found) {
      const std::lock_guard<std::mutex> guard(lock_);
      units_[i].warnings.push_back("not cut into parts: " + found.error().message);
      return 1;
    }
    return read_count(**found).value_or(1);
  }

  void cut_unit(std::size_t i) {
    State& state = states_[i];
    // What was no match before is found again by a run from tick 0 in any case.
    if ((state.was_red || state.is_recheck) && !is_shared_by_shards(state)) {
      state.parts.clear();
      return;
    }
    if (!state.parts.empty()) return;
    if (const std::size_t count = parts_of(i); count > 1) state.parts.resize(count);
  }

  /// Leaves the units of this shard. The first shard on the store decides for all.
  Status take_shard_units() {
    const auto shard_count = static_cast<std::uint32_t>(options_.shard->count);
    std::vector<std::size_t> order(files_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return files_[a] < files_[b]; });
    std::vector<PlannedFile> planned;
    for (const std::size_t i : order) {
      const std::optional<replay::FileFacts> facts = replay::file_facts(files_[i]);
      planned.push_back({std::filesystem::path(files_[i]).filename().string(), facts ? facts->size : 0});
    }
    const std::string key =
        plan_key(planned, shard_count, hex128(build_.engine) + hex128(build_.libraries) + build_.options);
    Result<std::optional<Bytes>> bytes = find_agreement(store_.folder(), key);
    if (!bytes) return bytes.error();
    if (!*bytes) {
      const Result<Bytes> wanted = make_plan(order, shard_count);
      if (!wanted) return wanted.error();
      Result<Bytes> agreed = agree_on(store_.folder(), key, *wanted);
      if (!agreed) return agreed.error();
      *bytes = std::move(*agreed);
    }
    const std::optional<ShardPlan> plan = decode_plan(**bytes, files_.size(), shard_count);
    if (!plan)
      return Error{ErrorCode::io, store_.folder().path() + ": the plan of the shards is not one for these traces",
                   "remove " + store_.folder().path_of("agreed/" + spread_name(key))};
    my_count_ = 0;
    for (std::size_t at = 0; at < order.size(); ++at) take_planned(states_[order[at]], plan->traces[at]);
    return {};
  }

  void take_planned(State& state, const std::vector<std::uint32_t>& shards) {
    const auto is_mine = [&](std::uint32_t shard) { return shard == options_.shard->index; };
    state.is_mine = std::any_of(shards.begin(), shards.end(), is_mine);
    if (!state.is_mine) return;
    ++*my_count_;
    if (shards.size() == 1) return;
    state.parts.resize(shards.size());
    for (std::size_t p = 0; p < shards.size(); ++p) state.parts[p].is_mine = is_mine(shards[p]);
  }

  Result<Bytes> make_plan(const std::vector<std::size_t>& order, std::uint32_t shard_count) {
    std::vector<std::size_t> parts(files_.size(), 1);
    const Status status = run_jobs(files_.size(), thread_count(), [&](std::size_t i) {
      // Here a trace that cannot be read is no finding yet: it is one of the shard that gets it.
      const Result<TraceIdentity> identity = identify_trace(files_[i], index_, false);
      if (!identity) return;
      states_[i].identity = *identity;
      learn_cost(i);
      parts[i] = parts_of(i);
    });
    if (!status) return status.error();
    estimate_costs();
    std::vector<std::size_t> parts_in_order;
    std::vector<double> costs;
    for (const std::size_t i : order) {
      parts_in_order.push_back(parts[i]);
      costs.push_back(states_[i].cost_s);
      states_[i].identity.reset();
      states_[i].has_cost = false;
    }
    return encode_plan(plan_shards(parts_in_order, costs, shard_count));
  }

  /// Else the last thread works on the longest while the others have nothing left.
  std::vector<Job> most_expensive_first() {
    estimate_costs();
    std::vector<Job> jobs;
    for (std::size_t i = 0; i < files_.size(); ++i) {
      const State& state = states_[i];
      if (!state.is_mine || state.is_done) continue;
      const double part_count = std::max<double>(1, static_cast<double>(state.parts.size()));
      for (std::size_t p = 0; p < state.parts.size(); ++p)
        if (state.parts[p].is_mine) jobs.push_back({i, p, state.cost_s / part_count});
      // Of a trace that is cut, the run from tick 0 stands behind its parts and waits for a part that is no match.
      jobs.push_back({i, std::nullopt, state.cost_s / part_count});
    }
    std::stable_sort(jobs.begin(), jobs.end(), [](const Job& a, const Job& b) { return a.cost_s > b.cost_s; });
    return jobs;
  }

  // --- one step of a unit or of a part ---

  bool is_over(const Job& job) {
    const std::lock_guard<std::mutex> guard(lock_);
    const State& state = states_[job.unit];
    return state.is_done || (job.part && (state.needs_whole || state.parts[*job.part].word != Part::Word::open));
  }

  /// To its end, unless another worker has it.
  void advance(const Job& job) {
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

  /// False: another worker has it, or the unit is done by an error.
  bool claim(const std::string& key, std::size_t i) {
    const Result<Claims::Answer> answer = claims_.try_claim(key);
    if (!answer) done(i, UnitSource::missing, refused_report(files_[i], answer.error().message, answer.error().hint));
    return answer && *answer == Claims::Answer::won;
  }

  void release(const std::string& key, std::size_t i) {
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

  void advance_part(std::size_t i, std::size_t p) {
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

  bool is_part_done_by_store(std::size_t i, std::size_t p) {
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

  void run_part_of_unit(std::size_t i, std::size_t p) {
    const TracePart part{p, states_[i].parts.size()};
    std::optional<PluginVerification> found = verify_unchanged(i, part);
    if (!found) return;
    if (found->report.verdict == Verdict::error) {
      done(i, UnitSource::verified, std::move(found->report));
      return;
    }
    const Result<FoundVerdict> stored = store_.add(names_of(i).part(part), found->report);
    if (stored && stored->kind == FoundVerdict::Kind::conflict) {
      done(i, UnitSource::verified, conflict_report(files_[i], *stored));
      return;
    }
    if (!stored) {
      const std::lock_guard<std::mutex> guard(lock_);
      units_[i].problems.push_back(stored.error());
    }
    part_is_decided(i, p, std::move(found->report));
  }

  void part_is_decided(std::size_t i, std::size_t p, Report report) {
    {
      const std::lock_guard<std::mutex> guard(lock_);
      State& state = states_[i];
      Part& part = state.parts[p];
      if (part.word != Part::Word::open) return;
      part.word = report.verdict == Verdict::match ? Part::Word::match : Part::Word::other;
      part.report = std::move(report);
      ++decided_count_;
      if (part.word == Part::Word::other && part.is_mine) {
        state.needs_whole = true;
        if (!state.red_part) state.red_part = part.report;
      }
      if (state.needs_whole || !part.is_mine) return;
      const bool is_last = std::all_of(state.parts.begin(), state.parts.end(), [](const Part& each) {
        return !each.is_mine || each.word == Part::Word::match;
      });
      if (!is_last) return;
    }
    finish_parts(i);
  }

  /// All parts of this worker are matches. One thread gets here.
  void finish_parts(std::size_t i) {
    State& state = states_[i];
    for (std::size_t p = 0; p < state.parts.size(); ++p)
      if (!state.parts[p].is_mine && !is_part_done_by_store(i, p)) break;
    if (is_done(i)) return;
    std::vector<const Report*> all, found;
    for (const Part& part : state.parts) {
      all.push_back(part.word == Part::Word::match ? &part.report : nullptr);
      if (all.back() != nullptr && part.is_mine) found.push_back(all.back());
    }
    if (std::optional<Report> whole = join_parts(all)) {
      store_joined(i, std::move(*whole));
      return;
    }
    if (!is_shared_by_shards(state)) {
      const std::lock_guard<std::mutex> guard(lock_);
      state.needs_whole = true;
      return;
    }
    Report report = sum_of_parts(found);
    report.notes.push_back(std::to_string(found.size()) + " of " + std::to_string(all.size()) +
                           " parts of the trace: the report of the corpus says whether the others are there");
    done(i, UnitSource::partial, std::move(report));
  }

  PluginVerification verify_file(const std::string& file, const std::optional<TracePart>& part) {
    if (program_ != nullptr) return program_->verify(file);
    TraceVerification how;
    how.mode = options_.mode;
    how.part = part;
    // With claims a process beats while another one works: a process with threads should not fork.
    if (!needs_plugin(file) && !(has_plugins_ && options_.claims)) {
      Result<replay::TraceReader> reader = replay::TraceReader::open(file);
      if (!reader) return {open_error_report(file, reader.error()), true};
      return {verify_trace(*reader, file, how), true};
    }
    SharedCount later_libraries;  // counted where the plug-in maps more while it runs
    const auto work = [&](SharedCount& compared) {
      how.compared = &compared;
      Result<replay::TraceReader> reader = replay::TraceReader::open(file);
      if (!reader) return open_error_report(file, reader.error());
      Report report = verify_trace(*reader, file, how);
      const auto libraries = mapped_libraries();
      if (!libraries || libraries_digest(*libraries) != build_.libraries) later_libraries.add_tick(0);
      return report;
    };
    PluginVerification found =
        verifier::verify_by_plugin(file, mode_name(options_.mode), work, [&] { claims_.beat_when_due(); });
    if (later_libraries.ticks() > 0) {
      found.is_verdict = false;
      found.report.notes.push_back("not stored: the plug-in mapped more libraries while it ran");
    }
    return found;
  }

  /// Nothing: the trace changed meanwhile, and the unit is done.
  std::optional<PluginVerification> verify_unchanged(std::size_t i, const std::optional<TracePart>& part) {
    const std::string& file = files_[i];
    const auto start = std::chrono::steady_clock::now();
    PluginVerification found = verify_file(file, part);
    found.report.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (const std::string warning = program_ == nullptr ? "" : program_->take_warning(); !warning.empty()) {
      const std::lock_guard<std::mutex> guard(lock_);
      units_[i].warnings.push_back(warning);
    }
    const std::optional<replay::FileFacts> after = replay::file_facts(file);
    if (after && is_unchanged(states_[i].identity->facts, *after)) return found;
    done(i, UnitSource::missing, open_error_report(file, changed_trace_error(file)));
    return std::nullopt;
  }

  void run_unit(std::size_t i, UnitSource source) {
    std::optional<PluginVerification> found = verify_unchanged(i, {});
    if (!found) return;
    if (found->report.verdict == Verdict::error || !found->is_verdict) {
      done(i, source, std::move(found->report));
      return;
    }
    // A part that is no match is never forgotten: a whole that is one makes two verdicts that differ.
    if (const std::optional<Report> red = red_part_of(i); red && found->report.verdict == Verdict::match) {
      if (const Result<FoundVerdict> kept = store(i, *red); !kept) {
        const std::lock_guard<std::mutex> guard(lock_);
        units_[i].problems.push_back(kept.error());
        found->report.verdict = Verdict::not_reproducible;
        found->report.reason = "the run from tick 0 matches, a run from a checkpoint did not: " + red->reason;
      }
    }
    store_report(i, source, std::move(found->report));
  }

  std::optional<Report> red_part_of(std::size_t i) {
    const std::lock_guard<std::mutex> guard(lock_);
    return states_[i].red_part;
  }

  /// Of several workers that join the same parts, the one whose verdict the store took has verified the trace.
  void store_joined(std::size_t i, Report report) {
    const Result<FoundVerdict> stored = store(i, report);
    const bool is_mine = !stored || stored->is_new || !options_.claims;
    finish_stored(i, is_mine ? UnitSource::verified : UnitSource::other_worker, std::move(report), stored);
  }

  void store_report(std::size_t i, UnitSource source, Report report) {
    const Result<FoundVerdict> stored = store(i, report);
    // After a lease that expired, another worker may have done the same: the verdict counts for one of the two.
    const bool is_late = options_.claims && source == UnitSource::verified && !was_red(i) && stored &&
                         stored->kind == FoundVerdict::Kind::verdict && !stored->is_new;
    finish_stored(i, is_late ? UnitSource::other_worker : source, std::move(report), stored);
  }

  bool was_red(std::size_t i) {
    const std::lock_guard<std::mutex> guard(lock_);
    return states_[i].was_red;
  }

  /// The row of the history first: a trace with a verdict is not verified again, and would never get its row.
  Result<FoundVerdict> store(std::size_t i, const Report& report) {
    const Status kept = history_.add(names_of(i).history(), history_row(i, report));
    if (!kept && !store_.folder().exists(spread_name(key_of(i)))) return kept.error();
    return store_.add(key_of(i), report);
  }

  void finish_stored(std::size_t i, UnitSource source, Report report, const Result<FoundVerdict>& stored) {
    if (stored && stored->kind == FoundVerdict::Kind::conflict) {
      done(i, source, conflict_report(files_[i], *stored));
      return;
    }
    if (!stored) {
      const std::lock_guard<std::mutex> guard(lock_);
      units_[i].problems.push_back(stored.error());
    }
    done(i, source, std::move(report));
  }

  HistoryRow history_row(std::size_t i, const Report& report) const {
    HistoryRow row;
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

  // --- reports ---

  void look_up_unit(std::size_t i) {
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
                        "ticktrue corpus verify " + shell_word(files_[i]) + " --cache " + shell_word(store) +
                            (options_.program ? " --command with the same words" : "")));
  }

  /// A trace of which every part is there, but nobody has put the verdict together. False: `missing` says what is not.
  bool look_up_parts(std::size_t i, std::string& missing) {
    const Result<std::optional<Bytes>> agreed = find_agreement(store_.folder(), names_of(i).parts());
    const std::optional<std::size_t> count = agreed && *agreed ? read_count(**agreed) : std::nullopt;
    if (!count) return false;
    std::vector<Report> reports(*count);
    std::vector<const Report*> all;
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
    std::optional<Report> whole = join_parts(all);
    if (whole) done(i, UnitSource::cached, std::move(*whole));
    return whole.has_value();
  }

  const std::vector<std::string>& files_;
  const VerdictStore& store_;
  const CorpusOptions& options_;
  BuildSubject build_;
  ProgramRuns* program_;  // null: the engine verifies
  StatIndex index_;
  Claims claims_;
  History history_;
  std::vector<CorpusUnit> units_;
  std::vector<State> states_;
  bool has_plugins_;
  std::uint64_t sample_seed_;
  std::optional<std::size_t> my_count_;  // of a shard
  std::mutex lock_;
  std::size_t done_count_ = 0;     // units
  std::size_t decided_count_ = 0;  // units and parts
};

}  // namespace

Result<std::vector<CorpusUnit>> verify_corpus(const std::vector<std::string>& files, const std::string& traces,
                                              const VerdictStore& store, const CorpusOptions& options) {
  Result<BuildSubject> build = build_subject(options.mode, options.program.get());
  if (!build) return build.error();
  if (!options.program) return CorpusRun(files, traces, store, options, std::move(*build)).verify();
  Result<std::unique_ptr<ProgramRuns>> program = ProgramRuns::make(*options.program, options.stops);
  if (!program) return program.error();
  return CorpusRun(files, traces, store, options, std::move(*build), program->get()).verify();
}

Result<std::vector<CorpusUnit>> look_up_corpus(const std::vector<std::string>& files, const std::string& traces,
                                               const VerdictStore& store, const CorpusOptions& options) {
  Result<BuildSubject> build = build_subject(options.mode, options.program.get());
  if (!build) return build.error();
  return CorpusRun(files, traces, store, options, std::move(*build)).look_up();
}

Result<std::vector<double>> open_costs(const std::vector<std::string>& files, const std::string& traces,
                                       const VerdictStore& store, const CorpusOptions& options) {
  Result<BuildSubject> build = build_subject(options.mode, options.program.get());
  if (!build) return build.error();
  return CorpusRun(files, traces, store, options, std::move(*build)).open_costs();
}

int corpus_exit_code(const std::vector<CorpusUnit>& units, bool allow_truncated) {
  std::vector<int> codes;
  for (const CorpusUnit& unit : units) {
    codes.push_back(unit.report.exit_code(allow_truncated));
    if (!unit.problems.empty()) codes.push_back(exit_usage);
  }
  return worst_exit_code(codes);
}

}  // namespace ticktrue::verifier
