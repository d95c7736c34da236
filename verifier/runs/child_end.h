// How a child process ended, and which processes it left running.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace ticktrue::verifier {

/// A running process that a child started, and that left the child's process group (setsid).
struct EscapedChild {
  long id = 0;
  std::string name;  // printable, at most 64 bytes
};

struct ChildEnd {
  /// `stopped`: killed at the request of the waiting process.
  enum class How { exited, killed_by_signal, timed_out, stopped, not_started };
  How how = How::not_started;
  int exit_status = 0;  // for exited
  int signal = 0;       // for killed_by_signal
  double wall_s = 0;
  int stop_signal = 0;                // signal that asked this process to stop meanwhile (Ctrl-C: SIGINT); 0: none
  std::vector<EscapedChild> escaped;  // always empty except on Linux
  std::string failure;                // for not_started: the reason
};

/// "process 4711 (sleep)", or several; empty for none.
std::string escaped_text(const std::vector<EscapedChild>& escaped);

/// Kills the processes that still run. Requires: no run is in progress, because its processes could be in the list.
void end_escaped(const std::vector<EscapedChild>& escaped);

}  // namespace ticktrue::verifier
