// One run of a program that verifies a trace in its own session: how it ended, and the results of the session.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "verifier/runs/child.h"

namespace ticktrue::verifier {

struct ProgramRun {
  ChildResult child;
  std::string failure;  // one line: why the run is incomplete; empty: the program exited, with any status
  std::string results;  // lines of JSON, one for each finished session
  bool has_session = false;
  /// The programs and shared libraries of the processes whose sessions ended. Nothing: no session listed them, or a
  /// list is incomplete.
  std::optional<std::vector<std::string>> mapped;
  std::uint64_t position = 0;  // as in shim/page.h: 2 t + 1 in tick t, 2 t + 2 after it, 0 before the first tick
};

/// Runs the words with a result file and a page in `folder`, under `name`; both are removed afterwards. The program is
/// killed after `time_s`, or if it prints more than 1 GiB. Errors: io (the files), limit (the result).
Result<ProgramRun> run_program(const std::vector<std::string>& words, const std::string& folder,
                               const std::string& name, double time_s);

/// ", in tick 33", or ", before its first tick"; empty: no session was opened.
std::string position_text(const ProgramRun& run);

/// The last line on standard error, shortened; empty: none.
std::string last_line(const ProgramRun& run);

}  // namespace ticktrue::verifier
