// A user's verification problem in a JSON file: a scene, the observed values, and the expected values.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "base/result.h"
#include "tool/study/problems.h"

namespace ticktrue::tool {

/// Reads a problem from a JSON file (docs/study.md, *Problems of one's own*). Paths in the file are relative to the
/// folder of the file. Errors: io, limit, usage (with the path in the JSON); those of parse_scene and
/// Expression::parse.
Result<Problem> read_problem(const std::string& path);

/// An example file to start from: a box that slides to rest.
extern const char* const example_problem;

}  // namespace ticktrue::tool
