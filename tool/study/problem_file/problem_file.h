// A problem of one's own in a JSON file: a scene, the observed values, and the expected values.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "base/result.h"
#include "tool/study/problems.h"

namespace ticktrue::verifier {

/// Reads the problem of a JSON file (docs/study.md, *Problems of one's own*). Files that it names stand beside it.
/// Errors: io, limit, usage (with the path in the JSON); those of parse_scene and Expression::parse.
Result<Problem> read_problem(const std::string& path);

/// A file to begin with: a box that slides to rest.
extern const char* const example_problem;

}  // namespace ticktrue::verifier
