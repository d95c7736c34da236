// The functions of ticktrue/math.h as a table, with the ranges of test arguments: C and C++.
// SPDX-License-Identifier: MIT
#pragma once

#include "include/ticktrue/math.h"

typedef struct MathFunction {
  const char* name;
  int argument_count;
  double (*f64)(double x, double y);
  float (*f32)(float x, float y);
  double low, high;      // of x
  double low_y, high_y;  // of y
} MathFunction;

#define MATH_ONE(name)                           \
  static double name##_f64(double x, double y) { \
    (void)y;                                     \
    return ticktrue_##name(x);                   \
  }                                              \
  static float name##_f32(float x, float y) {    \
    (void)y;                                     \
    return ticktrue_##name##f(x);                \
  }
#define MATH_TWO(name)                           \
  static double name##_f64(double x, double y) { \
    return ticktrue_##name(x, y);                \
  }                                              \
  static float name##_f32(float x, float y) {    \
    return ticktrue_##name##f(x, y);             \
  }
MATH_ONE(sin)
MATH_ONE(cos)
MATH_ONE(tan)
MATH_ONE(asin)
MATH_ONE(acos)
MATH_ONE(atan)
MATH_ONE(exp)
MATH_ONE(log)
MATH_ONE(sqrt)
MATH_ONE(floor)
MATH_ONE(ceil)
MATH_ONE(trunc)
MATH_ONE(round)
MATH_ONE(rint)
MATH_TWO(atan2)
MATH_TWO(pow)
MATH_TWO(hypot)
MATH_TWO(fmod)
MATH_TWO(remainder)
#undef MATH_ONE
#undef MATH_TWO

#define MATH_ROW(name, count, low, high, low_y, high_y) \
  { #name, count, name##_f64, name##_f32, low, high, low_y, high_y }
static const MathFunction math_functions[] = {
    MATH_ROW(sin, 1, -100, 100, 0, 0),     MATH_ROW(cos, 1, -100, 100, 0, 0),
    MATH_ROW(tan, 1, -100, 100, 0, 0),     MATH_ROW(asin, 1, -1, 1, 0, 0),
    MATH_ROW(acos, 1, -1, 1, 0, 0),        MATH_ROW(atan, 1, -10, 10, 0, 0),
    MATH_ROW(atan2, 2, -10, 10, -10, 10),  MATH_ROW(exp, 1, -100, 100, 0, 0),
    MATH_ROW(log, 1, 0, 10, 0, 0),         MATH_ROW(pow, 2, 0, 10, -20, 20),
    MATH_ROW(hypot, 2, -10, 10, -10, 10),  MATH_ROW(sqrt, 1, 0, 100, 0, 0),
    MATH_ROW(fmod, 2, -1000, 1000, 0, 10), MATH_ROW(remainder, 2, -1000, 1000, 0, 10),
    MATH_ROW(floor, 1, -100, 100, 0, 0),   MATH_ROW(ceil, 1, -100, 100, 0, 0),
    MATH_ROW(trunc, 1, -100, 100, 0, 0),   MATH_ROW(round, 1, -100, 100, 0, 0),
    MATH_ROW(rint, 1, -100, 100, 0, 0)};
#undef MATH_ROW

// The next argument. Three of four are between low and high; the others have any bits, including NaN and subnormals.
static inline double next_f64(ticktrue_random* random, double low, double high, uint32_t i) {
  uint64_t bits = ticktrue_random_u64(random);
  if (i % 4 == 3) return ttm_from_bits(bits);
  return low + ttm_mul(high - low, ttm_mul((double)(int64_t)(bits >> 11), 1.1102230246251565e-16));
}
static inline float next_f32(ticktrue_random* random, double low, double high, uint32_t i) {
  uint32_t bits = ticktrue_random_u32(random);
  if (i % 4 == 3) return ttm_from_bits_f32(bits);
  return (float)(low + ttm_mul(high - low, ttm_mul((double)bits, 2.3283064365386963e-10)));
}
