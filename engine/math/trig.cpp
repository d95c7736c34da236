// Sine, cosine and arc tangent from + - * / alone: the same bits on every platform.
// SPDX-License-Identifier: MIT
// Source: Cody and Waite, "Software Manual for the Elementary Functions", 1980 (reduction in parts of pi/2); Taylor
// series with exact rational coefficients.
#include "engine/math/trig.h"

#include <limits>

#include "engine/math/arc_tangent.h"

namespace ticktrue::engine {
namespace {

// pi/2 in three parts. The first two parts have 33 bits, so that their products with k < 2^20 are exact.
constexpr double half_pi_1 = 0x1.921fb544p+0;
constexpr double half_pi_2 = 0x1.0b4611a6p-34;
constexpr double half_pi_3 = 0x1.3198a2e037073p-69;
constexpr double two_over_pi = 0x1.45f306dc9c883p-1;
constexpr double two_pi = 0x1.921fb54442d18p+2;
constexpr double exactly_reduced_max = 1e6;  // rad; k stays below 2^20
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Remainder of angle >= 0 by the double nearest to 2 pi. Every subtraction is exact (the operands are within a factor
/// of two). The only error is that of two_pi itself, once per turn.
double remove_turns(double angle) {
  double turns = two_pi;
  while (turns <= angle * 0.5) turns *= 2;
  for (; turns >= two_pi; turns *= 0.5)
    if (angle >= turns) angle -= turns;
  return angle;
}

// Taylor series on |x| <= pi/4 (a little more after rounding k). The first omitted term is below 2^-58 of the sum.
double sin_series(double x) {
  const double z = x * x;
  double p = 1.0 / 355687428096000.0;
  p = p * z - 1.0 / 1307674368000.0;
  p = p * z + 1.0 / 6227020800.0;
  p = p * z - 1.0 / 39916800.0;
  p = p * z + 1.0 / 362880.0;
  p = p * z - 1.0 / 5040.0;
  p = p * z + 1.0 / 120.0;
  p = p * z - 1.0 / 6.0;
  return x + x * z * p;
}

double cos_series(double x) {
  const double z = x * x;
  double p = -1.0 / 6402373705728000.0;
  p = p * z + 1.0 / 20922789888000.0;
  p = p * z - 1.0 / 87178291200.0;
  p = p * z + 1.0 / 479001600.0;
  p = p * z - 1.0 / 3628800.0;
  p = p * z + 1.0 / 40320.0;
  p = p * z - 1.0 / 720.0;
  p = p * z + 1.0 / 24.0;
  return 1.0 - (0.5 * z - z * z * p);
}

}  // namespace

SinCos sin_cos(double angle) {
  // The magnitude is reduced, so that sin(-x) == -sin(x) and cos(-x) == cos(x) to the last bit.
  const bool negative = angle < 0;
  double x = negative ? -angle : angle;
  if (!(x <= std::numeric_limits<double>::max())) return {not_a_number, not_a_number};
  if (x == 0) return {angle, 1};  // keeps the sign of -0
  if (x > exactly_reduced_max) x = remove_turns(x);

  const int k = static_cast<int>(x * two_over_pi + 0.5);  // quarter turns, 0..636620
  const double r = ((x - k * half_pi_1) - k * half_pi_2) - k * half_pi_3;
  const double s = sin_series(r);
  const double c = cos_series(r);
  SinCos result{};
  switch (k & 3) {
    case 0:
      result = {s, c};
      break;
    case 1:
      result = {c, -s};
      break;
    case 2:
      result = {-s, -c};
      break;
    case 3:
      result = {-c, s};
      break;
  }
  if (negative) result.sin = -result.sin;
  return result;
}

SinCos pose_sin_cos(double angle) {
  SinCos result = sin_cos(angle);
  const double size = angle < 0 ? -angle : angle;
  const double rounding = std::numeric_limits<double>::epsilon() * (size > 1 ? size : 1);
  if (result.sin > -rounding && result.sin < rounding && angle != 0) result = {0, result.cos < 0 ? -1.0 : 1.0};
  if (result.cos > -rounding && result.cos < rounding) result = {result.sin < 0 ? -1.0 : 1.0, 0};
  return result;
}

double arc_tangent(double y, double x) {
  return arc_tangent_of(y, x);
}

}  // namespace ticktrue::engine
