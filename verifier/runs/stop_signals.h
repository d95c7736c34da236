// Stop signals (Ctrl-C) while child processes run: forwarded to their process groups, then handled by this process.
// SPDX-License-Identifier: MIT
#pragma once

#include "verifier/runs/child_process.h"

#ifdef TICKTRUE_HAS_FORK

#include <csignal>

namespace ticktrue::verifier {

/// Blocks SIGINT, SIGTERM and SIGHUP during its lifetime.
class BlockedSignals {
 public:
  BlockedSignals();
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;
  ~BlockedSignals();

 private:
  sigset_t before_;
};

/// Forwards stop signals that this process does not ignore to the process group. Thread-safe.
void forward_stop_signals_to(pid_t group);

/// Ends the forwarding. After the last group, restores the earlier handlers. Returns the signal that arrived meanwhile,
/// which the caller must raise again; 0: none.
int end_forwarding_to(pid_t group);

/// Whether a signal was forwarded to a group that still runs.
bool stop_signal_pending();

/// In a child after fork: clears the groups and restores the previous handlers.
void reset_stop_signals();

}  // namespace ticktrue::verifier

#endif
