// Runs one program under one perturbation after another.
// SPDX-License-Identifier: MIT
#include "tool/experiment/shake/shake.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>

#include "base/parallel/jobs.h"
#include "tool/experiment/ddmin.h"
#include "tool/experiment/shake/call_site.h"

namespace ticktrue::shake {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int control_count = 3;
constexpr int diverged_control_count = 8;  // such runs end at the first difference, so each says less
constexpr int late_control_count = 3;
constexpr int unstable_control_count = 12;
// Number of consecutive runs that must agree. The chance that a varying program agrees so often is at most chance_max.
constexpr double chance_max = 1e-3;
constexpr int still_count_max = 40;
constexpr int confirmation_count_max = 100;
constexpr unsigned together_count = 4;  // covers every variant of each perturbation
constexpr double slowest_run = 20;      // limit of a run, in multiples of the control
constexpr double run_time_min_s = 10;   // under emulation, a short program takes seconds

class Shaking {
 public:
  explicit Shaking(const ShakeOptions& options) : options_(options), launcher_(options.launch), start_(Clock::now()) {}

  Result<ShakeReport> run() {
    if (const Status status = begin_rebuild(); !status) return status.error();
    if (const Status status = run_control(); !status) return status.error();
    if (report_.failure.empty()) {
      facts_ = collect_facts(options_.launch.words, options_.launch.folder, [&](std::string_view name) {
        return std::any_of(options_.choices.begin(), options_.choices.end(),
                           [&](const Choice& choice) { return choice.perturbation->name == name; });
      });
      facts_.no_shim = report_.no_shim = no_shim_;
      facts_.control = report_.control_with_shim.empty() ? report_.control.front() : report_.control_with_shim.front();
      if (const Status status = rebuild(); !status) return status.error();
      if (const Status status = report_.repeats ? run_rows() : find_fix(); !status) return status.error();
    }
    launcher_.end_escaped();
    if (const std::string escaped = launcher_.escaped(); !escaped.empty())
      report_.notes.push_back("the program left running, outside of its process group, and shake ended: " + escaped);
    report_.run_count = launcher_.run_count();
    report_.wall_s = elapsed_s();
    return std::move(report_);
  }

 private:
  double elapsed_s() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  bool goes_on() {
    const bool has_time = !options_.time_s || elapsed_s() < *options_.time_s;
    if (!has_time) report_.ended_early = true;
    return has_time;
  }

  void tell(std::uint64_t more_expected = 0) {
    expected_ += more_expected;
    if (options_.progress) options_.progress(launcher_.run_count(), std::max(expected_, launcher_.run_count()));
  }

  // --- other builds of the program ----------------------------------------------------------------------------------

  RebuildOptions rebuild_options() const { return {options_.rebuild, options_.launch.folder, options_.launch.time_s}; }

  /// Builds the program first. A failing command is reported before anything runs.
  Status begin_rebuild() {
    if (options_.rebuild.empty()) return {};
    Result<std::string> program = build_as_is(rebuild_options());
    if (!program) return program.error();
    built_as_is_ = *program;
    return {};
  }

  /// Builds every requested kind, and runs the unchanged build as a baseline.
  Status rebuild() {
    facts_.builds = no_builds("without --rebuild CMD there is no other build of the program");
    build_baseline_ = baseline_;
    if (built_as_is_.empty() || !report_.repeats) return {};
    Conditions plain;
    plain.program = built_as_is_;
    const Result<Run> run = launcher_.run(plain);
    if (!run) return run.error();
    build_baseline_ = signature(run->outcome);
    const bool is_judged = run->outcome.kind == OutcomeKind::match || run->outcome.kind == OutcomeKind::diverged;
    if (!is_judged) facts_.builds = no_builds("the program of --rebuild: " + run->outcome.reason);
    if (!is_judged) return {};
    if (build_baseline_ != baseline_)
      report_.notes.push_back("--rebuild with nothing changed gives another program than this one: " +
                              outcome_text(run->outcome) + "; other builds are compared with that one");
    for (const Choice& choice : options_.choices)
      if (const auto kind = build_kind_named(choice.perturbation->name); kind && goes_on())
        facts_.builds[static_cast<std::size_t>(*kind)] = build_kind(rebuild_options(), *kind, built_as_is_);
    return {};
  }

  /// The signature of an unchanged run.
  const std::string& baseline_of(const Perturbation& perturbation) const {
    return build_kind_named(perturbation.name) ? build_baseline_ : baseline_;
  }

