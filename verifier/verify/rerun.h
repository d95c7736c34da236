// Repeats the run up to a mismatch: separates a difference between builds from a random one, and finds the stage.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "verifier/verify/walk.h"

namespace ticktrue::verifier {

/// The result of a second run up to the end of the mismatching tick.
struct Rerun {
  bool done = false;                        // it reached the tick of the mismatch
  bool same = false;                        // and ended in the same state by the same stages, bit for bit
  std::optional<std::uint64_t> differs_at;  // first tick known to differ between the two runs
  std::optional<Divergence> divergence;     // set if the second run differs from the recording earlier than the first
  std::optional<Divergence> between;        // done, not same: what differs between the two runs
  std::optional<Divergence>
      located;             // set if cells differ that no row here explains: located with the rows of the previous tick
  std::string why_undone;  // not empty: the second run could not do the tick `differs_at`
};

/// Runs from `start` to the end of the tick of the mismatch. Moves `source`.
Rerun run_again(const WalkContext& context, TraceSource& source, const Start& start, const Mismatch& mismatch,
                Findings& findings, const std::function<void(std::uint64_t ticks_done)>& progress);

/// The verdict on a mismatch, from a second run: diverged where both runs here are the same, else not reproducible.
void judge_mismatch(const Mismatch& mismatch, const Rerun& rerun, Findings& findings);

/// Puts the source just behind the checkpoint of the start, or to its beginning; takes the image of the checkpoint
/// where the start has none yet. False: there is no such checkpoint (any more).
bool go_to_start(TraceSource& source, Start& start);

}  // namespace ticktrue::verifier
