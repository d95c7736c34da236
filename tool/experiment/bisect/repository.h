// A git repository, and a separate work tree for building commits. The user's checkout does not change.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "base/result.h"

namespace ticktrue::bisect {

struct Commit {
  std::string hash;
  std::string subject;  // first line of the message
};

/// Runs git in a folder. Returns its output without the last line break. Errors: unsupported (git failed; the message
/// contains its output).
Result<std::string> git(const std::string& folder, const std::vector<std::string>& words);

/// Errors: usage (no such commit).
Result<Commit> find_commit(const std::string& folder, const std::string& name);

class WorkTree {
 public:
  /// Makes a detached work tree at `path`, of the repository that contains `folder`. Errors: unsupported.
  static Result<WorkTree> make(const std::string& folder, const std::string& path, const std::string& commit);
  WorkTree(WorkTree&& other) noexcept;
  WorkTree& operator=(WorkTree&&) = delete;
  ~WorkTree();  // removes the work tree and the state of an unfinished bisection

  const std::string& path() const { return path_; }
  /// Errors: unsupported.
  Status check_out(const std::string& commit) const;

 private:
  WorkTree(std::string folder, std::string path);

  std::string folder_;
  std::string path_;
};

}  // namespace ticktrue::bisect
