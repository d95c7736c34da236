// Keeps what a plug-in does to its process away from the tool: the command runs in a child process, watched.
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

/// What a plug-in can be busy with, for messages.
enum class PluginCall : std::uint32_t { none, open, create, columns, step, accept, resize, loaded, names, destroy };

/// The page that both processes see.
struct PluginWatch {
  std::atomic<std::uint64_t> sequence;  // rises at every beginning and end of a call
  std::atomic<std::uint64_t> tick;      // of the last call that began
  std::atomic<std::uint32_t> last;      // PluginCall: that one
  std::atomic<std::uint32_t> call;      // PluginCall that runs
  std::atomic<std::uint32_t> finished;  // 1: the tool's own work is done
  std::atomic<std::int32_t> exit_code;  // of finished
};

/// Notes for the watching process that a call runs. Without a watching process it does nothing.
class WatchedCall {
 public:
  explicit WatchedCall(PluginCall call, std::uint64_t tick = 0);
  ~WatchedCall();
  WatchedCall(const WatchedCall&) = delete;
  WatchedCall& operator=(const WatchedCall&) = delete;
};

/// How the child process ended.
struct GuardedEnd {
  int exit_code = 0;
  std::string message;                    // why that is the plug-in's fault, for people; empty where it is not
  std::uint64_t dropped_output_size = 0;  // bytes that the plug-in printed beyond the limit
  std::vector<EscapedChild> escaped;
  int stop_signal = 0;  // it was ended by this signal, which was for this process; 0: it was not
};

/// Whether this system can do it (POSIX).
bool can_guard_plugins();

/// Goes on in a child process: there it returns nothing. In the parent it returns when the child has ended, or was
/// killed because one call took longer than `timeout_s`. An exit of the child without finish_guarded is the plug-in's.
/// In the child standard output is a pipe to the parent, which shows it on standard error up to 64 KiB: the tool's own
/// goes to guarded_output().
std::optional<GuardedEnd> run_guarded(const std::string& plugin_names, std::uint64_t timeout_s);

/// In the child of run_guarded: what was standard output before. Null where that was not open for writing.
std::FILE* guarded_output();

/// In the child of run_guarded: the command is done and ends with this exit code. Elsewhere it does nothing.
void finish_guarded(int exit_code);

/// Ends this process by the signal, as if it had never been caught.
[[noreturn]] void end_by_signal(int signal);

/// What a part of the work gave, or how its process ended.
struct GuardedPart {
  Bytes result;
  std::string message;  // as in GuardedEnd; empty: `result` is there
};

/// Inside of run_guarded: runs `part` in a process of its own, so that a crash or a hang ends that part alone.
/// Elsewhere it runs right here. Requires: this process has no other threads.
GuardedPart run_part(const std::function<Bytes()>& part);

}  // namespace ticktrue::verifier
