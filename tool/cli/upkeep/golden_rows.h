// The rows of a manifest of golden traces: their sessions, and whether a trace is what its row says.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "replay/recorder.h"
#include "tool/output/cli.h"
#include "tool/output/json_output.h"
#include "verifier/corpus/golden.h"
#include "verifier/report/report.h"
#include "verifier/runs/child_end.h"

namespace ticktrue::cli::golden {

using verifier::GoldenManifest;
using verifier::GoldenRow;

inline constexpr std::uint64_t size_default_max = 65536;  // bytes of a trace

struct GoldenCommand {
  std::string directory;
  std::string reason;
  std::uint64_t size_max = size_default_max;
  std::uint64_t jobs = 0;
  bool json = false;

  std::string path_of(const std::string& name) const;  // in the directory
  std::string manifest() const { return path_of(verifier::manifest_name); }
};

/// What was found of one golden trace.
struct GoldenOutcome {
  int code = exit_ok;
  bool changed = false;                         // update: recorded again
  std::vector<Error> errors;                    // what is wrong
  std::vector<verifier::EscapedChild> escaped;  // of the program
  std::string report;                           // of verify, where it does not match
  std::string hash;                             // as this build gives it
  std::uint64_t size = 0;                       // bytes
  std::string ticks;                            // update: those that changed
  std::string first;                            // update: the first difference as text
  bool was_there = false;                       // update: there was a trace to compare with

  void fail(int with, std::string what, std::string hint = "");
};

/// Path of a file of the manifest: as named, or next to or in the directory of the traces.
std::string find_file(const GoldenCommand& command, const std::string& word);
/// The same without the current directory. Nothing: there is no such file.
std::optional<std::string> find_beside(const GoldenCommand& command, const std::string& word);

/// Records the session of the row into `path`, over an older file. Errors: those of its scene, its inputs and of
/// replay::record.
Result<replay::RecordResult> record_row(const GoldenCommand& command, const GoldenRow& row, const std::string& path);

/// Verifies the trace `path` as the row says: here, or by its program. A report that is no match fails the row.
void verify_row(const GoldenRow& row, const std::string& path, Result<replay::TraceReader>& reader,
                GoldenOutcome& outcome);

/// The hash that the trace records for its last tick.
std::string recorded_hash(replay::TraceReader& reader);

/// Fails a trace that is larger than --size-max.
void check_size(const GoldenCommand& command, const GoldenRow& row, std::uint64_t size, GoldenOutcome& outcome);
/// The trace `path` is intact and matches, and recorded again as its row says it ends in the state the row says. A
/// trace of a program is not recorded again: its own last hash counts.
void check_trace(const GoldenCommand& command, const GoldenRow& row, const std::string& path, GoldenOutcome& outcome);

/// Errors: io, limit, invalid_input (also a manifest without a row, unless `may_be_empty`).
Result<GoldenManifest> read_manifest(const GoldenCommand& command, bool may_be_empty = false);
/// Over the older one, as a whole. Errors: io.
Status write_manifest(const GoldenCommand& command, const GoldenManifest& manifest);

void end_programs(const std::vector<GoldenOutcome>& outcomes);

/// `result`: "passed" and the like, of a row that did not fail.
Json row_json(const GoldenRow& row, const GoldenOutcome& outcome, const char* result);
/// The object without its rows. `failed` of `row_count` did.
Json golden_json(const GoldenCommand& command, const char* subcommand, std::size_t row_count, std::size_t failed);

/// DIR, --size-max, --json, and --jobs where rows are many.
void add_common(CLI::App& command, GoldenCommand& options, bool has_jobs);

/// `golden add`.
void add_golden_add(CLI::App& golden, CliContext& context);

}  // namespace ticktrue::cli::golden
