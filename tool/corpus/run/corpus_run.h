// Verifies a list of traces against a store of verdicts: only what the store does not know is run.
// SPDX-License-Identifier: MIT
//
// Verified: a verdict is taken from the store only if it is a match of the same bytes, engine, libraries and options.
// Any other verdict is found again by a run. A long trace is cut into parts that any worker takes: its verdict is put
// together from the verdicts of all parts, and only if each is a match. Else a run from tick 0 decides.
// A program that verifies its own traces (CorpusOptions::program) is run for each trace. Its verdict is stored if the
// program ended by itself, and ran nothing but files that count; a trace of a program is not cut.
// Not verified: that the machine computes today as it did when the verdict was made; `recheck` runs a sample again.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tool/corpus/build_subject.h"
#include "tool/corpus/program_subject.h"
#include "tool/corpus/verify_trace.h"
#include "verifier/corpus/trace_list.h"
#include "verifier/store/verdict_store.h"

namespace ticktrue::tool {

enum class UnitSource : std::uint8_t {
  cached,        // from the store
  verified,      // by this run
  rechecked,     // in the store, and verified once more by this run
  other_worker,  // verified by another worker while this one ran
  partial,       // the parts of this shard are verified, others have the rest
  missing        // there is no verdict
};
inline constexpr std::array<std::string_view, 6> unit_source_names{"cached",       "verified", "rechecked",
                                                                   "other_worker", "partial",  "missing"};

struct CorpusUnit {
  std::string key;  // empty: the trace could not be read
  UnitSource source = UnitSource::missing;
  verifier::Report report;
  std::vector<Error> problems;        // with the store: the verdict stands, but others will not find it
  std::vector<std::string> warnings;  // damaged files of the store
};

struct CorpusOptions {
  verifier::VerifyMode mode = verifier::VerifyMode::replay;
  std::shared_ptr<const ProgramSubject> program;  // that verifies its own traces, in mode replay; null: the engine does
  unsigned thread_count = 1;
  bool claims = false;
  double lease_s = 60;
  double recheck = 0;                                              // share of the cached verdicts, 0..1
  std::optional<verifier::Shard> shard;                            // the units of this shard alone
  double part_s = 60;                                              // of work: a trace above it is cut into parts
  std::function<bool()> stops;                                     // asked before each unit; may be empty
  std::function<void(std::size_t done, std::size_t of)> progress;  // one thread at a time; may be empty
};

/// One unit for each file, in their order; of a shard: for each file that it has a part of.
/// `traces`: what the stat index is named by. Errors: unsupported, io.
Result<std::vector<CorpusUnit>> verify_corpus(const std::vector<std::string>& files, const std::string& traces,
                                              const verifier::VerdictStore& store, const CorpusOptions& options);

/// What the store knows of the files; nothing is run. A file without a verdict is an error of its report.
Result<std::vector<CorpusUnit>> look_up_corpus(const std::vector<std::string>& files, const std::string& traces,
                                               const verifier::VerdictStore& store, const CorpusOptions& options);

/// Seconds of work that this build has to do: of the files whose verdict the store does not have, learned or estimated.
/// A file that cannot be read costs nothing. Errors: unsupported, io.
Result<std::vector<double>> open_costs(const std::vector<std::string>& files, const std::string& traces,
                                       const verifier::VerdictStore& store, const CorpusOptions& options);

/// The worst of the reports, and 2 where the store had a problem.
int corpus_exit_code(const std::vector<CorpusUnit>& units, bool allow_truncated);

}  // namespace ticktrue::tool
