// Decay over a time step from + - * / alone: the same bits on every platform.
// SPDX-License-Identifier: MIT
#pragma once

namespace ticktrue::engine {

struct Decay {
  double factor;  // exp(-x)
  double mean;    // (1 - exp(-x)) / x, the mean of exp(-x t) over t in 0..1; 1 for x = 0
};

/// Requires: x >= 0. Relative error below 1e-14 for x <= 100.
Decay decay_over(double x);

}  // namespace ticktrue::engine
