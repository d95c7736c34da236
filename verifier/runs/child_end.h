// How a child process ended, and what it left running.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace ticktrue::verifier {

/// A process that a child started and that left the child's process group (setsid): it still runs.
struct EscapedChild {
  long id = 0;
  std::string name;  // printable, at most 64 bytes
};

struct ChildEnd {
  /// `stopped`: killed because the waiting process asked for it.
  enum class How { exited, killed_by_signal, timed_out, stopped, not_started };
  How how = How::not_started;
  int exit_status = 0;  // of exited
  int signal = 0;       // of killed_by_signal
  double wall_s = 0;
  int stop_signal = 0;                // what asked this process to stop meanwhile (Ctrl-C: SIGINT); 0: nothing
  std::vector<EscapedChild> escaped;  // Linux only: elsewhere always empty
  std::string failure;                // of not_started: why
};

/// "process 4711 (sleep)", or several; empty for none.
std::string escaped_text(const std::vector<EscapedChild>& escaped);

/// Kills those that still run. Requires: no run is under way, whose processes could be among them.
void end_escaped(const std::vector<EscapedChild>& escaped);

}  // namespace ticktrue::verifier
