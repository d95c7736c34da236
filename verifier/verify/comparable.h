// Whether a trace can be compared with this build: simulation, physics version, schema, stages, floating point.
// SPDX-License-Identifier: MIT
#pragma once

#include "verifier/verify/walk.h"

namespace ticktrue::verifier {

/// Whether the trace can be compared with this build. If not, `findings` has the reason. Mode `twice` compares the
/// build with itself: there a difference from the recording build is a warning.
bool check_comparable(const WalkContext& context, Findings& findings);

}  // namespace ticktrue::verifier
