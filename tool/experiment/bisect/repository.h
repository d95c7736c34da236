// A git repository, and a work tree of its own in which commits are built: the user's checkout stays as it is.
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

/// Runs git in a folder. Returns its output without the last line break. Errors: unsupported (git fails, with what it
/// said).
Result<std::string> git(const std::string& folder, const std::vector<std::string>& words);

/// Errors: usage (no such commit).
Result<Commit> find_commit(const std::string& folder, const std::string& name);

class WorkTree {
 public:
  /// A detached work tree of the repository that `folder` belongs to, at `path`. Errors: unsupported.
  static Result<WorkTree> make(const std::string& folder, const std::string& path, const std::string& commit);
  WorkTree(WorkTree&& other) noexcept;
  WorkTree& operator=(WorkTree&&) = delete;
  ~WorkTree();  // removes it, and what a bisection has left in it

  const std::string& path() const { return path_; }
  /// Errors: unsupported.
  Status check_out(const std::string& commit) const;

 private:
  WorkTree(std::string folder, std::string path);

  std::string folder_;
  std::string path_;
};

}  // namespace ticktrue::bisect
