// Ctrl-C and its like, while child processes run: first to their groups, then to this process.
// SPDX-License-Identifier: MIT
#pragma once

#include "verifier/runs/child_process.h"

#ifdef TICKTRUE_HAS_FORK

#include <csignal>

namespace ticktrue::verifier {

/// SIGINT, SIGTERM and SIGHUP wait while it exists.
class HeldSignals {
 public:
  HeldSignals();
  HeldSignals(const HeldSignals&) = delete;
  HeldSignals& operator=(const HeldSignals&) = delete;
  ~HeldSignals();

 private:
  sigset_t before_;
};

/// From here on the stop signals that this process does not ignore go to the process group instead. From any thread.
void pass_stop_signals_to(pid_t group);

/// Ends that; with the last group the handlers from before are back. Gives the signal that came meanwhile, or 0: it is
/// for the caller to raise it again.
int keep_stop_signals_from(pid_t group);

/// Whether one came while groups are left that it went to.
bool stop_signal_pending();

/// In a child after fork: the groups are not its own, and the handlers are those from before.
void forget_stop_signals();

}  // namespace ticktrue::verifier

#endif
