// Keeps a plug-in's crash or hang away from the tool: the command runs in a child process that the tool watches.
// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "base/bytes.h"

namespace ticktrue::verifier {

/// What a plug-in can be busy with, for messages.
enum class PluginCall : std::uint32_t { none, open, create, columns, step, accept, resize, loaded, names, destroy };

/// The page that both processes see.
struct PluginWatch {
  std::atomic<std::uint64_t> sequence;  // rises at every beginning and end of a call
  std::atomic<std::uint64_t> tick;
  std::atomic<std::uint32_t> call;  // PluginCall
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
  std::string message;  // a crash or a hang, for people; empty where it ended by itself
};

/// Whether this system can do it (POSIX).
bool can_guard_plugins();

/// Goes on in a child process: there it returns nothing. In the parent it returns when the child has ended, or was
/// killed because one call took longer than `timeout_s`.
std::optional<GuardedEnd> run_guarded(const std::string& plugin_names, std::uint64_t timeout_s);

/// What a part of the work gave, or how its process ended.
struct GuardedPart {
  Bytes result;
  std::string message;  // as in GuardedEnd; empty: `result` is there
};

/// Inside of run_guarded: runs `part` in a process of its own, so that a crash or a hang ends that part alone.
/// Elsewhere it runs right here. Requires: this process has no other threads.
GuardedPart run_part(const std::function<Bytes()>& part);

}  // namespace ticktrue::verifier
