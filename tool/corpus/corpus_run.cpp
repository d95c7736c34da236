// The units of a corpus: look up, claim, verify, store.
// SPDX-License-Identifier: MIT
#include "tool/corpus/corpus_run.h"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <optional>
#include <random>
#include <string_view>
#include <thread>
#include <utility>

#include "base/hash.h"
#include "base/parallel/jobs.h"
#include "base/row_kernels.h"
#include "engine/engine.h"
#include "tool/corpus/engine_digest.h"
#include "tool/session/simulations.h"
#include "verifier/plugins/plugin.h"
#include "verifier/store/claims.h"
#include "verifier/store/mapped_libraries.h"
#include "verifier/store/stat_index.h"

namespace ticktrue::verifier {
namespace {

constexpr double poll_s_max = 0.5;  // between two looks at units that other workers have
constexpr double polls_in_lease = 20;

/// How the bytes of a trace are named, and which file they were read from.
struct TraceIdentity {
  replay::FileFacts facts;
  std::string key;
};

Report refused_report(const std::string& file, const std::string& reason, const std::string& hint) {
  Report report;
  report.file = file;
  report.verdict = Verdict::error;
  report.reason = reason;
  report.hint = hint;
  return report;
}

Report changed_report(const std::string& file) {
  return refused_report(file, file + ": changed while it was read", "verify it again when nothing writes to it");
}

Report conflict_report(const std::string& file, const FoundVerdict& found) {
  Report report = refused_report(file, found.what, "find out which is right; then remove " + found.file);
  report.verdict = Verdict::not_reproducible;
  return report;
}

std::string_view mode_name(VerifyMode mode) {
  for (const VerifyModeInfo& info : verify_modes)
    if (info.mode == mode) return info.name;
  return "";
}

class CorpusRun {
 public:
  CorpusRun(const std::vector<std::string>& files, const std::string& traces, const VerdictStore& store,
            const CorpusOptions& options, BuildSubject build)
      : files_(files),
        store_(store),
        options_(options),
        build_(std::move(build)),
        index_(store.folder(), traces),
        claims_(store.folder(), options.lease_s),
        units_(files.size()),
        states_(files.size()),
        sample_seed_(std::random_device{}()) {}

  /// All units, in rounds: a unit that another worker has is looked at again in the next one.
  Result<std::vector<CorpusUnit>> verify() {
    if (options_.claims) claims_.start_heartbeat();
    std::vector<std::size_t> open = largest_first();
    const bool has_plugins = !plugin_simulations().empty();
    while (!open.empty() && !stops()) {
      const unsigned thread_count = has_plugins ? 1 : options_.thread_count;
      const Status status = run_jobs(open.size(), thread_count, [&](std::size_t job) { advance(open[job]); });
      if (!status) return status.error();
      open.erase(std::remove_if(open.begin(), open.end(), [&](std::size_t i) { return states_[i].is_done; }),
                 open.end());
      if (open.empty() || stops()) break;
      const double poll_s = std::min(poll_s_max, options_.lease_s / polls_in_lease);
      std::this_thread::sleep_for(std::chrono::duration<double>(poll_s));
    }
    for (const std::size_t i : open)
      units_[i].report = refused_report(files_[i], files_[i] + ": not verified: the command was stopped before",
                                        "start it again: what is done stays done");
    // A store that cannot keep its index is slower, no more.
    if (const Status saved = index_.save(); !saved && !units_.empty())
      units_.front().warnings.push_back(saved.error().message);
    return std::move(units_);
  }

  Result<std::vector<CorpusUnit>> look_up() {
    const Status status = run_jobs(files_.size(), options_.thread_count, [&](std::size_t i) { look_up_unit(i); });
    if (!status) return status.error();
    return std::move(units_);
  }

 private:
  struct State {
    bool is_done = false;
    std::optional<TraceIdentity> identity;
    bool was_looked_up = false;
    bool was_red = false;     // before this run: such a verdict is found again
    bool is_recheck = false;  // of a verdict that is a match
  };

  bool stops() const { return options_.stops && options_.stops(); }

