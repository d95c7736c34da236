// What a dynamic linker says of the libraries of a program.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "base/result.h"

namespace ticktrue::verifier {

/// The paths in what a dynamic linker prints for --list. Errors: io (a library that it did not find).
Result<std::vector<std::string>> listed_libraries(const std::string& program, const std::string& text);

}  // namespace ticktrue::verifier
