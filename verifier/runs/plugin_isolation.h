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

/// The current call of a plug-in, for messages.
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
  std::atomic<std::uint64_t> sequence;  // incremented at each begin and end of a call
  std::atomic<std::uint64_t> tick;      // of the last call that began
  std::atomic<std::uint32_t> last;      // PluginCall: the last call that began
  std::atomic<std::uint32_t> call;      // PluginCall: the running call
  std::atomic<std::uint32_t> finished;  // 1: the tool's own work is done
  std::atomic<std::int32_t> exit_code;  // valid if finished
};

/// Reports a running call to the parent process. Without a watching parent it does nothing.
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
  std::string message;                    // the fault of the plug-in; empty: none
  std::uint64_t dropped_output_size = 0;  // bytes of the plug-in's output above the limit
  std::vector<EscapedChild> escaped;
  int stop_signal = 0;  // a stop signal that ended the child and is for this process; 0: none
};

/// Whether this system supports isolation (POSIX).
bool can_isolate_plugins();

/// Forks. In the child it returns nothing. In the parent it returns when the child has ended, or was killed because one
/// call took longer than `timeout_s`. If the child exits without finish_isolated, the exit is attributed to the
/// plug-in.
/// Standard output of the child is a pipe to the parent, which copies up to 64 KiB of it to standard error. The tool
/// itself writes to isolated_output().
std::optional<IsolatedEnd> run_isolated(const std::string& plugin_names, std::uint64_t timeout_s);

/// In the child of run_isolated: the original standard output. Null: it was not open for writing.
std::FILE* isolated_output();

/// In the child of run_isolated: reports that the command is done and will exit with this code. Elsewhere it does
/// nothing.
void finish_isolated(int exit_code);

/// Ends this process by the signal, with its default action.
[[noreturn]] void end_by_signal(int signal);

/// The result of a part of the work, or why its process ended.
struct IsolatedPart {
  Bytes result;
  std::string message;  // as in IsolatedEnd; empty: `result` is valid
};

/// Inside run_isolated: runs `part` in a separate process, so that a crash or a hang ends only this part. Elsewhere:
/// runs `part` in this process. `meanwhile` (may be empty) is called about every 10 ms while this process waits.
/// Requires: this process has no other threads.
IsolatedPart run_part(const std::function<Bytes()>& part, const std::function<void()>& meanwhile = {});

}  // namespace ticktrue::verifier
