// Runs the tool in a process of its own and measures it: what damage_check and forged_check share.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace ticktrue::damage {

inline constexpr double cpu_max_s = 2;
inline constexpr int wall_max_s = 300;  // other work may keep the processor; a run that waits for something ends here
inline constexpr int sanitizer_exit_code = 99;

/// Prints `PROGRAM: error: MESSAGE` and ends with exit code 2.
[[noreturn]] void fail(const std::string& message);
/// Makes findings of sanitizers end with sanitizer_exit_code.
void set_sanitizer_options();

struct Outcome {
  int exit_code = -1;  // -1: killed by a signal
  int signal = 0;
  double cpu_s = 0;
  double memory_mb = 0;  // resident at most

  bool is_hang() const;
  bool is_crash() const { return !is_hang() && (signal != 0 || exit_code == sanitizer_exit_code); }
};
/// Without standard input and output.
Outcome run_tool(const std::vector<std::string>& words);

}  // namespace ticktrue::damage
