// Sine, cosine and arc tangent from + - * / and sqrt alone: the same bits on every platform.
// SPDX-License-Identifier: MIT
#pragma once

namespace ticktrue::engine {

struct SinCos {
  double sin;
  double cos;
};

/// Sine and cosine of an angle in rad, |angle| <= 1e6; error at most 2 ulp of 1. Larger angles are reduced less exactly
/// the larger they are; non-finite angles give NaN.
SinCos sin_cos(double angle);

/// As sin_cos, for the pose of a body: a component below the rounding of the angle is zero. A body rotated by a quarter
/// turn (which no double represents exactly) then stands exactly upright. A remainder of 6e-17 would make subnormal
/// numbers in the solver, which some processors compute seven times more slowly.
SinCos pose_sin_cos(double angle);

/// Angle of (x, y) in rad, -pi..pi; 0 for (0, 0). Error at most 4 ulp.
double arc_tangent(double y, double x);

inline constexpr double pi = 3.14159265358979323846;

}  // namespace ticktrue::engine
