// The implementation of a corpus run, shared by its source files: plans, claims, verifies and stores.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "tool/corpus/build_subject.h"
#include "tool/corpus/run/corpus_run.h"
#include "tool/corpus/run/costs.h"
#include "tool/corpus/run/program_runs.h"
#include "tool/corpus/trace_identity.h"
#include "tool/corpus/verify_trace.h"
#include "verifier/plugins/plugin.h"
#include "verifier/report/report.h"
#include "verifier/store/claims.h"
#include "verifier/store/history.h"
#include "verifier/store/stat_index.h"
#include "verifier/store/verdict_store.h"
#include "verifier/verify/verify.h"

namespace ticktrue::tool {

/// The report of a trace that could not be examined.
verifier::Report refused_report(const std::string& file, const std::string& reason, const std::string& hint);
/// The report of a trace with two verdicts that differ.
verifier::Report conflict_report(const std::string& file, const verifier::FoundVerdict& found);
/// The agreed number of parts; nothing: the bytes are not a number of parts.
std::optional<std::size_t> read_part_count(ByteView bytes);

/// One run over the units of a corpus. A unit is a trace.
class CorpusRun {
 public:
  CorpusRun(const std::vector<std::string>& files, const std::string& traces, const verifier::VerdictStore& store,
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
        has_plugins_(!options.program && !verifier::plugin_simulations().empty()),
        sample_seed_(std::random_device{}()) {}

  /// Verifies all units, in rounds: a unit that another worker holds is looked at again in the next round.
  Result<std::vector<CorpusUnit>> verify();
  Result<std::vector<CorpusUnit>> look_up();
  Result<std::vector<double>> open_costs();

 private:
  enum class PartResult { open, match, other };
  struct Part {
    bool is_mine = true;  // of this shard
    PartResult result = PartResult::open;
    verifier::Report report;  // unless open
  };
  struct State {
    bool is_mine = true;  // of this shard, as a whole or in parts
    bool is_done = false;
    std::optional<TraceIdentity> identity;
    bool has_cost = false;
    TraceCost cost;
    double cost_s = 0;  // as estimated
    bool was_looked_up = false;
    bool was_red = false;                      // before this run: such a verdict is found again
    bool is_recheck = false;                   // of a verdict that is a match
    std::vector<Part> parts;                   // empty: the trace is not cut
    std::optional<verifier::Report> red_part;  // the first part that is no match
    bool needs_whole = false;                  // a part is no match: a run from tick 0 decides
  };
  /// A trace, or a part of it.
  struct Job {
    std::size_t unit = 0;
    std::optional<std::size_t> part;
    double cost_s = 0;
  };
  struct StoreWord {
    enum class Kind { nothing, green, red, conflict };
    Kind kind = Kind::nothing;
    verifier::Report report;
  };

  bool stops() const { return options_.stops && options_.stops(); }
  unsigned thread_count() const { return has_plugins_ ? 1 : options_.thread_count; }
  const std::string& key_of(std::size_t i) const { return units_[i].key; }
  UnitNames names_of(std::size_t i) const { return {*states_[i].identity, build_}; }

  // ---- All units ----

  Status for_each_unit(const std::function<void(std::size_t)>& job);
  void save_index();
  std::vector<CorpusUnit> my_units();
  std::size_t decided_count();
  void done(std::size_t i, UnitSource source, verifier::Report report);
  bool is_done(std::size_t i);
  /// Sets the identity of the present bytes. False: the file is unreadable, and the unit is done with a report of it.
  bool identify(std::size_t i);
  /// Whether the trace is read and run again, whatever index and store say.
  bool is_in_sample(std::size_t i) const;
  StoreWord ask_store(const std::string& key, std::size_t i);
  /// Whether the store has decided the unit. A verdict other than a match counts only if another worker stored it
  /// during this run.
  bool is_done_by_store(std::size_t i);
  static bool is_shared_by_shards(const State& state);
  void look_up_unit(std::size_t i);
  /// Joins the verdicts of all parts if no worker has joined them. False: `missing` says what is missing.
  bool look_up_parts(std::size_t i, std::string& missing);

  // ---- Before a unit runs (corpus_plan.cpp) ----

  void begin_unit(std::size_t i);
  void learn_cost(std::size_t i);
  void estimate_costs();
  /// The number of parts, the same for all workers. 1: the trace is not cut.
  std::size_t parts_of(std::size_t i);
  void cut_unit(std::size_t i);
  /// Keeps only the units of this shard. The first shard on the store decides for all shards.
  Status take_shard_units();
  void take_planned(State& state, const std::vector<std::uint32_t>& shards);
  Result<Bytes> make_plan(const std::vector<std::size_t>& order, std::uint32_t shard_count);
  /// The most expensive job is first: otherwise one thread works on it alone at the end.
  std::vector<Job> most_expensive_first();

  // ---- One step of a unit or a part (corpus_units.cpp) ----

  bool is_over(const Job& job);
  /// Runs the job to its end, unless another worker holds it.
  void advance(const Job& job);
  /// False: another worker holds the unit, or an error has decided it.
  bool claim(const std::string& key, std::size_t i);
  void release(const std::string& key, std::size_t i);
  void advance_part(std::size_t i, std::size_t p);
  bool is_part_done_by_store(std::size_t i, std::size_t p);
  void run_part_of_unit(std::size_t i, std::size_t p);
  void part_is_decided(std::size_t i, std::size_t p, verifier::Report report);
  /// Requires: all parts of this worker are matches. Only one thread calls it.
  void finish_parts(std::size_t i);
  PluginVerification verify_file(const std::string& file, const std::optional<verifier::TracePart>& part);
  /// Nothing: the trace changed meanwhile, and the unit is done.
  std::optional<PluginVerification> verify_unchanged(std::size_t i, const std::optional<verifier::TracePart>& part);
  void run_unit(std::size_t i, UnitSource source);
  std::optional<verifier::Report> red_part_of(std::size_t i);
  bool was_red(std::size_t i);

  // ---- Storing ----

  /// If several workers join the same parts, the worker whose verdict the store took has verified the trace.
  void store_joined(std::size_t i, verifier::Report report);
  void store_report(std::size_t i, UnitSource source, verifier::Report report);
  /// Stores the row of the history first: a trace with a verdict is not verified again, and would never get a row.
  Result<verifier::FoundVerdict> store(std::size_t i, const verifier::Report& report);
  void finish_stored(std::size_t i, UnitSource source, verifier::Report report,
                     const Result<verifier::FoundVerdict>& stored);
  verifier::HistoryRow history_row(std::size_t i, const verifier::Report& report) const;

  const std::vector<std::string>& files_;
  const verifier::VerdictStore& store_;
  const CorpusOptions& options_;
  BuildSubject build_;
  ProgramRuns* program_;  // null: the engine verifies
  verifier::StatIndex index_;
  verifier::Claims claims_;
  verifier::History history_;
  std::vector<CorpusUnit> units_;
  std::vector<State> states_;
  bool has_plugins_;
  std::uint64_t sample_seed_;
  std::optional<std::size_t> my_count_;  // of a shard
  std::mutex lock_;
  std::size_t done_count_ = 0;     // units
  std::size_t decided_count_ = 0;  // units and parts
};

}  // namespace ticktrue::tool
