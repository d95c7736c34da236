// TICKTRUE_ASSERT: a broken invariant of our own code stops the program, in every build.
// SPDX-License-Identifier: MIT
#pragma once

namespace ticktrue {

/// Prints the expression and its place to stderr and aborts.
[[noreturn]] void assertion_failed(const char* expression, const char* file, int line);

}  // namespace ticktrue

#define TICKTRUE_ASSERT(expression) \
  ((expression) ? static_cast<void>(0) : ::ticktrue::assertion_failed(#expression, __FILE__, __LINE__))
