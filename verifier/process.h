// Runs another program with a time limit and takes what it prints.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace ticktrue::verifier {

struct ProcessLimits {
  double time_s = 600;
  std::size_t output_size_max = std::size_t{1}
                                << 30;  // bytes of standard output; of standard error the last 64 KiB count
};

struct ProcessResult {
  enum class End { exited, killed_by_signal, timed_out, too_much_output, not_started };
  End end = End::not_started;
  int code = 0;         // exit code, or the signal
  std::string output;   // standard output
  std::string message;  // standard error; not_started: why
};

/// Runs `words` (the program first: a path, or a name to be found in PATH) with empty standard input and waits. When a
/// limit is reached the program and what it started in its process group are killed.
ProcessResult run_process(std::vector<std::string> words, const ProcessLimits& limits);

/// What went wrong, for people: "did not end within 600 s", "was killed by signal 11 (Segmentation fault)"; empty for
/// a program that exited.
std::string process_failure(const ProcessResult& result, const ProcessLimits& limits);

}  // namespace ticktrue::verifier
