// Verification of a trace by the program that recorded it: the tool runs the program, and its session compares.
// SPDX-License-Identifier: MIT
//
// Verified: the program ended by itself with status 0; its session finished the comparison; its report is about this
// trace (simulation, ticks, recorded hash of the last tick compared); a second run has the same finding. Not verified:
// that the program computed what it registered. A program that copies the trace can deceive.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "verifier/report/report.h"
#include "verifier/runs/child_end.h"

namespace ticktrue::verifier {

struct ProgramCommand {
  std::vector<std::string> words;  // of split_command
  std::string folder;              // for the files of the runs
  double time_s = 600;             // limit for a run
};

struct ProgramVerdict {
  Report report;
  /// In each run the program ended by itself and its session reported: the result repeats. False: a limit, a signal or
  /// a missing session ended a run, which the next run may not repeat.
  bool is_whole = false;
  /// Programs and shared libraries of the last run; see ProgramRun.
  std::optional<std::vector<std::string>> mapped;
  std::vector<EscapedChild> escaped;  // processes that left the program's process group
};

/// Thread-safe. `name`: name of the files of its runs, different for each call.
ProgramVerdict verify_by_program(const std::string& file, const ProgramCommand& command, const std::string& name);

}  // namespace ticktrue::verifier
