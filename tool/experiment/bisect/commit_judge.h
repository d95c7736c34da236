// The verdict on one commit: from the store, or by building it and running its program on the traces.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "tool/experiment/reduce/failure.h"
#include "verifier/store/verdict_store.h"

namespace ticktrue::bisect {

/// Placeholder of the trace in JudgeOptions::program.
inline constexpr const char* trace_mark = "{}";

struct JudgeOptions {
  std::vector<std::string> traces;
  std::string build;               // a command for sh, run in the work tree; empty: no build
  std::string program;             // a command for sh, run in the work tree; `{}` is replaced by the trace
  std::vector<std::string> paths;  // paths in the repository that a verdict depends on; empty: the whole repository
  std::optional<std::string> identity;  // a command for sh whose output identifies the build
  double build_time_s = 3600;
  double verify_time_s = 600;
  std::string folder;  // for the files of runs
};

/// The result for one commit.
struct CommitVerdict {
  enum class Kind { good, bad, skipped };
  Kind kind = Kind::good;
  reduce::Failure failure;  // if bad
  std::string trace;        // if bad: the trace that failed
  std::string why;          // if skipped: the reason
  bool was_built = false;
  bool was_run = false;  // at least one trace was run; false: all verdicts came from the store
};

class CommitJudge {
 public:
  CommitJudge(const JudgeOptions& options, const verifier::VerdictStore& store) : options_(options), store_(store) {}

  /// Requires: the commit is checked out in `work_tree`. Errors: io; those of git.
  Result<CommitVerdict> judge(const std::string& work_tree);

 private:
  Result<std::string> identity_of_tree(const std::string& work_tree) const;
  Result<std::optional<CommitVerdict>> from_store(const std::string& identity) const;
  Status add_to_store(const std::string& identity, const std::string& trace,
                      const std::optional<reduce::Failure>& found);
  Result<CommitVerdict> build_and_run(const std::string& work_tree, const std::string& tree_identity);
  Result<CommitVerdict> run_traces(const std::string& work_tree, const std::vector<std::string>& identities,
                                   CommitVerdict verdict);
  /// Errors: io (the trace cannot be read, so no verdict on the trace is stored or used).
  Result<std::string> key_of(const std::string& identity, const std::string& trace) const;

  const JudgeOptions& options_;
  const verifier::VerdictStore& store_;
};

}  // namespace ticktrue::bisect
