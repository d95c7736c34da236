// Runs worlds in blocks on threads, and sums their counts in order.
// SPDX-License-Identifier: MIT
#include "tool/experiment/soak/soak.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <mutex>
#include <system_error>
#include <utility>

#include "base/build_info.h"
#include "base/parallel/jobs.h"
#include "tool/experiment/oracle/physics_checks.h"
#include "tool/experiment/soak/choice_effects.h"
#include "tool/experiment/soak/failure_files.h"
#include "verifier/runs/data_file.h"

namespace ticktrue::soak {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The contribution of one world to the counters.
struct WorldOutcome {
  bool is_done = false;
  SoakCounters counts;
};

/// A file that exists while a world is examined. If the process ends, the remaining file names the world.
class RunningFile {
 public:
  RunningFile(const SoakOptions& options, std::uint64_t index)
      : path_(options.folder + "/running_" + std::to_string(index)) {
    std::ofstream(path_) << "ticktrue soak --seed " << options.seed << " --world " << index << "\n";
  }
  RunningFile(const RunningFile&) = delete;
  ~RunningFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }

 private:
  std::string path_;
};

class Soak {
 public:
  explicit Soak(const SoakOptions& options)
      : options_(options), identity_{options.seed, options.checks_text, build_info().commit} {}

  Result<SoakReport> run() {
    std::error_code failed;
    std::filesystem::create_directories(options_.folder, failed);
    if (failed) return Error{ErrorCode::io, options_.folder + ": cannot be made: " + failed.message(), ""};
    if (options_.resume)
      if (const Status read = read_progress(); !read) return read.error();
    const std::uint64_t first = options_.only_world.value_or(counters_.world_count);
    const std::uint64_t end = options_.only_world ? first + 1 : options_.world_count;
    std::uint64_t index = first;
    while (index < end && !is_over()) {
      const std::uint64_t block_end = std::min(end, (index / worlds_per_block + 1) * worlds_per_block);
      const Result<std::uint64_t> done = run_block(index, block_end);
      if (!done) return done.error();
      index += *done;
      if (index < block_end) break;
      if (index % worlds_per_block == 0 || index == end)
        if (const Status saved = save_progress(); !saved) return saved.error();
    }
    return SoakReport{std::move(counters_), seconds_since(start_), index - first, index >= end};
  }

 private:
  std::string progress_path() const { return options_.folder + "/progress.json"; }

  Status read_progress() {
    std::ifstream file(progress_path(), std::ios::binary);
    if (!file) return {};  // no earlier progress
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    Result<SoakCounters> read = parse_progress(text, identity_, progress_path());
    if (!read) return read.error();
    counters_ = *std::move(read);
    return {};
  }

  Status save_progress() const {
    if (options_.only_world) return {};
    Result<verifier::DataFile> file = verifier::DataFile::create(progress_path(), true);
    if (!file) return file.error();
    if (const Status written = file->write(print_progress(identity_, counters_)); !written) return written;
    return file->close();
  }

  /// No further world counts.
  bool is_stopped() const { return is_cancelled_ || counters_.failures.size() >= options_.failure_count_max; }

  /// No further world begins.
  bool is_over() const { return is_stopped() || (options_.time_s > 0 && seconds_since(start_) >= options_.time_s); }

  /// Returns the number of worlds done: the whole block, or the worlds before the soak ended. A world is added when all
  /// earlier worlds are done.
  Result<std::uint64_t> run_block(std::uint64_t begin, std::uint64_t end) {
    const std::vector<std::string> wanted = choices_to_measure(options_.worlds, counters_.choices);
    std::vector<WorldOutcome> outcomes(end - begin);
    std::uint64_t done = 0;
    std::mutex mutex;  // protects outcomes, done and the members
    const Status ran = run_jobs(outcomes.size(), options_.thread_count, [&](std::size_t i) {
      {
        const std::lock_guard lock(mutex);
        if (is_over()) return;
      }
      WorldOutcome outcome = run_world(begin + i, wanted);
      const std::lock_guard lock(mutex);
      outcomes[i] = std::move(outcome);
      for (; done < outcomes.size() && outcomes[done].is_done && !is_stopped(); ++done) {
        add(outcomes[done].counts);
        counters_.world_count = options_.only_world ? 1 : begin + done + 1;
        if (options_.progress && !options_.progress(counters_, seconds_since(start_))) is_cancelled_ = true;
      }
    });
    if (!ran) return ran.error();
    return done;
  }

