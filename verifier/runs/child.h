// Runs another program with limits, and reports how it ended.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "verifier/runs/child_end.h"

namespace ticktrue::verifier {

struct ChildLimits {
  double time_s = 600;                                 // wall time, after which the process group is killed
  std::size_t output_size_max = std::size_t{1} << 30;  // retained bytes of standard output, from its begin
  std::size_t message_size_max = 64u << 10;            // retained bytes of standard error, from its end
  std::uint64_t printed_size_max = UINT64_MAX;  // limit of both together, after which the process group is killed
};

struct ChildCommand {
  std::vector<std::string> argv;  // the program first: a path, or a name to search in PATH
  /// Environment variables to set, or to remove if they have no value. All others are inherited.
  std::vector<std::pair<std::string, std::optional<std::string>>> environment;
  /// "NAME=VALUE" each, in this order; replaces the inherited environment.
  std::optional<std::vector<std::string>> inherited;
  std::string cwd;  // empty: the folder of this process
  /// Called in the child before exec, with `prepare_with`. Only calls that are safe after fork are allowed.
  void (*prepare)(const void* with) = nullptr;
  const void* prepare_with = nullptr;
  ChildLimits limits;
};

struct ChildResult {
  ChildEnd end;
  bool finished = false;  // the program reported before its end that its work was done (completion.h)
  std::string output;     // standard output
  std::uint64_t output_dropped_size = 0;
  std::string message;  // standard error
  std::uint64_t message_dropped_size = 0;
};

/// Runs the program with empty standard input, as the leader of its own process group, and waits. When the program
/// ends, or a limit is reached, the rest of the group is killed. SIGINT, SIGTERM and SIGHUP are sent to the group
/// first, then to this process.
ChildResult run_child(const ChildCommand& command);

/// What went wrong: "did not end within 600 s", "was killed by signal 11 (Segmentation fault)", "printed 2000 bytes,
/// expected at most 1000". Empty: the program exited, with any status.
std::string child_failure(const ChildResult& result, const ChildLimits& limits);

}  // namespace ticktrue::verifier