  // --- control ------------------------------------------------------------------------------------------------------

  Status run_control() {
    expected_ = control_count + 1;
    Conditions plain;
    plain.has_shim = false;
    Conditions idle;  // with the preload library, but without changes
    const auto add = [&](const Conditions& conditions, std::vector<Outcome>& outcomes) -> Status {
      const Result<Run> run = launcher_.run(conditions);
      if (!run) return run.error();
      outcomes.push_back(run->outcome);
      tell();
      return {};
    };
    for (int i = 0; i < control_count || (i < diverged_control_count && has_equal_differences()); ++i) {
      if (const Status status = add(plain, report_.control); !status) return status;
      if (i == 0 && !judge_first(report_.control.front())) return {};
      if (i == 0)
        launcher_.set_time_limit(
            std::min(options_.launch.time_s, std::max(run_time_min_s, slowest_run * report_.control.front().wall_s)));
    }
    baseline_ = signature(report_.control.front());
    report_.repeats = is_control_equal();
    no_shim_ = options_.launch.no_shim;
    if (!launcher_.has_shim()) return {};
    if (const Status status = add(idle, report_.control_with_shim); !status) return status;
    const Outcome& outcome = report_.control_with_shim.front();
    no_shim_.clear();
    if (!outcome.has_shim)
      no_shim_ = "the preload library is not loaded: the program is linked statically, or has other privileges";
    else if (report_.repeats && signature(outcome) != baseline_)
      no_shim_ = "the program does not run as before with the preload library: " + outcome_text(outcome);
    if (!no_shim_.empty()) launcher_.drop_shim();
    return {};
  }

  bool is_control_equal() const {
    return std::all_of(report_.control.begin(), report_.control.end(), [&](const Outcome& outcome) {
      return signature(outcome) == signature(report_.control.front());
    });
  }
  bool has_equal_differences() const {
    return report_.control.front().kind != OutcomeKind::match && is_control_equal();
  }

  /// Adds runs of the plain program, because the first runs may have been equal by chance.
  Status run_control_again(int count) {
    Conditions plain;
    plain.has_shim = false;
    tell(static_cast<std::uint64_t>(count));
    for (int i = 0; i < count; ++i) {
      const Result<Run> run = launcher_.run(plain);
      if (!run) return run.error();
      report_.control.push_back(run->outcome);
      tell();
    }
    report_.repeats = is_control_equal();
    return {};
  }

  /// False: nothing can be examined, and the report gives the reason.
  bool judge_first(const Outcome& first) {
    switch (first.kind) {
      case OutcomeKind::match:
      case OutcomeKind::diverged:
        return true;
      case OutcomeKind::no_result:
        report_.failure = first.has_session ? "the program opened a session and did not close it: " + first.reason
                                            : "the program " + first.reason;
        return false;
      case OutcomeKind::other:
      case OutcomeKind::crashed:
      case OutcomeKind::hung:
      case OutcomeKind::not_started:
        report_.failure = "the program, as it is: " + first.reason;
        return false;
    }
    return false;
  }

  // --- a repeatable program -----------------------------------------------------------------------------------------

  Conditions conditions_of(const Choice& choice, unsigned variant, std::uint64_t seed) const {
    Conditions conditions;
    add_to(conditions, choice, variant, seed);
    return conditions;
  }

  void add_to(Conditions& conditions, const Choice& choice, unsigned variant, std::uint64_t seed) const {
    choice.perturbation->apply(conditions, variant, seed, facts_);
    if (choice.calls) {
      conditions.settings.call_range_count = 1;
      conditions.settings.call_ranges[0] = *choice.calls;
    }
    if (!choice.ticks) return;
    conditions.settings.tick_first = choice.ticks->first;
    conditions.settings.tick_last = choice.ticks->second;
  }

  bool is_together(const RowResult& row) const {
    const Choice& choice = row.choice;
    return !options_.each_alone && row.state == RowState::not_run && choice.perturbation->kind == Kind::a &&
           choice.perturbation->is_combinable && !choice.calls && !choice.ticks;
  }

  std::uint64_t try_count(const Perturbation& perturbation) const {
    return std::uint64_t{perturbation.variant_count} * options_.seed_count;
  }

