// A user's stress case in a JSON file: a scene, a measure, and the bounds of the measured value.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "tool/study/stress/stress.h"

namespace ticktrue::tool {

/// Reads the cases of a JSON file (docs/study.md, *Stress cases of one's own*): one case, or one for each varied value.
/// Errors: io, limit, usage (with the path in the JSON); those of parse_scene, scene_with and Expression::parse.
Result<std::vector<StressCase>> read_stress_file(const std::string& path);

/// An example file to start from: a stack below a load that varies.
extern const char* const example_stress;

}  // namespace ticktrue::tool
