// The first commit whose program no longer runs a trace as recorded.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "tool/experiment/bisect/commit_judge.h"
#include "tool/experiment/bisect/repository.h"

namespace ticktrue::bisect {

struct JudgedCommit {
  Commit commit;
  CommitVerdict verdict;
};

struct BisectReport {
  std::vector<JudgedCommit> judged;  // in the order in which they were judged; good and bad first
  std::vector<Commit> suspects;      // the first bad commit alone, or all that may be it where some were skipped
};

struct BisectOptions {
  JudgeOptions judge;
  std::string repository;   // a folder in it
  std::string work_folder;  // where the work tree is made; not in the repository
  std::string good;
  std::string bad;
  std::function<bool(const JudgedCommit& judged)> progress;  // false stops; may be empty
};

/// Errors: usage (no such commit; the good one fails, the bad one does not); unsupported (git; it was stopped); io.
Result<BisectReport> run_bisect(const BisectOptions& options, const verifier::VerdictStore& store);

std::string bisect_text(const BisectReport& report);
/// Schema ticktrue.bisect/1.
std::string bisect_json(const BisectReport& report, const BisectOptions& options);

}  // namespace ticktrue::bisect