  Status run_rows() {
    for (const Choice& choice : options_.choices) {
      RowResult& row = report_.rows.emplace_back();
      row.choice = choice;
      row.reason = choice.perturbation->missing(facts_);
      if (!row.reason.empty()) row.state = RowState::not_applicable;
    }
    if (const Status status = run_together(); !status) return status;
    std::vector<std::size_t> left;
    std::uint64_t expected = 0;
    for (std::size_t i = 0; i < report_.rows.size(); ++i) {
      if (report_.rows[i].state != RowState::not_run) continue;
      left.push_back(i);
      expected += try_count(*report_.rows[i].choice.perturbation);
    }
    tell(expected);
    std::mutex lock;
    std::optional<Error> error;
    const Status threads = run_jobs(left.size(), options_.thread_count, [&](std::size_t job) {
      const Status status = run_row(report_.rows[left[job]], lock);
      const std::lock_guard guard(lock);
      if (!status && !error) error = status.error();
    });
    if (error) return *error;
    if (!threads) return threads.error();
    if (moved_together_ && std::none_of(report_.rows.begin(), report_.rows.end(), [](const RowResult& row) {
          return row.state == RowState::moved && row.choice.perturbation->kind == Kind::a;
        }))
      if (const Status status = find_set(); !status) return status;
    if (!guilty_.empty() || moved_together_) {
      if (const Status status = run_control_again(late_control_count); !status) return status;
      if (!report_.repeats) return find_fix();
    }
    if (options_.narrows) narrow_rows();
    return {};
  }

  /// Applies all perturbations of class A in one run. If the program does not move, no perturbation needs a run of its
  /// own.
  Status run_together() {
    std::vector<RowResult*> members;
    for (RowResult& row : report_.rows)
      if (is_together(row)) members.push_back(&row);
    if (members.size() < 2) return {};
    tell(together_count);
    for (unsigned variant = 0; variant < together_count; ++variant) {
      if (!goes_on()) return {};
      Conditions conditions;
      for (const RowResult* row : members)
        add_to(conditions, row->choice, variant % row->choice.perturbation->variant_count, variant + 1);
      const Result<Run> run = launcher_.run(conditions);
      if (!run) return run.error();
      tell();
      if (signature(run->outcome) == baseline_) continue;
      moved_together_ = variant;
      report_.together_outcome = run->outcome;
      return {};
    }
    for (RowResult* row : members) row->state = RowState::same_together;
    return {};
  }

  /// May be called from any thread.
  Status run_row(RowResult& row, std::mutex& lock) {
    const Perturbation& perturbation = *row.choice.perturbation;
    for (std::uint64_t seed_round = 0; seed_round < options_.seed_count; ++seed_round)
      for (unsigned variant = 0; variant < perturbation.variant_count; ++variant) {
        {
          const std::lock_guard guard(lock);
          if (!goes_on()) {
            if (row.run_count == 0) row.reason = "no time was left";
            row.state = row.run_count == 0 ? RowState::not_run : RowState::same;
            return {};
          }
        }
        const std::uint64_t seed = 1 + variant + seed_round * perturbation.variant_count;
        const Conditions conditions = conditions_of(row.choice, variant, seed);
        const Result<Run> run = launcher_.run(conditions);
        if (!run) return run.error();
        const std::lock_guard guard(lock);
        tell();
        ++row.run_count;
        row.wall_s += run->outcome.wall_s;
        if (signature(run->outcome) == baseline_of(perturbation)) continue;
        if (!is_own_refusal(perturbation, run->outcome, row)) {
          row.state = RowState::moved;
          row.outcome = run->outcome;
          guilty_.emplace_back(&row, conditions);
        }
        return {};
      }
    row.state = RowState::same;
    return {};
  }

  /// If a program cannot start under a perturbation, the perturbation does not apply.
  static bool is_own_refusal(const Perturbation& perturbation, const Outcome& outcome, RowResult& row) {
    if (outcome.has_session || outcome.kind == OutcomeKind::diverged) return false;
    const bool is_launch = !perturbation.uses_shim;
    if (!is_launch) return false;
    row.state = RowState::not_applicable;
    row.reason = "the program does not begin that way: " + outcome.reason;
    return true;
  }

