// Verification of a trace by the program that recorded it: the tool runs the program, whose session compares.
// SPDX-License-Identifier: MIT
//
// Verified: that the program ended by itself with status 0, that its session finished the comparison, that its report
// is of this trace (simulation, ticks, recorded hash of the last tick compared); of a finding, that a second run has
// the same one. Not verified: that the program computed what it registered. One that copies the trace can deceive.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "verifier/report/report.h"
#include "verifier/runs/child_end.h"

namespace ticktrue::verifier {

struct ProgramCommand {
  std::vector<std::string> words;  // of split_command
  std::string folder;              // for the files of runs
  double time_s = 600;             // of a run
};

struct ProgramVerdict {
  Report report;
  /// The program ended by itself in each run, and its session reported: the same happens again. False: what a limit, a
  /// signal or a missing session left, which the next run may not repeat.
  bool is_whole = false;
  /// Programs and shared libraries of the last run; see ProgramRun.
  std::optional<std::vector<std::string>> mapped;
  std::vector<EscapedChild> escaped;  // processes that left the program's process group
};

/// From any thread. `name`: of the files of its runs; another one for each call.
ProgramVerdict verify_by_program(const std::string& file, const ProgramCommand& command, const std::string& name);

}  // namespace ticktrue::verifier
