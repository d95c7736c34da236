// Process isolation for plug-ins: the command runs in a child process that the parent watches.
// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "verifier/runs/child_end.h"

namespace ticktrue::verifier {

/// The call that a plug-in is in, for messages.
enum class PluginCall : std::uint32_t {
  none,
  open,
  create,
  columns,
  step,
  accept,
  resize,
  loaded,
  names,
  destroy,
  save,
  load,
  elements
};

/// Memory shared by both processes.
struct PluginWatch {
  std::atomic<std::uint64_t> sequence;  // incremented at every beginning and end of a call
  std::atomic<std::uint64_t> tick;      // of the last call that began
  std::atomic<std::uint32_t> last;      // PluginCall: that one
  std::atomic<std::uint32_t> call;      // PluginCall that runs
  std::atomic<std::uint32_t> finished;  // 1: the tool's own work is done
  std::atomic<std::int32_t> exit_code;  // of finished
};

/// Tells the parent process that a call is running. Without a parent that watches it does nothing.
class WatchedCall {
 public:
  explicit WatchedCall(PluginCall call, std::uint64_t tick = 0);
  ~WatchedCall();
  WatchedCall(const WatchedCall&) = delete;
  WatchedCall& operator=(const WatchedCall&) = delete;
};

/// How the child process ended.
struct IsolatedEnd {
  int exit_code = 0;
  std::string message;                    // what the plug-in did wrong; empty if it did nothing wrong
  std::uint64_t dropped_output_size = 0;  // bytes that the plug-in printed beyond the limit
  std::vector<EscapedChild> escaped;
  int stop_signal = 0;  // the stop signal that ended the child and is meant for this process; 0: none
};

/// Whether this system supports isolation (POSIX).
bool can_isolate_plugins();

/// Forks. In the child it returns nothing. In the parent it returns when the child has ended, or was killed because one
/// call took longer than `timeout_s`. An exit of the child without finish_isolated is attributed to the plug-in.
/// Standard output of the child is a pipe to the parent, which copies up to 64 KiB of it to standard error. The tool
/// itself writes to isolated_output().
std::optional<IsolatedEnd> run_isolated(const std::string& plugin_names, std::uint64_t timeout_s);

/// In the child of run_isolated: the original standard output. Null if that was not open for writing.
std::FILE* isolated_output();

/// In the child of run_isolated: the command is done and ends with this exit code. Elsewhere it does nothing.
void finish_isolated(int exit_code);

/// Ends this process by the signal, as if it had never been caught.
[[noreturn]] void end_by_signal(int signal);

/// The result of a part of the work, or the reason why its process ended.
struct IsolatedPart {
  Bytes result;
  std::string message;  // as in IsolatedEnd; empty: `result` is there
};

/// Inside run_isolated: runs `part` in a separate process, so that a crash or a hang ends only that part. Elsewhere
/// it runs `part` in this process. `meanwhile` (may be empty) is called every 10 ms or so while this process waits.
/// Requires: this process has no other threads.
IsolatedPart run_part(const std::function<Bytes()>& part, const std::function<void()>& meanwhile = {});

}  // namespace ticktrue::verifier