  /// Finds a minimal set of perturbations that moves the program, because no single one does.
  Status find_set() {
    std::vector<const RowResult*> members;
    for (const RowResult& row : report_.rows)
      if (row.state == RowState::same && row.choice.perturbation->kind == Kind::a &&
          row.choice.perturbation->is_combinable && !row.choice.calls && !row.choice.ticks)
        members.push_back(&row);
    const unsigned variant = *moved_together_;
    std::optional<Error> error;
    const auto kept = soak::ddmin(members.size(), [&](const std::vector<std::size_t>& indices) {
      if (error || indices.empty() || !goes_on()) return false;
      Conditions conditions;
      for (const std::size_t i : indices)
        add_to(conditions, members[i]->choice, variant % members[i]->choice.perturbation->variant_count, variant + 1);
      const Result<Run> run = launcher_.run(conditions);
      tell(1);
      if (!run) error = run.error();
      return run && signature(run->outcome) != baseline_;
    });
    if (error) return *error;
    for (const std::size_t i : kept) report_.together.emplace_back(members[i]->choice.perturbation->name);
    return {};
  }

  void narrow_rows() {
    NarrowOptions options;
    options.baseline = baseline_;
    options.goes_on = [&] {
      tell(1);
      return goes_on();
    };
    std::stable_sort(guilty_.begin(), guilty_.end(), [](const auto& a, const auto& b) {
      return a.first->choice.perturbation->kind < b.first->choice.perturbation->kind;
    });
    for (const auto& [row, conditions] : guilty_) {
      row->repeat_count = 1;
      row->moved_count = 1;
      if (goes_on()) {
        const Result<Run> again = launcher_.run(conditions);
        ++row->repeat_count;
        if (again && signature(again->outcome) != baseline_of(*row->choice.perturbation)) ++row->moved_count;
      }
      const Perturbation& perturbation = *row->choice.perturbation;
      const bool is_limited = row->choice.calls || row->choice.ticks;
      // Calls of this perturbation can only be changed in runs that fix its source.
      if (perturbation.narrowing == Narrowing::calls && !perturbation.uses_shim) continue;
      if (is_limited || perturbation.kind == Kind::c || perturbation.narrowing == Narrowing::none || !goes_on())
        continue;
      row->cause = narrow(launcher_, perturbation, conditions, row->outcome, options);
    }
  }

  // --- a program that does not repeat itself ------------------------------------------------------------------------

  /// The number of runs that must agree. Fewer runs may agree by chance. The most frequent outcome of the control gives
  /// that chance.
  int still_count() const {
    std::map<std::string, int> counts;
    int most = 0;
    for (const Outcome& outcome : report_.control) most = std::max(most, ++counts[signature(outcome)]);
    const double likely = static_cast<double>(most) / static_cast<double>(report_.control.size());
    double chance = 1;
    int count = 1;
    for (; count < still_count_max && chance > chance_max; ++count) chance *= likely;
    return count;
  }

  /// Whether still_count_ runs are equal.
  Result<bool> holds_still(const Conditions& conditions) {
    std::string first;
    for (int i = 0; i < still_count_; ++i) {
      const Result<Run> run = launcher_.run(conditions);
      tell(1);
      if (!run) return run.error();
      const bool is_judged = run->outcome.kind == OutcomeKind::match || run->outcome.kind == OutcomeKind::diverged;
      if (!is_judged) return false;
      if (i == 0) first = signature(run->outcome);
      if (signature(run->outcome) != first) return false;
    }
    return true;
  }

  /// Whether plain runs vary and runs under these conditions do not. Both kinds of run alternate, because the load of
  /// the machine changes and the first runs say little about later runs.
  Result<bool> is_confirmed(const Conditions& conditions, std::size_t source_count) {
    Conditions plain;
    plain.has_shim = false;
    std::string first;
    std::map<std::string, int> counts;
    int most = 0;
    for (int round = 1; round <= confirmation_count_max && goes_on(); ++round) {
      const Result<Run> varying = launcher_.run(plain);
      tell(1);
      if (!varying) return varying.error();
      most = std::max(most, ++counts[signature(varying->outcome)]);
      const Result<Run> still = launcher_.run(conditions);
      tell(1);
      if (!still) return still.error();
      if (round == 1) first = signature(still->outcome);
      if (signature(still->outcome) != first) return false;
      if (std::pow(static_cast<double>(most) / round, round) <= chance_max / static_cast<double>(source_count))
        return true;
    }
    return false;
  }

  Conditions fixed(const std::vector<const Perturbation*>& rows) const {
    Conditions conditions;
    for (const Perturbation* row : rows) row->fix(conditions);
    return conditions;
  }