  /// Else the last thread works on the largest while the others have nothing left.
  std::vector<std::size_t> largest_first() const {
    std::vector<std::pair<std::uint64_t, std::size_t>> sizes;
    for (std::size_t i = 0; i < files_.size(); ++i) {
      const std::optional<replay::FileFacts> facts = replay::file_facts(files_[i]);
      sizes.emplace_back(facts ? facts->size : 0, i);
    }
    std::stable_sort(sizes.begin(), sizes.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<std::size_t> order;
    for (const auto& [size, i] : sizes) order.push_back(i);
    return order;
  }

  void done(std::size_t i, UnitSource source, Report report) {
    units_[i].source = source;
    units_[i].report = std::move(report);
    units_[i].report.file = files_[i];
    states_[i].is_done = true;
    const std::lock_guard<std::mutex> guard(lock_);
    ++done_count_;
    if (options_.progress) options_.progress(done_count_);
  }

  /// Of the bytes as they are now; nothing where they cannot be read, with the report of the unit.
  bool identify(std::size_t i) {
    if (states_[i].identity) return true;
    const std::string& file = files_[i];
    const std::optional<replay::FileFacts> before = replay::file_facts(file);
    std::optional<Hash128> hash = before && !is_in_sample(i) ? index_.find(file, *before) : std::nullopt;
    if (!hash) {
      const Result<Hash128> read = file_hash(file);
      const std::optional<replay::FileFacts> after = replay::file_facts(file);
      if (!read || !before || !after) {
        done(i, UnitSource::missing,
             open_error_report(file, read ? Error{ErrorCode::io, file + ": cannot be read", ""} : read.error()));
        return false;
      }
      if (!is_unchanged(*before, *after)) {
        done(i, UnitSource::missing, changed_report(file));
        return false;
      }
      hash = *read;
      index_.note(file, *before, *hash);
    }
    const VerdictSubject subject{*hash, before->size, build_.engine, build_.libraries, build_.options};
    states_[i].identity = TraceIdentity{*before, verdict_key(subject)};
    units_[i].key = states_[i].identity->key;
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

  struct StoreWord {
    enum class Kind { nothing, green, red, conflict };
    Kind kind = Kind::nothing;
    Report report;
  };
  StoreWord ask_store(std::size_t i) {
    Result<FoundVerdict> found = store_.find(states_[i].identity->key);
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

  /// Whether the unit is done by what the store says of it. A verdict that is no match counts only if another worker
  /// stored it while this run goes on.
  bool is_done_by_store(std::size_t i) {
    State& state = states_[i];
    const bool is_first = !std::exchange(state.was_looked_up, true);
    StoreWord word = ask_store(i);
    if (word.kind == StoreWord::Kind::nothing) return false;
    if (is_first) {
      state.was_red = word.kind == StoreWord::Kind::red;
      state.is_recheck = word.kind == StoreWord::Kind::green && is_in_sample(i);
    }
    if (state.is_recheck || (word.kind == StoreWord::Kind::red && state.was_red)) return false;
    done(i, is_first ? UnitSource::cached : UnitSource::other_worker, std::move(word.report));
    return true;
  }

  /// One step of a unit: to its end, unless another worker has it.
  void advance(std::size_t i) {
    if (stops() || !identify(i) || is_done_by_store(i)) return;
    if (states_[i].is_recheck || !options_.claims) {
      run_unit(i, states_[i].is_recheck ? UnitSource::rechecked : UnitSource::verified);
      return;
    }
    const std::string& key = states_[i].identity->key;
    const Result<Claims::Answer> answer = claims_.try_claim(key);
    if (!answer) {
      done(i, UnitSource::missing, refused_report(files_[i], answer.error().message, answer.error().hint));
      return;
    }
    if (*answer == Claims::Answer::busy) return;
    // Between the look at the store and the claim its last owner may have ended.
    if (!is_done_by_store(i)) run_unit(i, UnitSource::verified);
    if (units_[i].source == UnitSource::missing || !units_[i].problems.empty())
      claims_.give_up(key);
    else
      claims_.finish(key);
  }

  PluginVerification verify_file(const std::string& file) {
    TraceVerification how;
    how.mode = options_.mode;
    if (!needs_plugin(file)) {
      Result<replay::TraceReader> reader = replay::TraceReader::open(file);
      if (!reader) return {open_error_report(file, reader.error()), true};
      return {verify_trace(*reader, file, how), true};
    }
    SharedCount later_libraries;  // counted where the plug-in maps more while it runs
    PluginVerification found = verify_by_plugin(file, mode_name(options_.mode), [&](SharedCount& compared) {
      how.compared = &compared;
      Result<replay::TraceReader> reader = replay::TraceReader::open(file);
      if (!reader) return open_error_report(file, reader.error());
      Report report = verify_trace(*reader, file, how);
      const auto libraries = mapped_libraries();
      if (!libraries || libraries_digest(*libraries) != build_.libraries) later_libraries.add_tick(0);
      return report;
    });
    if (later_libraries.ticks() > 0) {
      found.is_verdict = false;
      found.report.notes.push_back("not stored: the plug-in mapped more libraries while it ran");
    }
    return found;
  }

  void run_unit(std::size_t i, UnitSource source) {
    const std::string& file = files_[i];
    const TraceIdentity& identity = *states_[i].identity;
    const auto start = std::chrono::steady_clock::now();
    PluginVerification found = verify_file(file);
    found.report.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const std::optional<replay::FileFacts> after = replay::file_facts(file);
    if (!after || !is_unchanged(identity.facts, *after)) {
      done(i, UnitSource::missing, changed_report(file));
      return;
    }
    if (found.report.verdict == Verdict::error || !found.is_verdict) {
      done(i, source, std::move(found.report));
      return;
    }
    Result<FoundVerdict> stored = store_.add(identity.key, found.report);
    if (!stored) {
      units_[i].problems.push_back(stored.error());
      done(i, source, std::move(found.report));
      return;
    }
    if (stored->kind == FoundVerdict::Kind::conflict)
      done(i, source, conflict_report(file, *stored));
    else
      done(i, source, std::move(found.report));
  }

  void look_up_unit(std::size_t i) {
    if (!identify(i)) return;
    StoreWord word = ask_store(i);
    if (word.kind != StoreWord::Kind::nothing) {
      done(i, UnitSource::cached, std::move(word.report));
      return;
    }
    done(i, UnitSource::missing,
         refused_report(
             files_[i], files_[i] + ": found no verdict of this build in " + store_.folder().path() + ", expected one",
             "ticktrue corpus verify " + shell_word(files_[i]) + " --cache " + shell_word(store_.folder().path())));
  }

  const std::vector<std::string>& files_;
  const VerdictStore& store_;
  const CorpusOptions& options_;
  BuildSubject build_;
  StatIndex index_;
  Claims claims_;
  std::vector<CorpusUnit> units_;
  std::vector<State> states_;
  std::uint64_t sample_seed_;
  std::mutex lock_;
  std::size_t done_count_ = 0;
};

}  // namespace

Result<BuildSubject> build_subject(VerifyMode mode) {
  const std::optional<Hash128> engine = engine_digest();
  if (!engine)
    return Error{ErrorCode::unsupported, "this build does not know what it is made of: found no digest of the engine",
                 "build natively with Ninja; or use the command verify, which needs no store"};
  const Result<std::vector<MappedLibrary>> libraries = mapped_libraries();
  if (!libraries) return libraries.error();
  BuildSubject subject;
  subject.engine = *engine;
  subject.libraries = libraries_digest(*libraries);
  // What is chosen at run time and is to change no bit: a verdict is that of the code that ran.
  subject.options = "mode " + std::string(mode_name(mode)) + ", kernels " +
                    std::string(engine::info_of(engine::instruction_sets, engine::instruction_set_in_use()).name) +
                    ", rows " + std::to_string(all_row_kernels().size()) + ", checks " +
                    (engine_options_of_environment().check_caches ? "caches" : "nothing");
  return subject;
}

Result<std::vector<CorpusUnit>> verify_corpus(const std::vector<std::string>& files, const std::string& traces,
                                              const VerdictStore& store, const CorpusOptions& options) {
  Result<BuildSubject> build = build_subject(options.mode);
  if (!build) return build.error();
  return CorpusRun(files, traces, store, options, std::move(*build)).verify();
}

Result<std::vector<CorpusUnit>> look_up_corpus(const std::vector<std::string>& files, const std::string& traces,
                                               const VerdictStore& store, const CorpusOptions& options) {
  Result<BuildSubject> build = build_subject(options.mode);
  if (!build) return build.error();
  return CorpusRun(files, traces, store, options, std::move(*build)).look_up();
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
