// Compares this build with another build on the same trace. Locates a difference by stage, column and bits.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "base/state/simulation.h"
#include "replay/trace_reader.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

struct AgainstOptions {
  std::string binary;              // of the other build: a path, or a name to search in PATH
  std::vector<std::string> words;  // that call the other build, if its path alone does not; `binary` is then its name
  double timeout_s = 600;
  const SimulationInfo* simulation = nullptr;
  std::size_t row_count_max = 64;
};

/// `here` is the report of this build in mode replay. The result is the report of the pair. match: both builds
/// reproduce the recorded bits. diverged: the first difference between the builds, with the other build as "expected";
/// if the builds agree with each other, the first difference from the recording. error: the other build could not be
/// run.
Report compare_builds(replay::TraceReader& reader, Report here, const AgainstOptions& options);

}  // namespace ticktrue::verifier
