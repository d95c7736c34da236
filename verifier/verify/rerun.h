// Repeats the run up to a mismatch. This separates a difference between builds from a random one, and finds the stage.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "verifier/verify/walk.h"

namespace ticktrue::verifier {

/// The result of a second run up to the end of the mismatching tick.
struct Rerun {
  bool done = false;                        // the run reached the tick of the mismatch
  bool same = false;                        // it ended in the same state after the same stages, bit for bit
  std::optional<std::uint64_t> differs_at;  // first tick known to differ between the two runs
  std::optional<Divergence> divergence;  // set if the second run differs from the recording earlier than the first run
  std::optional<Divergence> between;     // done and not same: the difference between the two runs
  std::optional<Divergence>
      located;  // set if no row here explains some differing cells: located with the rows of the previous tick
  std::string why_undone;  // not empty: the tick `differs_at` failed in the second run
};

/// Runs from `start` to the end of the tick of the mismatch. Moves `source`.
Rerun run_again(const WalkContext& context, TraceSource& source, const Start& start, const Mismatch& mismatch,
                Findings& findings, const std::function<void(std::uint64_t ticks_done)>& progress);

/// Sets the verdict on a mismatch after a second run. diverged: both runs here are the same; otherwise not
/// reproducible.
void judge_mismatch(const Mismatch& mismatch, const Rerun& rerun, Findings& findings);

/// Moves the source directly after the checkpoint of the start, or to its beginning. Copies the image of the checkpoint
/// if the start has none. False: the checkpoint is missing.
bool go_to_start(TraceSource& source, Start& start);

}  // namespace ticktrue::verifier
