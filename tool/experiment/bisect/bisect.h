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
  std::vector<Commit> suspects;      // the first bad commit; or all candidates, if some of them were skipped
};

struct BisectOptions {
  JudgeOptions judge;
  std::string repository;   // any folder in the repository
  std::string work_folder;  // folder for the work tree; not in the repository
  std::string good;
  std::string bad;
  std::function<bool(const JudgedCommit& judged)> progress;  // false stops; may be empty
};

/// Errors: usage (no such commit, the good commit fails, the bad commit does not fail); unsupported (git failed, or
/// `progress` stopped the search); io.
Result<BisectReport> run_bisect(const BisectOptions& options, const verifier::VerdictStore& store);

std::string bisect_text(const BisectReport& report);
/// Schema ticktrue.bisect/1.
std::string bisect_json(const BisectReport& report, const BisectOptions& options);

}  // namespace ticktrue::bisect
