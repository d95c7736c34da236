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

/// What stands for the trace in JudgeOptions::program.
inline constexpr const char* trace_mark = "{}";

struct JudgeOptions {
  std::vector<std::string> traces;
  std::string build;                    // a command for sh, run in the work tree; empty: nothing is built
  std::string program;                  // a command for sh, run there, `{}` standing for the trace
  std::vector<std::string> paths;       // of the repository: what a verdict depends on; empty: all of it
  std::optional<std::string> identity;  // a command for sh whose output names what was built
  double build_time_s = 3600;
  double verify_time_s = 600;
  std::string folder;  // for the files of runs
};

/// What was found out about a commit.
struct CommitVerdict {
  enum class Kind { good, bad, skipped };
  Kind kind = Kind::good;
  reduce::Failure failure;  // of bad
  std::string trace;        // of bad: on which
  std::string why;          // of skipped
  bool was_built = false;
  bool was_run = false;  // at least one trace; else all verdicts were stored
};

class CommitJudge {
 public:
  CommitJudge(const JudgeOptions& options, const verifier::VerdictStore& store) : options_(options), store_(store) {}

  /// The commit is checked out in `work_tree`. Errors: io; those of git.
  Result<CommitVerdict> judge(const std::string& work_tree);

 private:
  Result<std::string> identity_of_tree(const std::string& work_tree) const;
  Result<std::optional<CommitVerdict>> from_store(const std::string& identity) const;
  Status add_to_store(const std::string& identity, const std::string& trace,
                      const std::optional<reduce::Failure>& found);
  Result<CommitVerdict> build_and_run(const std::string& work_tree, const std::string& tree_identity);
  Result<CommitVerdict> run_traces(const std::string& work_tree, const std::vector<std::string>& identities,
                                   CommitVerdict verdict);
  /// Errors: io (the trace cannot be read: no verdict of it is stored or believed).
  Result<std::string> key_of(const std::string& identity, const std::string& trace) const;

  const JudgeOptions& options_;
  const verifier::VerdictStore& store_;
};

}  // namespace ticktrue::bisect
