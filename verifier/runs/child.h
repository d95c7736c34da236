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
  double time_s = 600;                                 // wall time; then the process group is killed
  std::size_t output_size_max = std::size_t{1} << 30;  // first bytes of standard output that are retained
  std::size_t message_size_max = 64u << 10;            // last bytes of standard error that are retained
  std::uint64_t printed_size_max = UINT64_MAX;         // bytes of both; then the process group is killed
};

struct ChildCommand {
  std::vector<std::string> argv;  // the program first: a path, or a name to be found in PATH
  /// Environment variables to set, or without a value to remove; all others are inherited.
  std::vector<std::pair<std::string, std::optional<std::string>>> environment;
  /// "NAME=VALUE" each, in this order, instead of the inherited ones.
  std::optional<std::vector<std::string>> inherited;
  std::string cwd;  // empty: that of this process
  /// Called in the child before exec, with `prepare_with`: only calls that are safe after fork.
  void (*prepare)(const void* with) = nullptr;
  const void* prepare_with = nullptr;
  ChildLimits limits;
};

struct ChildResult {
  ChildEnd end;
  bool finished = false;  // the program said that its work was done (finished_mark.h) before it ended
  std::string output;     // standard output
  std::uint64_t output_dropped_size = 0;
  std::string message;  // standard error
  std::uint64_t message_dropped_size = 0;
};

/// Runs the program with empty standard input, as the leader of its own process group, and waits. When it has ended, or
/// a limit is reached, all that is left of the group is killed. SIGINT, SIGTERM and SIGHUP go to the group first and
/// then to this process.
ChildResult run_child(const ChildCommand& command);

/// What went wrong, for people: "did not end within 600 s", "was killed by signal 11 (Segmentation fault)", "printed
/// 2000 bytes, expected at most 1000"; empty for a program that exited, with whatever status.
std::string child_failure(const ChildResult& result, const ChildLimits& limits);

}  // namespace ticktrue::verifier