  Status find_fix() {
    forget_rows();
    const auto missing = unstable_control_count - static_cast<int>(report_.control.size());
    if (const Status status = run_control_again(std::max(missing, 0)); !status) return status;
    still_count_ = still_count();
    std::vector<const Perturbation*> sources;
    for (const Choice& choice : options_.choices) {
      const Perturbation& row = *choice.perturbation;
      if (row.fix == nullptr) continue;
      const std::string missing_here = row.missing(facts_);
      if (missing_here.empty()) sources.push_back(&row);
      if (!no_shim_.empty() && missing_here == no_shim_) report_.fix.not_tried.emplace_back(row.name);
    }
    for (const Perturbation* source : sources) {
      if (!goes_on()) return {};
      const Result<bool> still = holds_still(fixed({source}));
      if (!still) return still.error();
      if (!*still) continue;
      const Result<bool> confirmed = is_confirmed(fixed({source}), sources.size());
      if (!confirmed) return confirmed.error();
      if (*confirmed) return found_fix({source});
    }
    if (sources.size() >= 2) {
      const Result<bool> still = holds_still(fixed(sources));
      if (!still) return still.error();
      const Result<bool> confirmed = *still ? is_confirmed(fixed(sources), sources.size()) : still;
      if (!confirmed) return confirmed.error();
      if (*confirmed) return find_least_fix(sources);
    }
    report_.instructions = find_instructions(facts_.program);
    return {};
  }

  /// Drops the results of single perturbations that were found before the program turned out not to repeat itself.
  void forget_rows() {
    guilty_.clear();
    report_.rows.clear();
    report_.together.clear();
    report_.together_outcome = {};
    for (const Choice& choice : options_.choices) {
      RowResult& row = report_.rows.emplace_back();
      row.choice = choice;
      row.reason = "the program does not repeat itself";
    }
  }

  Status find_least_fix(const std::vector<const Perturbation*>& sources) {
    std::vector<const Perturbation*> needed = sources;
    for (std::size_t i = 0; i < needed.size() && goes_on();) {
      std::vector<const Perturbation*> fewer;
      std::copy_if(needed.begin(), needed.end(), std::back_inserter(fewer),
                   [&](const Perturbation* row) { return row != needed[i]; });
      const Result<bool> enough = holds_still(fixed(fewer));
      if (!enough) return enough.error();
      if (*enough)
        needed = fewer;
      else
        ++i;
    }
    return found_fix(needed);
  }

  Status found_fix(const std::vector<const Perturbation*>& rows) {
    report_.fix.is_found = true;
    for (const Perturbation* row : rows) {
      report_.fix.names.emplace_back(row->name);
      report_.fix.mends.emplace_back(row->mend);
    }
    const Perturbation& first = *rows.front();
    if (rows.size() != 1 || first.narrowing != Narrowing::calls || !options_.narrows) return {};
    // Trapped calls are only counted in a run that traps them.
    const Result<Run> run = launcher_.run(fixed(rows));
    if (!run) return run.error();
    const bool has_more = run->outcome.calls_of(first.group) > facts_.control.calls_of(first.group);
    report_.fix.cause = narrow_fix(
        launcher_, first, fixed(rows), has_more ? run->outcome : facts_.control,
        [&](const Conditions& conditions) {
          const Result<bool> still = holds_still(conditions);
          return still && *still;
        },
        [&] { return goes_on(); });
    return {};
  }

  const ShakeOptions& options_;
  Launcher launcher_;
  Clock::time_point start_;
  ShakeReport report_;
  Facts facts_;
  std::string no_shim_;
  std::string baseline_;
  std::string built_as_is_;                 // the unchanged build; empty: without --rebuild
  std::string build_baseline_;              // signature of the unchanged build
  std::optional<unsigned> moved_together_;  // the variant that moved the program
  std::vector<std::pair<RowResult*, Conditions>> guilty_;
  std::uint64_t expected_ = 0;
  int still_count_ = still_count_max;
};

}  // namespace

std::size_t ShakeReport::count(RowState state) const {
  return static_cast<std::size_t>(
      std::count_if(rows.begin(), rows.end(), [&](const RowResult& row) { return row.state == state; }));
}

std::size_t ShakeReport::moved_count(Kind kind) const {
  return static_cast<std::size_t>(std::count_if(rows.begin(), rows.end(), [&](const RowResult& row) {
    return row.state == RowState::moved && row.choice.perturbation->kind == kind;
  }));
}

Result<ShakeReport> run_shake(const ShakeOptions& options) {
  return Shaking(options).run();
}

}  // namespace ticktrue::shake
