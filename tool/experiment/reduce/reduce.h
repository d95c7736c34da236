// The search for a small session that fails in the same way as a large one.
// SPDX-License-Identifier: MIT
//
// Order: what costs least and removes most comes first. The start moves to just before the failure; the bodies near the
// culprits are tried alone, few at first; then delta debugging (tool/experiment/shrink.h) over all that is left.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "tool/experiment/reduce/predicate.h"

namespace ticktrue::reduce {

struct ReduceOptions {
  EngineMaker make;               // for states between ticks and neighbours
  bool is_loose = false;          // another stage, table or column counts as the same failure
  bool any_method = false;        // solver, substeps and other settings of the method may become the defaults
  std::size_t run_count_max = 0;  // calls of the predicate; 0: no limit
  std::function<bool()> stops;    // asked before each run; true: the best so far is the result; may be empty
  std::function<void(std::size_t run_count, const SoakCase& smallest)> progress;  // may be empty
};

struct ReduceResult {
  SoakCase smallest;
  Failure first;               // of the session as it came
  Failure last;                // of `smallest`
  std::uint64_t cut_tick = 0;  // the tick of the session at whose begin `smallest` begins
  std::size_t run_count = 0;
  bool ended_early = false;  // a limit was reached, or it was asked to stop
};

/// The same arguments give the same result, unless it ends early. Errors: those of the predicate on the session;
/// usage (the session does not fail).
Result<ReduceResult> reduce(const SoakCase& session, Predicate& predicate, const ReduceOptions& options);

}  // namespace ticktrue::reduce
