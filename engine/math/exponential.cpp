// Decay by series and doubling.
// SPDX-License-Identifier: MIT
#include "engine/math/exponential.h"

namespace ticktrue::engine {

Decay decay_over(double x) {
  if (!(x > 0)) return {1, 1};
  // Halve until the series converges fast, then double back:
  // mean(2x) = mean(x) (1 + exp(-x)) / 2, exp(-2x) = exp(-x)^2.
  int doublings = 0;
  while (x > 0.5 && doublings < 64) {
    x *= 0.5;
    ++doublings;
  }
  // mean(x) = 1 - x/2 (1 - x/3 (1 - x/4 (...))): 0.5^15 / 16! is below 1e-17.
  double mean = 1;
  for (int n = 15; n >= 2; --n) mean = 1 - x / n * mean;
  double factor = 1 - x * mean;
  for (; doublings > 0; --doublings) {
    mean = mean * (1 + factor) * 0.5;
    factor = factor * factor;
  }
  return {factor, mean};
}

}  // namespace ticktrue::engine
