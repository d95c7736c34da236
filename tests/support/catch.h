// Catch2 of either generation: 2.x (Debian 12) and 3.x.
// SPDX-License-Identifier: MIT
#pragma once

#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
using Catch::Approx;
#else
#include <catch2/catch.hpp>
#endif

/// Ends a test that cannot run here, and prints a warning, so that the test does not pass silently.
#define SKIP_UNLESS(condition, reason) \
  if (!(condition)) {                  \
    WARN("skipped: " reason);          \
    return;                            \
  }                                    \
  static_assert(true)
