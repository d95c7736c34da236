// What a trace can be compared with at all: simulation, physics version, schema, stages, floating point.
// SPDX-License-Identifier: MIT
#pragma once

#include "verifier/verify/walk.h"

namespace ticktrue::verifier {

/// Whether this build is one that the trace can be compared with. If not, `findings` says why. Mode `twice` compares
/// the build with itself: there a difference from the recording build is a warning.
bool check_comparable(const WalkContext& context, Findings& findings);

}  // namespace ticktrue::verifier
