// Git, run as a program.
// SPDX-License-Identifier: MIT
#include "tool/experiment/bisect/repository.h"

#include <utility>

#include "verifier/runs/child.h"

namespace ticktrue::bisect {

Result<std::string> git(const std::string& folder, const std::vector<std::string>& words) {
  verifier::ChildCommand command;
  command.argv = {"git", "-C", folder};
  command.argv.insert(command.argv.end(), words.begin(), words.end());
  const verifier::ChildResult result = verifier::run_child(command);
  std::string failed = child_failure(result, command.limits);
  if (failed.empty() && result.end.exit_status != 0) failed = result.message.substr(0, result.message.find('\n'));
  if (!failed.empty() || result.end.exit_status != 0)
    return Error{ErrorCode::unsupported, "git " + words.front() + ": " + failed, ""};
  std::string output = result.output;
  while (!output.empty() && output.back() == '\n') output.pop_back();
  return output;
}

Result<Commit> find_commit(const std::string& folder, const std::string& name) {
  const auto shown = git(folder, {"log", "-1", "--format=%H %s", "--end-of-options", name, "--"});
  if (!shown)
    return Error{ErrorCode::usage, "bisect: found no commit \"" + name + "\": " + shown.error().message,
                 "give commits of the repository of --repository (default: the working folder)"};
  const std::size_t space = shown->find(' ');
  return Commit{shown->substr(0, space), space == std::string::npos ? "" : shown->substr(space + 1)};
}

Result<WorkTree> WorkTree::make(const std::string& folder, const std::string& path, const std::string& commit) {
  const auto added = git(folder, {"worktree", "add", "--detach", "--force", path, commit});
  if (!added) return added.error();
  return WorkTree(folder, path);
}

WorkTree::WorkTree(std::string folder, std::string path) : folder_(std::move(folder)), path_(std::move(path)) {}

WorkTree::WorkTree(WorkTree&& other) noexcept
    : folder_(std::move(other.folder_)), path_(std::exchange(other.path_, "")) {}

WorkTree::~WorkTree() {
  if (path_.empty()) return;
  static_cast<void>(git(path_, {"bisect", "reset", "HEAD"}).has_value());  // fails if no bisection has begun
  static_cast<void>(git(folder_, {"worktree", "remove", "--force", path_}).has_value());
}

Status WorkTree::check_out(const std::string& commit) const {
  const auto done = git(path_, {"checkout", "--quiet", "--force", "--detach", commit});
  if (!done) return done.error();
  return {};
}

}  // namespace ticktrue::bisect
