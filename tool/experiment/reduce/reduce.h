// The search for a small session that fails in the same way as a large session.
// SPDX-License-Identifier: MIT
//
// Cheap steps that remove most come first. The start moves to just before the failure. The affected bodies are tried
// alone with few neighbours, then with more. Delta debugging (tool/experiment/shrink.h) then reduces the rest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "tool/experiment/reduce/predicate.h"

namespace ticktrue::reduce {

struct ReduceOptions {
  EngineMaker make;               // for states between ticks and for neighbours
  bool is_loose = false;          // a different stage, table or column counts as the same failure
  bool any_method = false;        // solver, substeps and other method settings may become defaults
  std::size_t run_count_max = 0;  // calls of the predicate; 0: no limit
  std::function<bool()> stops;    // called before each run; true: the best session so far is the result; may be empty
  std::function<void(std::size_t run_count, const SoakCase& smallest)> progress;  // may be empty
};

struct ReduceResult {
  SoakCase smallest;
  Failure first;               // failure of the original session
  Failure last;                // failure of `smallest`
  std::uint64_t cut_tick = 0;  // `smallest` begins at the start of this tick of the session
  std::size_t run_count = 0;
  bool ended_early = false;  // a limit was reached, or `stops` returned true
};

/// Equal arguments give an equal result, unless the search ends early. Errors: those of the predicate on the session;
/// usage (the session does not fail).
Result<ReduceResult> reduce(const SoakCase& session, Predicate& predicate, const ReduceOptions& options);

}  // namespace ticktrue::reduce
