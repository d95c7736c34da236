// Runs the tool in a separate process and measures it, for damage_check and forged_check.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace ticktrue::damage {

inline constexpr double cpu_max_s = 2;
inline constexpr int wall_max_s = 300;  // other work may delay the run; a run that blocks ends here
inline constexpr int sanitizer_exit_code = 99;

/// Prints `PROGRAM: error: MESSAGE` and exits with code 2.
[[noreturn]] void fail(const std::string& message);
/// Makes sanitizers exit with sanitizer_exit_code.
void set_sanitizer_options();

struct Outcome {
  int exit_code = -1;  // -1: killed by a signal
  int signal = 0;
  double cpu_s = 0;
  double memory_mb = 0;  // peak resident memory

  bool is_hang() const;
  bool is_crash() const { return !is_hang() && (signal != 0 || exit_code == sanitizer_exit_code); }
};
/// Runs the tool without standard input and output.
Outcome run_tool(const std::vector<std::string>& words);

}  // namespace ticktrue::damage
