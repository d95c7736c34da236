// Vectors and rotations of the plane.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/math/real.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Vec2 {
  Real x = 0;
  Real y = 0;
};

inline Vec2 operator+(Vec2 a, Vec2 b) {
  return {a.x + b.x, a.y + b.y};
}
inline Vec2 operator-(Vec2 a, Vec2 b) {
  return {a.x - b.x, a.y - b.y};
}
inline Vec2 operator-(Vec2 a) {
  return {-a.x, -a.y};
}
inline Vec2 operator*(Real s, Vec2 a) {
  return {s * a.x, s * a.y};
}
inline Real dot(Vec2 a, Vec2 b) {
  return a.x * b.x + a.y * b.y;
}
inline Real cross(Vec2 a, Vec2 b) {
  return a.x * b.y - a.y * b.x;
}
inline Vec2 cross(Real s, Vec2 a) {
  return {-s * a.y, s * a.x};
}
/// A quarter turn clockwise: the outward normal of a counter-clockwise edge, the tangent of a normal.
inline Vec2 right_turn(Vec2 a) {
  return {a.y, -a.x};
}
inline Real length_squared(Vec2 a) {
  return a.x * a.x + a.y * a.y;
}
inline Real length(Vec2 a) {
  return square_root(length_squared(a));
}

inline Real smaller(Real a, Real b) {
  return a < b ? a : b;
}
inline Real larger(Real a, Real b) {
  return a > b ? a : b;
}
inline Real absolute(Real a) {
  return a < 0 ? -a : a;
}
/// Equals `absolute`, but gives 0 for -0. The function has no branch, since some signs are hard to predict.
inline Real magnitude(Real a) {
  return larger(a, -a);
}

/// The stored form of a value: -0 becomes 0, every other value keeps its bits (IEEE 754-2019, 6.3: -0 + 0 is 0). The
/// sign of a zero sum depends on the order of its terms, and so on batches and threads.
inline Real stored(Real a) {
  return a + Real(0);
}
inline Vec2 stored(Vec2 a) {
  return {stored(a.x), stored(a.y)};
}

/// A rotation by its cosine and sine.
struct Rotation {
  Real c = 1;
  Real s = 0;
};
inline Rotation stored(Rotation a) {
  return {stored(a.c), stored(a.s)};
}

inline Vec2 rotate(Rotation q, Vec2 v) {
  return {q.c * v.x - q.s * v.y, q.s * v.x + q.c * v.y};
}
inline Vec2 rotate_back(Rotation q, Vec2 v) {
  return {q.c * v.x + q.s * v.y, q.c * v.y - q.s * v.x};
}
inline Rotation operator*(Rotation a, Rotation b) {
  return {a.c * b.c - a.s * b.s, a.s * b.c + a.c * b.s};
}
/// The rotation from a to b: b = a * between(a, b).
inline Rotation between(Rotation a, Rotation b) {
  return {a.c * b.c + a.s * b.s, a.c * b.s - a.s * b.c};
}
inline Rotation normalized(Rotation q) {
  const Real scale = Real(1) / square_root(q.c * q.c + q.s * q.s);
  return {scale * q.c, scale * q.s};
}

/// Rotation by an angle in rad: exact to the last bits for |angle| <= pi / 4, with a relative error of 1e-6 up to 1e4.
/// Taylor series: the first omitted term is below half a unit in the last place at pi / 4.
inline Rotation rotation_by(Real angle) {
  // Quarter turns are removed first. Adding and subtracting 1.5 * 2^(digits - 1) rounds to an integer.
  constexpr Real round = sizeof(Real) == 4 ? Real(0x1.8p23) : Real(0x1.8p52);
  // Beyond the limit an angle has no meaning: a unit in its last place is a quarter of a radian.
  constexpr Real limit = sizeof(Real) == 4 ? Real(0x1.8p21) : Real(0x1.8p50);
  angle = angle > limit ? limit : (angle < -limit ? -limit : angle);
  const Real quarters = angle * Real(0.63661977236758134308);  // 2 / pi
  const Real quarter_turns = (quarters + round) - round;
  // pi / 2 in two parts. The first part has few enough digits that quarter_turns * part is exact for less than 2^11
  // quarter turns.
  constexpr Real part_1 = sizeof(Real) == 4 ? Real(1.5703125) : Real(0x1.921fb54p0);
  constexpr Real part_2 = sizeof(Real) == 4 ? Real(4.83826794896619e-4) : Real(0x1.10b4611a62633p-30);
  const Real x = (angle - quarter_turns * part_1) - quarter_turns * part_2;
  const Real z = x * x;
  Real sine, cosine;
  if constexpr (sizeof(Real) == 4) {
    sine = x + x * z * (Real(-1.0 / 6) + z * (Real(1.0 / 120) + z * (Real(-1.0 / 5040) + z * Real(1.0 / 362880))));
    cosine = Real(1) + z * (Real(-0.5) + z * (Real(1.0 / 24) + z * (Real(-1.0 / 720) + z * Real(1.0 / 40320))));
  } else {
    sine =
        x + x * z *
                (Real(-1.0 / 6) +
                 z * (Real(1.0 / 120) + z * (Real(-1.0 / 5040) +
                                             z * (Real(1.0 / 362880) + z * (Real(-1.0 / 39916800) +
                                                                            z * (Real(1.0 / 6227020800.0) +
                                                                                 z * Real(-1.0 / 1307674368000.0)))))));
    cosine = Real(1) +
             z * (Real(-0.5) +
                  z * (Real(1.0 / 24) +
                       z * (Real(-1.0 / 720) +
                            z * (Real(1.0 / 40320) +
                                 z * (Real(-1.0 / 3628800) +
                                      z * (Real(1.0 / 479001600.0) +
                                           z * (Real(-1.0 / 87178291200.0) + z * Real(1.0 / 20922789888000.0))))))));
  }
  const auto quadrant = static_cast<std::int64_t>(quarter_turns == quarter_turns ? quarter_turns : Real(0)) &
                        3;  // a NaN stays in sine, cosine
  if (quadrant == 0) return {cosine, sine};
  if (quadrant == 1) return {-sine, cosine};
  if (quadrant == 2) return {-cosine, -sine};
  return {sine, -cosine};
}

struct Box {  // axis-aligned, m
  Vec2 lower;
  Vec2 upper;
};
inline bool overlaps(const Box& a, const Box& b) {
  return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x && a.lower.y <= b.upper.y && b.lower.y <= a.upper.y;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
