// Closed forms of motions and shapes, shared by the studies and the tests of the engine.
// SPDX-License-Identifier: MIT
// Source: Abramowitz and Stegun, 1964, 16.12 (elliptic functions by Landen's transformation).
#pragma once

#include <cmath>

#include "engine/math/trig.h"

namespace ticktrue::tool {

/// Jacobi's sn(u, k), by descending Landen transformation.
inline double jacobi_sn(double u, double k) {
  double a[12], c[12];
  a[0] = 1;
  double b = std::sqrt(1 - k * k);
  c[0] = k;
  int n = 0;
  for (; n < 11 && std::fabs(c[n]) > 1e-17; ++n) {
    a[n + 1] = (a[n] + b) / 2;
    c[n + 1] = (a[n] - b) / 2;
    b = std::sqrt(a[n] * b);
  }
  double phi = std::ldexp(a[n] * u, n);
  for (; n > 0; --n) phi = (phi + std::asin(c[n] / a[n] * std::sin(phi))) / 2;
  return std::sin(phi);
}

/// Angle of a pendulum, rad, released at `amplitude` rad. `w` is its frequency at small amplitudes, rad/s.
inline double pendulum_angle(double amplitude, double w, double time_s) {
  const double k = std::sin(amplitude / 2);
  double a = 1, b = std::sqrt(1 - k * k);
  for (int i = 0; i < 10; ++i) {
    const double mean = (a + b) / 2;
    b = std::sqrt(a * b);
    a = mean;
  }
  return 2 * std::asin(k * jacobi_sn(engine::pi / (2 * a) - w * time_s, k));
}

// 20 links of 0.6 m and 1 kg hang between pegs 10 m apart. Link i, counted from the middle, has the angle
// atan((i + 1/2) / H) from level. The span determines H.
inline constexpr double catenary_sag = 2.927214753;   // m, of the lowest point below the pegs
inline constexpr double catenary_pull = 7.819953406;  // H: the horizontal force, in weights of a link

}  // namespace ticktrue::tool
