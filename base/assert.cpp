// The report of a failed assertion.
// SPDX-License-Identifier: MIT
#include "base/assert.h"

#include <cstdio>
#include <cstdlib>

namespace ticktrue {

void assertion_failed(const char* expression, const char* file, int line) {
  std::fprintf(stderr, "ticktrue: internal error: %s:%d: assertion failed: %s\n", file, line, expression);
  std::abort();
}

}  // namespace ticktrue