  WorldOutcome run_world(std::uint64_t index, const std::vector<std::string>& wanted_choices) const {
    const RunningFile mark(options_, index);
    const std::uint64_t seed = world_seed(options_.seed, index);
    WorldSource::World world = options_.worlds.make(seed);
    OracleOptions oracle = options_.oracle;
    oracle.files.path = options_.folder + "/world_" + std::to_string(index) + ".ttr";
    const WorldResult result = examine(world.soak_case, seed, oracle);
    WorldOutcome outcome;
    outcome.is_done = true;
    SoakCounters& counts = outcome.counts;
    counts.tick_count = result.base.tick_count;
    counts.body_ticks = result.base.body_ticks;
    counts.ran_away_count = result.base.ran_away ? 1 : 0;
    counts.joints_failed_count = result.base.joints_failed ? 1 : 0;
    counts.run_counts = result.run_counts;
    counts.caches = result.base.caches;
    engine::add_counts(counts.caches, result.tally.caches);
    counts.while_hit = result.tally.while_hit;
    count_choices(options_.worlds, world, seed, result.base, wanted_choices, options_.oracle.make, counts);
    if (index < options_.known_world_count) {
      const CaseInputs inputs(world.soak_case);
      const PhysicsCounts physics = count_physics({world.soak_case, inputs, oracle.make}, result.base);
      for (std::size_t i = 0; i < physics_checks.size(); ++i)
        if (physics.broken[i]) ++counts.known[{physics.cause, std::string(physics_checks[i])}];
      ++(physics.is_judged ? counts.judged_count : counts.unjudged_count);
      for (const std::string& text : physics.texts)
        counts.physics_texts.push_back("world " + std::to_string(index) + ", " + physics.cause + ": " + text);
    }
    for (const Finding& finding : result.findings) {
      world.soak_case.tick_count = std::max(result.base.tick_count, finding.tick + 1);
      std::string folder = options_.folder + "/" + std::to_string(seed);
      if (!counts.failures.empty())
        folder += "_" + std::string(check_table[static_cast<std::size_t>(finding.variant.check)].name);
      const FailureOptions failure_options{std::move(folder), options_.shrink_time_s, oracle};
      FailedWorld failure = write_failure(world.soak_case, seed, finding, failure_options);
      failure.index = index;
      counts.failures.push_back(std::move(failure));
      if (counts.failures.size() == 2) break;  // further findings of a world most likely have the same cause
    }
    return outcome;
  }

  void add(const SoakCounters& counts) {
    counters_.tick_count += counts.tick_count;
    counters_.body_ticks += counts.body_ticks;
    counters_.judged_count += counts.judged_count;
    counters_.unjudged_count += counts.unjudged_count;
    counters_.physics_texts.insert(counters_.physics_texts.end(), counts.physics_texts.begin(),
                                   counts.physics_texts.end());
    counters_.ran_away_count += counts.ran_away_count;
    counters_.joints_failed_count += counts.joints_failed_count;
    for (std::size_t i = 0; i < check_table.size(); ++i) counters_.run_counts[i] += counts.run_counts[i];
    for (std::size_t i = 0; i < engine::cache_kind_count; ++i) {
      counters_.caches[i].hits += counts.caches[i].hits;
      counters_.caches[i].invalidations += counts.caches[i].invalidations;
      counters_.while_hit[i] += counts.while_hit[i];
    }
    for (const auto& [name, row] : counts.choices) {
      ChoiceCoverage& sum = counters_.choices[name];
      sum.active += row.active;
      sum.measured += row.measured;
      sum.effect += row.effect;
    }
    for (const auto& [names, count] : counts.pairs) counters_.pairs[names] += count;
    for (const auto& [names, count] : counts.known) counters_.known[names] += count;
    counters_.failures.insert(counters_.failures.end(), counts.failures.begin(), counts.failures.end());
  }

  const SoakOptions& options_;
  SoakIdentity identity_;
  Clock::time_point start_ = Clock::now();
  bool is_cancelled_ = false;
  SoakCounters counters_;
};

}  // namespace

std::uint64_t world_seed(std::uint64_t seed, std::uint64_t index) {
  return mix(seed, index);
}

Result<SoakReport> run_soak(const SoakOptions& options) {
  return Soak(options).run();
}

}  // namespace ticktrue::soak
