// The keys of two scenes that differ.
// SPDX-License-Identifier: MIT
#pragma once

#include "verifier/compare/setup_difference.h"

namespace ticktrue::tool {

/// The differing keys of the scenes in two setups, such as `bodies.1.shapes.0.friction`, with both values as JSON. A
/// key that a scene leaves out has its default. None: a setup is not a scene, or no key differs.
verifier::SetupKeys scene_differences(const replay::TraceSetup& a, const replay::TraceSetup& b);

}  // namespace ticktrue::tool
