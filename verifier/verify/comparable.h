// Whether a trace can be compared with this build: simulation, physics version, schema, stages, floating point.
// SPDX-License-Identifier: MIT
#pragma once

#include "verifier/verify/walk.h"

namespace ticktrue::verifier {

/// Whether the trace can be compared with this build. If not, `findings` states why. Mode `twice` compares the build
/// with itself: a difference from the recording build is then a warning.
bool check_comparable(const WalkContext& context, Findings& findings);

}  // namespace ticktrue::verifier
