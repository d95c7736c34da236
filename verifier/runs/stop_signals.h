// Stop signals (Ctrl-C) while child processes run: forwarded to their process groups, then handled by this process.
// SPDX-License-Identifier: MIT
#pragma once

#include "verifier/runs/child_process.h"

#ifdef TICKTRUE_HAS_FORK

#include <csignal>

namespace ticktrue::verifier {

/// Blocks SIGINT, SIGTERM and SIGHUP for its lifetime.
class BlockedSignals {
 public:
  BlockedSignals();
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;
  ~BlockedSignals();

 private:
  sigset_t before_;
};

/// Forwards stop signals that this process does not ignore to the process group instead. From any thread.
void forward_stop_signals_to(pid_t group);

/// Ends the forwarding; after the last group the previous handlers are restored. Returns the signal that arrived
/// meanwhile, or 0: the caller raises it again.
int end_forwarding_to(pid_t group);

/// Whether a signal was forwarded to a group that still runs.
bool stop_signal_pending();

/// In a child after fork: clears the groups and restores the previous handlers.
void reset_stop_signals();

}  // namespace ticktrue::verifier

#endif
