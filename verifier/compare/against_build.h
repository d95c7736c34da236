// Compares this build with another one on the same trace; locates a difference by stage, column and bits.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "base/state/simulation.h"
#include "replay/trace_reader.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

struct AgainstOptions {
  std::string binary;              // of the other build: a path, or a name to be found in PATH
  std::vector<std::string> words;  // that call it, where the path alone does not; `binary` is its name then
  double timeout_s = 600;
  const SimulationInfo* simulation = nullptr;
  std::size_t row_count_max = 64;
};

/// `here` is the report of this build in mode replay. The result is the report of the pair: match if both builds give
/// the recorded bits; diverged with the first difference between them, "expected" being the other build, or, where they
/// agree with each other, between both and the recording. Verdict::error: the other build could not be run.
Report compare_builds(replay::TraceReader& reader, Report here, const AgainstOptions& options);

}  // namespace ticktrue::verifier
