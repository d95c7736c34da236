// Runs two simulations of one setup with the same inputs and compares them after every tick.
// SPDX-License-Identifier: MIT
#pragma once

#include "verifier/verify/walk.h"

namespace ticktrue::verifier {

/// Walks `source` from its start. Uses only dt and inputs of its records.
WalkResult walk_twice(const WalkContext& context, TraceSource& source, const Start& start);

}  // namespace ticktrue::verifier
