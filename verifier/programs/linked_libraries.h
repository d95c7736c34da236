// The libraries of a program, as its dynamic linker lists them.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "base/result.h"

namespace ticktrue::verifier {

/// The paths in a dynamic linker's output for --list. Errors: io (a library that the linker did not find).
Result<std::vector<std::string>> listed_libraries(const std::string& program, const std::string& text);

}  // namespace ticktrue::verifier
