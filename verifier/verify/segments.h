// One trace on several threads: cut at its checkpoints, each stretch walked on its own, the seams compared.
// SPDX-License-Identifier: MIT
//
// A stretch ends by comparing its state with the checkpoint from which the next one began. So where all agree, the
// whole does: the state at each seam is the recorded one, whether it was carried there or loaded.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "verifier/verify/walk.h"

namespace ticktrue::verifier {

/// Where a trace can be cut, from one reading of it without simulating.
struct StretchPlan {
  std::vector<Start> marks;               // the first start, then every checkpoint behind it; without images
  std::vector<std::size_t> cuts;          // indices of the marks at which stretches begin; ascending, the first is 0
  std::optional<replay::TraceTail> tail;  // absent: not read to its end (options.to)
};

/// Reads `source` from its start. At most `stretch_count_max` stretches of about as many checkpoints each.
StretchPlan plan_stretches(const WalkContext& context, TraceSource& source, const Start& first,
                           std::size_t stretch_count_max);

struct StretchOptions {
  unsigned thread_count = 1;
  bool to_end = false;       // each from its start to the end of the trace
  bool counts = true;        // Stretch::counts
  bool counts_load = false;  // Stretch::counts_load
};

/// Walks the stretches; result i belongs to cut i. Once one has a finding, later ones are given up: their results say
/// WalkEnd::abandoned. `source` is one of the sources used; more come from context.options.reopen.
/// Errors: those of check_float_behaviour.
Result<std::vector<WalkResult>> walk_stretches(const WalkContext& context, TraceSource& source, const StretchPlan& plan,
                                               const StretchOptions& stretch_options);

/// Whether the stretch was walked to where it should end, without a finding.
bool is_clean(const WalkResult& result, bool is_last);

}  // namespace ticktrue::verifier
