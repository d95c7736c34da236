// A stress case of one's own: a scene, what is measured of it, and between what that must stay, in a JSON file.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "tool/study/stress/stress.h"

namespace ticktrue::verifier {

/// The cases of a JSON file (docs/study.md, *Stress cases of one's own*): one, or one for each value that it varies.
/// Errors: io, limit, usage (with the path in the JSON); those of parse_scene, scene_with and Expression::parse.
Result<std::vector<StressCase>> read_stress_file(const std::string& path);

/// A file to begin with: a stack under a load that varies.
extern const char* const example_stress;

}  // namespace ticktrue::verifier
