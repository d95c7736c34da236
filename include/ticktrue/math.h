// Functions of libm, random numbers and sorting with the same bits everywhere, for programs in C11 and C++14.
// SPDX-License-Identifier: MIT
//
// One file, no library: copy it, or install ticktrue. No function of libm is called.
//
//   float  ticktrue_sinf(float)   double ticktrue_sin(double)    and in C++   ticktrue::math::sin(x)
//
// The same arguments give the same bits with every compiler, optimisation, instruction set and byte order; with and
// without fused multiply-add, LTO and -march=native. docs/math.md explains how this is checked, and has examples.
// Each product is computed by `ttm_mul`, which ends in an empty asm statement: the compiler must round the product
// before it is added. This file needs no flag. Your own arithmetic needs -ffp-contract=off.
//
// The largest errors in ulp (units in the last place; 0.5 is a correctly rounded result):
//
//           sin   cos   tan   asin  acos  atan  atan2 exp   log   pow   hypot sqrt
//   double  0.82  0.82  0.95  0.70  0.65  0.65  0.65  0.51  0.62  0.53  0.51  0.5
//   float   0.501 for all functions except sqrt (0.5)
//
// These bounds are the largest measured errors, rounded up. Doubles were compared with MPFR. Floats with one argument
// were tested for all arguments (tests/math/accuracy.cpp). fmod, remainder, floor, ceil, trunc, round and rint are
// exact.
//
// Domains are complete: arguments of sine, cosine and tangent are reduced exactly up to the largest float and double.
// Special values are those of C11, annex F, with two differences. A NaN is always the positive quiet NaN without
// payload. errno and the exception flags are undefined. Rounding to nearest and denormals are assumed.
#pragma once

#include <float.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#if !defined(TICKTRUE_MATH_ALLOW_FAST_MATH) &&                                                        \
    (defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) ||             \
     defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || defined(__NO_SIGNED_ZEROS__) || \
     defined(_M_FP_FAST))
#error "ticktrue/math.h: fast-math changes results: build without -ffast-math, or define TICKTRUE_MATH_ALLOW_FAST_MATH"
#endif
// 16 is equal to 0 except for _Float16: g++ defines it with -march=native if the CPU has AVX512-FP16.
#if defined(__FLT_EVAL_METHOD__) && !defined(TICKTRUE_MATH_ALLOW_EXCESS_PRECISION)
#if __FLT_EVAL_METHOD__ != 0 && __FLT_EVAL_METHOD__ != 16
#error "ticktrue/math.h: floats are evaluated in another precision: on i386 build with -msse2 -mfpmath=sse"
#endif
#endif
#ifdef __cplusplus
static_assert(FLT_RADIX == 2 && FLT_MANT_DIG == 24 && DBL_MANT_DIG == 53, "floats must be IEEE 754 binary32, binary64");
#else
_Static_assert(FLT_RADIX == 2 && FLT_MANT_DIG == 24 && DBL_MANT_DIG == 53,
               "floats must be IEEE 754 binary32, binary64");
#endif

#if defined(__x86_64__) || defined(_M_X64) || (defined(__i386__) && defined(__SSE2__)) || \
    (defined(_M_IX86_FP) && _M_IX86_FP >= 2)
#include <emmintrin.h>
#define TTM_SSE2 1
#endif

// Forces the compiler to have `x` as a rounded double here. One register, no instruction.
#if defined(__GNUC__) || defined(__clang__)
#if defined(TTM_SSE2) && defined(__AVX512F__)
#define TTM_ROUNDED(x) __asm__("" : "+v"(x))
#elif defined(TTM_SSE2)
#define TTM_ROUNDED(x) __asm__("" : "+x"(x))
#elif defined(__aarch64__)
#define TTM_ROUNDED(x) __asm__("" : "+w"(x))
#elif defined(__arm__) && defined(__ARM_FP) && (__ARM_FP & 8)
#define TTM_ROUNDED(x) __asm__("" : "+w"(x))
#elif defined(__riscv_flen) && __riscv_flen >= 64
#define TTM_ROUNDED(x) __asm__("" : "+f"(x))
#elif defined(__s390x__)
#define TTM_ROUNDED(x) __asm__("" : "+f"(x))
#elif defined(__powerpc64__)
#define TTM_ROUNDED(x) __asm__("" : "+d"(x))
#elif defined(__wasm__)
#define TTM_ROUNDED(x) __asm__("" : "+r"(x))
#else
#define TTM_ROUNDED(x) __asm__("" : "+m"(x))
#endif
#define TTM_HIDDEN(integer) __asm__("" : "+r"(integer))
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#define TTM_ROUNDED(x) ((void)0)
#define TTM_HIDDEN(integer) ((void)0)
#else
#error "ticktrue/math.h: unknown compiler: found neither GCC, Clang nor MSVC"
#endif

#if defined(__GNUC__) || defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wfloat-equal"
#ifdef __cplusplus
#pragma GCC diagnostic ignored "-Wold-style-cast"
#ifndef __clang__
#pragma GCC diagnostic ignored "-Wuseless-cast"
#endif
#endif
#endif

// --- bits and exact sums --------------------------------------------------------------------------------------------

typedef struct ttm_pair {
  double hi, lo;  // value hi + lo, |lo| at most about one ulp of hi
} ttm_pair;

static inline uint64_t ttm_bits(double x) {
  uint64_t bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}
static inline double ttm_from_bits(uint64_t bits) {
  double x;
  memcpy(&x, &bits, sizeof x);
  return x;
}
static inline uint32_t ttm_bits_f32(float x) {
  uint32_t bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}
static inline float ttm_from_bits_f32(uint32_t bits) {
  float x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

#define TTM_SIGN 0x8000000000000000u
#define TTM_INFINITY_BITS 0x7ff0000000000000u
#define TTM_ONE_BITS 0x3ff0000000000000u

// Hidden from the optimiser: clang 19 turns "x >= 0 ? root(x) : NaN" into the root of a negative x, a NaN of any sign.
static inline double ttm_nan(void) {
  uint64_t bits = 0x7ff8000000000000u;
  TTM_HIDDEN(bits);
  return ttm_from_bits(bits);
}
static inline double ttm_infinity(void) {
  return ttm_from_bits(TTM_INFINITY_BITS);
}
static inline float ttm_nan_f32(void) {
  uint32_t bits = 0x7fc00000u;
  TTM_HIDDEN(bits);
  return ttm_from_bits_f32(bits);
}
static inline float ttm_infinity_f32(void) {
  return ttm_from_bits_f32(0x7f800000u);
}
static inline double ttm_abs(double x) {
  return ttm_from_bits(ttm_bits(x) & ~TTM_SIGN);
}
static inline double ttm_with_sign_of(double magnitude, double sign) {
  return ttm_from_bits((ttm_bits(magnitude) & ~TTM_SIGN) | (ttm_bits(sign) & TTM_SIGN));
}
static inline double ttm_negate_if(double x, unsigned negate) {
  return ttm_from_bits(ttm_bits(x) ^ ((uint64_t)(negate & 1u) << 63));
}
// a if all bits of `which` are set, b if no bit is.
static inline double ttm_select(uint64_t which, double a, double b) {
  return ttm_from_bits((ttm_bits(a) & which) | (ttm_bits(b) & ~which));
}
static inline float ttm_negate_if_f32(float x, unsigned negate) {
  return ttm_from_bits_f32(ttm_bits_f32(x) ^ ((negate & 1u) << 31));
}

static inline double ttm_mul(double a, double b) {
  double product = a * b;
  TTM_ROUNDED(product);
  return product;
}

// Source: Dekker, "A floating-point technique for extending the available precision", 1971. Requires: |a| >= |b| or a =
// 0.
static inline ttm_pair ttm_fast_two_sum(double a, double b) {
  ttm_pair sum;
  sum.hi = a + b;
  sum.lo = (a - sum.hi) + b;
  return sum;
}

// Source: Knuth, "The Art of Computer Programming", volume 2, 4.2.2, theorem B.
static inline ttm_pair ttm_two_sum(double a, double b) {
  ttm_pair sum;
  sum.hi = a + b;
  double b_part = sum.hi - a;
  sum.lo = (a - (sum.hi - b_part)) + (b - b_part);
  return sum;
}

// The upper 26 bits of a double's 53.
static inline double ttm_upper(double x) {
  return ttm_from_bits(ttm_bits(x) & 0xfffffffff8000000u);
}

// a b as a pair, with a relative error of 2^-105. Requires: no overflow and no underflow.
static inline ttm_pair ttm_mul_pair(double a, double b) {
  ttm_pair product;
  double a_hi = ttm_upper(a), b_hi = ttm_upper(b);
  double a_lo = a - a_hi, b_lo = b - b_hi;
  product.hi = ttm_mul(a, b);
  product.lo = ((ttm_mul(a_hi, b_hi) - product.hi) + ttm_mul(a_hi, b_lo) + ttm_mul(a_lo, b_hi)) + ttm_mul(a_lo, b_lo);
  return product;
}

// x to the nearest integer, ties to even. Requires: |x| < 2^31.
static inline double ttm_nearest(double x, int32_t* integer) {
  const double shift = 6755399441055744.0;  // 1.5 2^52: the integer is in the low bits of the sum
  double sum = x + shift;
  *integer = (int32_t)(uint32_t)ttm_bits(sum);
  return sum - shift;
}

// --- rounding, square root, remainders ------------------------------------------------------------------------------

static inline double ticktrue_fabs(double x) {
  return ttm_abs(x);
}
static inline double ticktrue_copysign(double magnitude, double sign) {
  return ttm_with_sign_of(magnitude, sign);
}

// To the nearest integer, ties to even: rint without a rounding mode.
static inline double ticktrue_rint(double x) {
  double magnitude = ttm_abs(x);
  if (!(magnitude < 4503599627370496.0)) return x != x ? ttm_nan() : x;
  return ttm_with_sign_of((magnitude + 4503599627370496.0) - 4503599627370496.0, x);
}
static inline double ticktrue_trunc(double x) {
  double magnitude = ttm_abs(x);
  if (!(magnitude < 4503599627370496.0)) return x != x ? ttm_nan() : x;
  double rounded = (magnitude + 4503599627370496.0) - 4503599627370496.0;
  return ttm_with_sign_of(rounded > magnitude ? rounded - 1.0 : rounded, x);
}
static inline double ticktrue_floor(double x) {
  double rounded = ticktrue_rint(x);
  return rounded > x ? ttm_with_sign_of(rounded - 1.0, x) : rounded;
}
static inline double ticktrue_ceil(double x) {
  double rounded = ticktrue_rint(x);
  return rounded < x ? ttm_with_sign_of(rounded + 1.0, x) : rounded;
}
// To the nearest integer, ties away from zero. The largest double below 1/2 rounds 0.5 up, and no smaller value.
static inline double ticktrue_round(double x) {
  double magnitude = ttm_abs(x);
  if (!(magnitude < 4503599627370496.0)) return x != x ? ttm_nan() : x;
  return ttm_with_sign_of(ticktrue_trunc(magnitude + 0.49999999999999994), x);
}
static inline float ttm_to_f32(double x) {
  return x != x ? ttm_nan_f32() : (float)x;
}
static inline float ticktrue_fabsf(float x) {
  return ttm_from_bits_f32(ttm_bits_f32(x) & 0x7fffffffu);
}
static inline float ticktrue_copysignf(float magnitude, float sign) {
  return ttm_from_bits_f32((ttm_bits_f32(magnitude) & 0x7fffffffu) | (ttm_bits_f32(sign) & 0x80000000u));
}
static inline float ticktrue_rintf(float x) {
  float magnitude = ticktrue_fabsf(x);
  if (!(magnitude < 8388608.0f)) return x != x ? ttm_nan_f32() : x;
  return ticktrue_copysignf((magnitude + 8388608.0f) - 8388608.0f, x);
}
static inline float ticktrue_floorf(float x) {
  float rounded = ticktrue_rintf(x);
  return rounded > x ? ticktrue_copysignf(rounded - 1.0f, x) : rounded;
}
static inline float ticktrue_ceilf(float x) {
  float rounded = ticktrue_rintf(x);
  return rounded < x ? ticktrue_copysignf(rounded + 1.0f, x) : rounded;
}
static inline float ticktrue_truncf(float x) {
  float magnitude = ticktrue_fabsf(x);
  if (!(magnitude < 8388608.0f)) return x != x ? ttm_nan_f32() : x;
  float rounded = (magnitude + 8388608.0f) - 8388608.0f;
  return ticktrue_copysignf(rounded > magnitude ? rounded - 1.0f : rounded, x);
}
static inline float ticktrue_roundf(float x) {
  float magnitude = ticktrue_fabsf(x);
  if (!(magnitude < 8388608.0f)) return x != x ? ttm_nan_f32() : x;
  return ticktrue_copysignf(ticktrue_truncf(magnitude + 0.49999997f), x);
}

// The instruction, also at -O0, where a built-in function calls the library. Requires: x >= 0.
static inline double ttm_sqrt(double x) {
#if defined(TTM_SSE2)
  __m128d lane = _mm_set_sd(x);
  return _mm_cvtsd_f64(_mm_sqrt_sd(lane, lane));
#elif (defined(__GNUC__) || defined(__clang__)) && defined(__aarch64__)
  double root;
  __asm__("fsqrt %d0, %d1" : "=w"(root) : "w"(x));
  return root;
#elif (defined(__GNUC__) || defined(__clang__)) && defined(__arm__) && defined(__ARM_FP) && (__ARM_FP & 8)
  double root;
  __asm__("vsqrt.f64 %P0, %P1" : "=w"(root) : "w"(x));
  return root;
#elif defined(__riscv_flen) && __riscv_flen >= 64
  double root;
  __asm__("fsqrt.d %0, %1" : "=f"(root) : "f"(x));
  return root;
#elif defined(__s390x__)
  double root;
  __asm__("sqdbr %0, %1" : "=f"(root) : "f"(x));
  return root;
#elif defined(__powerpc64__)
  double root;
  __asm__("fsqrt %0, %1" : "=d"(root) : "d"(x));
  return root;
#elif defined(__GNUC__) || defined(__clang__)
  return __builtin_sqrt(x);  // an instruction in WebAssembly; elsewhere the library rounds a root correctly
#else
#error "ticktrue/math.h: no square root is known for this compiler and CPU"
#endif
}
static inline double ticktrue_sqrt(double x) {
  return x >= 0.0 ? ttm_sqrt(x) : ttm_nan();
}
// The root in double has more than twice the digits of a float: rounding it twice equals rounding it once.
static inline float ticktrue_sqrtf(float x) {
  if (!(x >= 0.0f)) return ttm_nan_f32();
#if defined(TTM_SSE2)
  return _mm_cvtss_f32(_mm_sqrt_ss(_mm_set_ss(x)));
#else
  return (float)ttm_sqrt((double)x);
#endif
}

// x - n y for the integer n that is x / y truncated: exact. `last_bit`: the last bit of n.
static inline double ttm_fmod(double x, double y, unsigned* last_bit) {
  uint64_t a = ttm_bits(x) & ~TTM_SIGN, b = ttm_bits(y) & ~TTM_SIGN;
  *last_bit = 0;
  if (b == 0 || b > TTM_INFINITY_BITS || a >= TTM_INFINITY_BITS) return ttm_nan();
  if (a < b) return x;
  int a_exponent = (int)(a >> 52), b_exponent = (int)(b >> 52);
  a &= 0x000fffffffffffffu;
  b &= 0x000fffffffffffffu;
  if (a_exponent != 0)
    a |= 0x0010000000000000u;
  else
    a_exponent = 1;
  if (b_exponent != 0)
    b |= 0x0010000000000000u;
  else
    b_exponent = 1;
  int left = a_exponent - b_exponent;
  uint64_t quotient;
  do {
    int shift = left < 11 ? left : 11;
    a <<= shift;
    quotient = a / b;
    a -= quotient * b;
    left -= shift;
  } while (left > 0);
  *last_bit = (unsigned)(quotient & 1u);
  if (a == 0) return ttm_with_sign_of(0.0, x);
  if (b_exponent > 52) {  // a 2^(b_exponent - 1075), exact
    double unit = ttm_from_bits((uint64_t)(b_exponent - 52) << 52);
    return ttm_with_sign_of(ttm_mul((double)(int64_t)a, unit), x);
  }
  while (a < 0x0010000000000000u && b_exponent > 1) {
    a <<= 1;
    --b_exponent;
  }
  if (a >= 0x0010000000000000u) a = (a & 0x000fffffffffffffu) | ((uint64_t)b_exponent << 52);
  return ttm_from_bits(a | (ttm_bits(x) & TTM_SIGN));
}
static inline double ticktrue_fmod(double x, double y) {
  unsigned last_bit;
  return ttm_fmod(x, y, &last_bit);
}
// x - n y for the integer n nearest to x / y, ties to even: exact.
static inline double ticktrue_remainder(double x, double y) {
  unsigned is_odd;
  double rest = ttm_fmod(x, y, &is_odd);
  if (rest != rest) return rest;
  double magnitude = ttm_abs(rest), divisor = ttm_abs(y);
  if (divisor > DBL_MAX) return rest;
  double other = divisor - magnitude;  // rounded, but compares as the exact value does
  if (magnitude > other || (magnitude == other && is_odd)) return ttm_negate_if(ttm_with_sign_of(other, rest), 1);
  return rest;
}
static inline float ticktrue_fmodf(float x, float y) {
  return ttm_to_f32(ticktrue_fmod((double)x, (double)y));
}
static inline float ticktrue_remainderf(float x, float y) {
  return ttm_to_f32(ticktrue_remainder((double)x, (double)y));
}

static inline double ticktrue_hypot(double x, double y) {
  double a = ttm_abs(x), b = ttm_abs(y);
  if (a > DBL_MAX || b > DBL_MAX) return ttm_infinity();
  if (x != x || y != y) return ttm_nan();
  if (a < b) {
    double swapped = a;
    a = b;
    b = swapped;
  }
  if (ttm_mul(a, 3.7252902984619141e-09) >= b) return a;  // 2^-28: b^2 / 2a is below a 2^-57
  double scale = 1.0, unscale = 1.0;
  if (a > 3.2733906078961419e+150) {  // 2^500
    scale = 2.409919865102884e-181;   // 2^-600
    unscale = 4.149515568880993e+180;
  } else if (b < 3.0549363634996047e-151) {  // 2^-500
    scale = 4.149515568880993e+180;
    unscale = 2.409919865102884e-181;
  }
  a = ttm_mul(a, scale);
  b = ttm_mul(b, scale);
  ttm_pair aa = ttm_mul_pair(a, a), bb = ttm_mul_pair(b, b);
  ttm_pair sum = ttm_fast_two_sum(aa.hi, bb.hi);
  double root = ttm_sqrt(sum.hi);
  ttm_pair square = ttm_mul_pair(root, root);
  double rest = (sum.hi - square.hi) - square.lo + (sum.lo + (aa.lo + bb.lo));
  return ttm_mul(root + rest / (root + root), unscale);
}
static inline float ticktrue_hypotf(float x, float y) {
  double a = (double)x, b = (double)y;
  if (ttm_abs(a) > (double)FLT_MAX || ttm_abs(b) > (double)FLT_MAX) return ttm_infinity_f32();
  if (x != x || y != y) return ttm_nan_f32();
  double root = ttm_sqrt(ttm_mul(a, a) + ttm_mul(b, b));
  return root >= 3.4028235677973366e+38 ? ttm_infinity_f32() : (float)root;
}

// --- sine, cosine, tangent ------------------------------------------------------------------------------------------

// 2/pi: 64 zeros, followed by the bits after the binary point.
static const uint64_t ttm_two_over_pi[21] = {
    0x0000000000000000u, 0xa2f9836e4e441529u, 0xfc2757d1f534ddc0u, 0xdb6295993c439041u, 0xfe5163abdebbc561u,
    0xb7246e3a424dd2e0u, 0x06492eea09d1921cu, 0xfe1deb1cb129a73eu, 0xe88235f52ebb4484u, 0xe99c7026b45f7e41u,
    0x3991d639835339f4u, 0x9c845f8bbdf9283bu, 0x1ff897ffde05980fu, 0xef2f118b5a0a6d1fu, 0x6d367ecf27cb09b7u,
    0x4f463f669e5fea2du, 0x7527bac7ebe5f17bu, 0x3d0739f78a5292eau, 0x6bfb5fb11f8d5d08u, 0x56033046fc7b6babu,
    0xf0cfbc209af4361du,
};

typedef struct ttm_angle {
  double hi, lo;  // -pi/4 .. pi/4, or slightly beyond
  unsigned quadrant;
} ttm_angle;

static inline void ttm_mul_64(uint64_t a, uint64_t b, uint64_t* hi, uint64_t* lo) {
  uint64_t a0 = a & 0xffffffffu, a1 = a >> 32, b0 = b & 0xffffffffu, b1 = b >> 32;
  uint64_t low = a0 * b0, middle = a1 * b0 + (low >> 32), other = a0 * b1 + (middle & 0xffffffffu);
  *lo = (other << 32) | (low & 0xffffffffu);
  *hi = a1 * b1 + (middle >> 32) + (other >> 32);
}

static inline int ttm_leading_zeros(uint64_t x) {
  int count = 0, step;
  for (step = 32; step > 0; step >>= 1)
    if ((x >> (64 - step)) == 0) {
      x <<= step;
      count += step;
    }
  return count;
}

// For any finite |x| >= 2^20. 192 bits of 2/pi are multiplied by x: higher bits only add multiples of 4 quadrants.
// Source: Payne and Hanek, "Radian reduction for trigonometric functions", 1983.
static inline ttm_angle ttm_reduce_large(double x) {
  uint64_t bits = ttm_bits(x) & ~TTM_SIGN;
  uint64_t m = (bits & 0x000fffffffffffffu) | 0x0010000000000000u;
  int first = (int)(bits >> 52) - 1075 - 2 + 64;  // the table begins with 64 zeros
  int word = first / 64, shift = first % 64, i;
  uint64_t a[3], r0, r1, r2, h1, l1, h2;
  for (i = 0; i < 3; ++i) {
    a[i] = ttm_two_over_pi[word + i] << shift;
    if (shift != 0) a[i] |= ttm_two_over_pi[word + i + 1] >> (64 - shift);
  }
  ttm_mul_64(a[2], m, &h2, &r2);
  ttm_mul_64(a[1], m, &h1, &l1);
  r1 = l1 + h2;
  r0 = a[0] * m + h1 + (r1 < h2);
  unsigned quadrant = (unsigned)(r0 >> 62);
  uint64_t f0 = (r0 << 2) | (r1 >> 62), f1 = (r1 << 2) | (r2 >> 62);
  unsigned negative = (unsigned)(f0 >> 63);
  if (negative) {
    ++quadrant;
    f0 = ~f0;
    f1 = ~f1;
  }
  int zeros = ttm_leading_zeros(f0);
  if (zeros > 0) {
    f0 = (f0 << zeros) | (f1 >> (64 - zeros));
    f1 <<= zeros;
  }
  double unit = ttm_from_bits((uint64_t)(1023 - 53 - zeros) << 52);
  double hi = ttm_mul((double)(int64_t)(f0 >> 11), unit);
  double lo = ttm_mul((double)(int64_t)(((f0 << 53) | (f1 >> 11)) >> 11), ttm_mul(unit, 1.1102230246251565e-16));
  ttm_pair product = ttm_mul_pair(hi, 1.5707963267948966);
  product.lo += ttm_mul(hi, 6.123233995736766e-17) + ttm_mul(lo, 1.5707963267948966);
  product = ttm_fast_two_sum(product.hi, product.lo);
  if (ttm_bits(x) >> 63) {
    negative ^= 1u;
    quadrant = 0u - quadrant;
  }
  ttm_angle angle;
  angle.hi = ttm_negate_if(product.hi, negative);
  angle.lo = ttm_negate_if(product.lo, negative);
  angle.quadrant = quadrant;
  return angle;
}

// For any finite x, |x| > pi/4: x - k pi/2. The parts of pi/2 have 33 bits: their products with k < 2^20 are exact.
// Source: Cody and Waite, "Software Manual for the Elementary Functions", 1980.
static inline ttm_angle ttm_reduce(double x) {
  ttm_angle angle;
  if (!(ttm_abs(x) < 1048576.0)) return ttm_reduce_large(x);
  int32_t integer;
  double k = ttm_nearest(ttm_mul(x, 0.63661977236758138), &integer);
  double a = x - ttm_mul(k, 1.5707963267341256), b = ttm_mul(k, 6.077100506303966e-11);
  angle.quadrant = (unsigned)integer;
  angle.hi = a - b;
  angle.lo = ((a - angle.hi) - b) - ttm_mul(k, 2.0222662487959506e-21);
  if (ttm_abs(angle.hi) < 0.000244140625 || ttm_abs(x) > 8192.0) {  // cancellation: one more part is needed
    ttm_pair first = ttm_two_sum(a, -b), second = ttm_two_sum(first.hi, -ttm_mul(k, 2.0222662487111665e-21));
    ttm_pair sum = ttm_fast_two_sum(second.hi, (first.lo + second.lo) - ttm_mul(k, 8.4784276603688996e-32));
    angle.hi = sum.hi;
    angle.lo = sum.lo;
  }
  return angle;
}

static inline ttm_angle ttm_quadrant(double x) {
  ttm_angle angle;
  if (ttm_abs(x) > 0.78539816339744828) return ttm_reduce(x);
  angle.hi = x;
  angle.lo = 0.0;
  angle.quadrant = 0;
  return angle;
}

// The correction to t for sin(t + lo). z = t^2.
static inline double ttm_sin_rest(double t, double lo, double z) {
  double z2 = ttm_mul(z, z), v = ttm_mul(z, t);
  double p = (-0.16666666666666632 + ttm_mul(0.0083333333333224131, z)) +
             ttm_mul(z2, (-0.00019841269829807954 + ttm_mul(2.7557313691947815e-06, z)) +
                             ttm_mul(z2, -2.5050758116991184e-08 + ttm_mul(1.5896795609584485e-10, z)));
  return ttm_mul(v, p) + (lo - ttm_mul(lo, ttm_mul(0.5, z)));
}

// cos(t + lo) as a pair. z + z_lo = t^2.
static inline ttm_pair ttm_cos_pair(double t, double lo, double z, double z_lo) {
  double z2 = ttm_mul(z, z), half = ttm_mul(0.5, z);
  double p = (0.041666666666666602 + ttm_mul(-0.0013888888888874125, z)) +
             ttm_mul(z2, (2.4801587289482632e-05 + ttm_mul(-2.7557314352439761e-07, z)) +
                             ttm_mul(z2, 2.0875723285276813e-09 + ttm_mul(-1.1359648321936381e-11, z)));
  ttm_pair result;
  result.hi = 1.0 - half;
  result.lo = ((1.0 - result.hi) - half) + ((ttm_mul(z2, p) - ttm_mul(t, lo)) - ttm_mul(0.5, z_lo));
  return result;
}
static inline double ttm_sin_kernel(double t, double lo) {
  return t + ttm_sin_rest(t, lo, ttm_mul(t, t));
}
static inline double ttm_cos_kernel(double t, double lo) {
  ttm_pair result = ttm_cos_pair(t, lo, ttm_mul(t, t), 0.0);
  return result.hi + result.lo;
}

static inline double ticktrue_sin(double x) {
  if (ttm_abs(x) < 7.450580596923828e-09) return x;  // 2^-27
  if (!(ttm_abs(x) <= DBL_MAX)) return ttm_nan();
  ttm_angle angle = ttm_quadrant(x);
  double result = (angle.quadrant & 1u) ? ttm_cos_kernel(angle.hi, angle.lo) : ttm_sin_kernel(angle.hi, angle.lo);
  return ttm_negate_if(result, angle.quadrant >> 1);
}
static inline double ticktrue_cos(double x) {
  if (!(ttm_abs(x) <= DBL_MAX)) return ttm_nan();
  ttm_angle angle = ttm_quadrant(x);
  double result = (angle.quadrant & 1u) ? ttm_sin_kernel(angle.hi, angle.lo) : ttm_cos_kernel(angle.hi, angle.lo);
  return ttm_negate_if(result, (angle.quadrant + 1u) >> 1);
}
// Both at once, with the same bits as the separate functions.
static inline void ticktrue_sincos(double x, double* sine, double* cosine) {
  if (!(ttm_abs(x) <= DBL_MAX)) {
    *sine = *cosine = ttm_nan();
    return;
  }
  ttm_angle angle = ttm_quadrant(x);
  double s = ttm_sin_kernel(angle.hi, angle.lo), c = ttm_cos_kernel(angle.hi, angle.lo);
  if (ttm_abs(x) < 7.450580596923828e-09) s = x;
  *sine = ttm_negate_if((angle.quadrant & 1u) ? c : s, angle.quadrant >> 1);
  *cosine = ttm_negate_if((angle.quadrant & 1u) ? s : c, (angle.quadrant + 1u) >> 1);
}
static inline double ticktrue_tan(double x) {
  if (ttm_abs(x) < 7.450580596923828e-09) return x;
  if (!(ttm_abs(x) <= DBL_MAX)) return ttm_nan();
  ttm_angle angle = ttm_quadrant(x);
  ttm_pair square = ttm_mul_pair(angle.hi, angle.hi);
  ttm_pair s = ttm_fast_two_sum(angle.hi, ttm_sin_rest(angle.hi, angle.lo, square.hi));
  ttm_pair c = ttm_cos_pair(angle.hi, angle.lo, square.hi, square.lo);
  c = ttm_fast_two_sum(c.hi, c.lo);
  ttm_pair above = (angle.quadrant & 1u) ? c : s, below = (angle.quadrant & 1u) ? s : c;
  double inverse = 1.0 / below.hi, quotient = ttm_mul(above.hi, inverse);
  ttm_pair product = ttm_mul_pair(quotient, below.hi);
  double rest = ((above.hi - product.hi) - product.lo) + (above.lo - ttm_mul(quotient, below.lo));
  return ttm_negate_if(quotient + ttm_mul(rest, inverse), angle.quadrant);
}

// Floats: the same in double, with shorter polynomials.
static inline ttm_angle ttm_reduce_f32(double x) {
  ttm_angle angle;
  int32_t integer;
  if (!(ttm_abs(x) < 1048576.0)) return ttm_reduce_large(x);
  double k = ttm_nearest(ttm_mul(x, 0.63661977236758138), &integer);
  angle.hi = (x - ttm_mul(k, 1.5707963267341256)) - ttm_mul(k, 6.0771005065061922e-11);
  angle.lo = 0.0;
  angle.quadrant = (unsigned)integer;
  return angle;
}
static const double ttm_sin_cos_table[8] = {
    -0.16666666641608416, 0.0083333293836972966,  -0.00019839334107972148, 2.718304384484871e-06,    // sine
    0.041666666622790151, -0.0013888883750139628, 2.4799519138962085e-05,  -2.7210165233921279e-07,  // cosine
};
// sin(t + quadrant pi/2), without a branch: the quadrant is hard to predict.
static inline double ttm_sin_f32(double t, unsigned quadrant) {
  const double* c = ttm_sin_cos_table + 4 * (quadrant & 1u);
  uint64_t is_cosine = 0u - (uint64_t)(quadrant & 1u);
  double z = ttm_mul(t, t), z2 = ttm_mul(z, z);
  double p = (c[0] + ttm_mul(c[1], z)) + ttm_mul(z2, c[2] + ttm_mul(c[3], z));
  double head = ttm_select(is_cosine, 1.0 - ttm_mul(0.5, z), t), factor = ttm_select(is_cosine, z2, ttm_mul(t, z));
  return ttm_negate_if(head + ttm_mul(factor, p), quadrant >> 1);
}
static inline float ticktrue_sinf(float x) {
  uint32_t magnitude = ttm_bits_f32(x) & 0x7fffffffu;
  if (magnitude < 0x38800000u) return x;  // 2^-14
  if (magnitude >= 0x7f800000u) return ttm_nan_f32();
  ttm_angle angle = ttm_reduce_f32((double)x);
  return (float)ttm_sin_f32(angle.hi, angle.quadrant);
}
static inline float ticktrue_cosf(float x) {
  uint32_t magnitude = ttm_bits_f32(x) & 0x7fffffffu;
  if (magnitude >= 0x7f800000u) return ttm_nan_f32();
  ttm_angle angle = ttm_reduce_f32((double)x);
  return (float)ttm_sin_f32(angle.hi, angle.quadrant + 1u);
}
static inline void ticktrue_sincosf(float x, float* sine, float* cosine) {
  uint32_t magnitude = ttm_bits_f32(x) & 0x7fffffffu;
  if (magnitude >= 0x7f800000u) {
    *sine = *cosine = ttm_nan_f32();
    return;
  }
  ttm_angle angle = ttm_reduce_f32((double)x);
  *sine = magnitude < 0x38800000u ? x : (float)ttm_sin_f32(angle.hi, angle.quadrant);
  *cosine = (float)ttm_sin_f32(angle.hi, angle.quadrant + 1u);
}
static inline float ticktrue_tanf(float x) {
  uint32_t magnitude = ttm_bits_f32(x) & 0x7fffffffu;
  if (magnitude < 0x38800000u) return x;
  if (magnitude >= 0x7f800000u) return ttm_nan_f32();
  ttm_angle angle = ttm_reduce_f32((double)x);
  return (float)(ttm_sin_f32(angle.hi, angle.quadrant) / ttm_sin_f32(angle.hi, angle.quadrant + 1u));
}

// --- exponential ----------------------------------------------------------------------------------------------------

// For i = 0 .. 127: 2^(i/128) rounded, and its relative error.
static const uint64_t ttm_exp_table[256] = {
    0x3ff0000000000000u, 0x0000000000000000u, 0x3ff0163da9fb3335u, 0x3c9b3b4f1a88bf6eu, 0x3ff02c9a3e778061u,
    0xbc7160139cd8dc5du, 0x3ff04315e86e7f85u, 0xbc905e7a108766d1u, 0x3ff059b0d3158574u, 0x3c8cd2523567f613u,
    0x3ff0706b29ddf6deu, 0xbc8bce8023f98efau, 0x3ff0874518759bc8u, 0x3c60f74e61e6c861u, 0x3ff09e3ecac6f383u,
    0x3c90a3e45b33d399u, 0x3ff0b5586cf9890fu, 0x3c979aa65d837b6du, 0x3ff0cc922b7247f7u, 0x3c8eb51a92fdeffcu,
    0x3ff0e3ec32d3d1a2u, 0x3c3ebe3d702f9cd1u, 0x3ff0fb66affed31bu, 0xbc6a033489906e0bu, 0x3ff11301d0125b51u,
    0xbc9556522a2fbd0eu, 0x3ff12abdc06c31ccu, 0xbc5080ef8c4eea55u, 0x3ff1429aaea92de0u, 0xbc91c923b9d5f416u,
    0x3ff15a98c8a58e51u, 0x3c80d3e3e95c55afu, 0x3ff172b83c7d517bu, 0xbc801b15eaa59348u, 0x3ff18af9388c8deau,
    0xbc8f1ff055de323du, 0x3ff1a35beb6fcb75u, 0x3c8b898c3f1353bfu, 0x3ff1bbe084045cd4u, 0xbc96d99c7611eb26u,
    0x3ff1d4873168b9aau, 0x3c9aecf73e3a2f60u, 0x3ff1ed5022fcd91du, 0xbc8fe782cb86389du, 0x3ff2063b88628cd6u,
    0x3c8a6f4144a6c38du, 0x3ff21f49917ddc96u, 0x3c807a05b0e4047du, 0x3ff2387a6e756238u, 0x3c968efde3a8a894u,
    0x3ff251ce4fb2a63fu, 0x3c875e18f274487du, 0x3ff26b4565e27cddu, 0x3c80472b981fe7f2u, 0x3ff284dfe1f56381u,
    0xbc96b87b3f71085eu, 0x3ff29e9df51fdee1u, 0x3c82f7e16d09ab31u, 0x3ff2b87fd0dad990u, 0xbc3d219b1a6fbffau,
    0x3ff2d285a6e4030bu, 0x3c8b3782720c0ab4u, 0x3ff2ecafa93e2f56u, 0x3c6e149289cecb8fu, 0x3ff306fe0a31b715u,
    0x3c834d754db0abb6u, 0x3ff32170fc4cd831u, 0x3c864201e2ac744cu, 0x3ff33c08b26416ffu, 0x3c8fdd395dd3f84au,
    0x3ff356c55f929ff1u, 0xbc86a3803b8e5b04u, 0x3ff371a7373aa9cbu, 0xbc924aedcc4b5068u, 0x3ff38cae6d05d866u,
    0xbc9907f81b512d8eu, 0x3ff3a7db34e59ff7u, 0xbc71d1e83e9436d2u, 0x3ff3c32dc313a8e5u, 0xbc991919b3ce1b15u,
    0x3ff3dea64c123422u, 0x3c859f48a72a4c6du, 0x3ff3fa4504ac801cu, 0xbc9312607a28698au, 0x3ff4160a21f72e2au,
    0xbc58a78f4817895bu, 0x3ff431f5d950a897u, 0xbc7c2c9b67499a1bu, 0x3ff44e086061892du, 0x3c4363ed60c2ac11u,
    0x3ff46a41ed1d0057u, 0x3c9666093b0664efu, 0x3ff486a2b5c13cd0u, 0x3c6ecce1daa10379u, 0x3ff4a32af0d7d3deu,
    0x3c93ff8e3f0f1230u, 0x3ff4bfdad5362a27u, 0x3c7690cebb7aafb0u, 0x3ff4dcb299fddd0du, 0x3c931dbdeb54e077u,
    0x3ff4f9b2769d2ca7u, 0xbc8f94340071a38eu, 0x3ff516daa2cf6642u, 0xbc87deccdc93a349u, 0x3ff5342b569d4f82u,
    0xbc78dec6bd0f385fu, 0x3ff551a4ca5d920fu, 0xbc861246ec7b5cf6u, 0x3ff56f4736b527dau, 0x3c93350518fdd78eu,
    0x3ff58d12d497c7fdu, 0x3c7b98b72f8a9b05u, 0x3ff5ab07dd485429u, 0x3c9063e1e21c5409u, 0x3ff5c9268a5946b7u,
    0x3c34c7855019c6eau, 0x3ff5e76f15ad2148u, 0x3c9432e62b64c035u, 0x3ff605e1b976dc09u, 0xbc8ce44a6199769fu,
    0x3ff6247eb03a5585u, 0xbc8c33c53bef4da8u, 0x3ff6434634ccc320u, 0xbc845378892be9aeu, 0x3ff6623882552225u,
    0xbc93cedd78565858u, 0x3ff68155d44ca973u, 0x3c5710aa807e1964u, 0x3ff6a09e667f3bcdu, 0xbc93b3efbf5e2228u,
    0x3ff6c012750bdabfu, 0xbc6a12ad8734b982u, 0x3ff6dfb23c651a2fu, 0xbc6367efb86da9eeu, 0x3ff6ff7df9519484u,
    0xbc80dc3d54e08851u, 0x3ff71f75e8ec5f74u, 0xbc781f647e5a3ecfu, 0x3ff73f9a48a58174u, 0xbc86ee4ac08b7db0u,
    0x3ff75feb564267c9u, 0xbc8619321e55e68au, 0x3ff780694fde5d3fu, 0x3c909ccb5e09d4d3u, 0x3ff7a11473eb0187u,
    0xbc7b32dcb94da51du, 0x3ff7c1ed0130c132u, 0x3c94ecfd5467c06bu, 0x3ff7e2f336cf4e62u, 0x3c65ebe1abd66c55u,
    0x3ff80427543e1a12u, 0xbc88a1c52fb3cf42u, 0x3ff82589994cce13u, 0xbc9369b6f13b3734u, 0x3ff8471a4623c7adu,
    0xbc805e843a19ff1eu, 0x3ff868d99b4492edu, 0xbc94d450d872576eu, 0x3ff88ac7d98a6699u, 0x3c90ad675b0e8a00u,
    0x3ff8ace5422aa0dbu, 0x3c8db72fc1f0eab4u, 0x3ff8cf3216b5448cu, 0xbc65b6609cc5e7ffu, 0x3ff8f1ae99157736u,
    0x3c7bf68359f35f44u, 0x3ff9145b0b91ffc6u, 0xbc93091fa71e3d83u, 0x3ff93737b0cdc5e5u, 0xbc5da9b88b6c1e29u,
    0x3ff95a44cbc8520fu, 0xbc6c23f97c90b959u, 0x3ff97d829fde4e50u, 0xbc92434322f4f9aau, 0x3ff9a0f170ca07bau,
    0xbc85ca6cd7668e4bu, 0x3ff9c49182a3f090u, 0x3c71affc2b91ce27u, 0x3ff9e86319e32323u, 0x3c6dd235e10a73bbu,
    0x3ffa0c667b5de565u, 0xbc87c50422622263u, 0x3ffa309bec4a2d33u, 0x3c8b1c86e3e231d5u, 0x3ffa5503b23e255du,
    0xbc91bbd1d3bcbb15u, 0x3ffa799e1330b358u, 0x3c90cc319cee31d2u, 0x3ffa9e6b5579fdbfu, 0x3c8469846e735ab3u,
    0x3ffac36bbfd3f37au, 0xbc82dfcd978e9db4u, 0x3ffae89f995ad3adu, 0x3c8c1a7792cb3387u, 0x3ffb0e07298db666u,
    0xbc907b8f4ad1d9fau, 0x3ffb33a2b84f15fbu, 0xbc55c3d956dcaebau, 0x3ffb59728de5593au, 0xbc90a40e3da6f640u,
    0x3ffb7f76f2fb5e47u, 0xbc68d6f438ad9334u, 0x3ffba5b030a1064au, 0xbc91eee26b588a35u, 0x3ffbcc1e904bc1d2u,
    0x3c74ffd70a5fddcdu, 0x3ffbf2c25bd71e09u, 0xbc91bdfbfa9298acu, 0x3ffc199bdd85529cu, 0x3c736eae30af0cb3u,
    0x3ffc40ab5fffd07au, 0x3c8ee3325c9ffd94u, 0x3ffc67f12e57d14bu, 0x3c84e08fd10959acu, 0x3ffc8f6d9406e7b5u,
    0x3c63cdaf384e1a67u, 0x3ffcb720dcef9069u, 0x3c676b2c6c921968u, 0x3ffcdf0b555dc3fau, 0xbc808a1883ccb5d2u,
    0x3ffd072d4a07897cu, 0xbc8fad5d3ffffa6fu, 0x3ffd2f87080d89f2u, 0xbc900dae3875a949u, 0x3ffd5818dcfba487u,
    0x3c74a385a63d07a7u, 0x3ffd80e316c98398u, 0xbc82919e2040220fu, 0x3ffda9e603db3285u, 0x3c8e5a50d5c192acu,
    0x3ffdd321f301b460u, 0x3c843a59ac016b4bu, 0x3ffdfc97337b9b5fu, 0xbc82d52107b43e1fu, 0x3ffe264614f5a129u,
    0xbc892ab93b470dc9u, 0x3ffe502ee78b3ff6u, 0x3c74b604603a88d3u, 0x3ffe7a51fbc74c83u, 0x3c83c5ec519d7271u,
    0x3ffea4afa2a490dau, 0xbc8ff7128fd391f0u, 0x3ffecf482d8e67f1u, 0xbc8dae98e223747du, 0x3ffefa1bee615a27u,
    0x3c8ec3bc41aa2008u, 0x3fff252b376bba97u, 0x3c842b94c3a9eb32u, 0x3fff50765b6e4540u, 0x3c8a64a931d185eeu,
    0x3fff7bfdad9cbe14u, 0xbc8e37bae43be3edu, 0x3fffa7c1819e90d8u, 0x3c77893b4d91cd9du, 0x3fffd3c22b8f71f1u,
    0x3c5305c14160cc89u,
};

// e^(x + lo), -746 < x < 710, |lo| < 2^-40. x = (128 e + i) ln2 / 128 + r, |r| < 0.0028.
static inline double ttm_exp(double x, double lo) {
  int32_t integer;
  double k = ttm_nearest(ttm_mul(x, 184.66496523378731), &integer);
  double r = ((x - ttm_mul(k, 0.0054152123482253955)) - ttm_mul(k, -1.0082281460997769e-13)) + lo;
  double r2 = ttm_mul(r, r);
  unsigned index = (unsigned)integer & 127u;
  int32_t exponent = (integer - (int32_t)index) / 128;
  double rest = ttm_from_bits(ttm_exp_table[2 * index + 1]) +
                (r + ttm_mul(r2, (0.49999999999996775 + ttm_mul(0.16666666666665889, r)) +
                                     ttm_mul(r2, 0.041666680870695819 + ttm_mul(0.0083333358504295157, r))));
  uint64_t bits = ttm_exp_table[2 * index];
  if (exponent >= -960 && exponent <= 1022) {  // below, the product would have fewer bits
    double power = ttm_from_bits(bits + ((uint64_t)(int64_t)exponent << 52));
    return power + ttm_mul(power, rest);
  }
  if (exponent > 0) {
    double power = ttm_from_bits(bits + ((uint64_t)(int64_t)(exponent - 1) << 52));
    return ttm_mul(power + ttm_mul(power, rest), 2.0);
  }
  // Below 2^-1022 a result has fewer bits: it is rounded once, as 1 + result 2^1022.
  double power = ttm_from_bits(bits + ((uint64_t)(int64_t)(exponent + 1022) << 52)), small = ttm_mul(power, rest);
  double sum = power + small;
  if (sum < 1.0) {
    double sum_lo = (power - sum) + small, above = 1.0 + sum;
    sum = (above + ((1.0 - above) + sum + sum_lo)) - 1.0;
  }
  return ttm_mul(sum, 2.2250738585072014e-308);
}

static inline double ticktrue_exp(double x) {
  if (x != x) return ttm_nan();
  if (x > 709.78271289338397) return ttm_infinity();
  if (x < -745.13321910194122) return 0.0;
  return ttm_exp(x, 0.0);
}

// e^x in double for a float. Requires: |x| < 200.
static inline double ttm_exp_f32(double x) {
  int32_t integer;
  double k = ttm_nearest(ttm_mul(x, 184.66496523378731), &integer);
  double r = (x - ttm_mul(k, 0.0054152123482253955)) - ttm_mul(k, -1.0082281460997769e-13);
  unsigned index = (unsigned)integer & 127u;
  int32_t exponent = (integer - (int32_t)index) / 128;
  double power = ttm_from_bits(ttm_exp_table[2 * index] + ((uint64_t)(int64_t)exponent << 52));
  return power + ttm_mul(power, r + ttm_mul(ttm_mul(r, r), 0.50000025355476008 + ttm_mul(0.16666672788168393, r)));
}
static inline float ticktrue_expf(float x) {
  if (x != x) return ttm_nan_f32();
  if (x > 88.7228317f) return ttm_infinity_f32();
  if (x < -103.972084f) return 0.0f;
  return (float)ttm_exp_f32((double)x);
}

// --- logarithm ------------------------------------------------------------------------------------------------------

// For 128 intervals of 0.6875 .. 1.375: 1/c with 9 bits after the point, ln c as a multiple of 2^-42, and its error.
static const uint64_t ttm_log_table[384] = {
    0x3ff7380000000000u, 0xbfd7d4eeef5ef000u, 0x3d2c9018f8f27d8fu, 0x3ff7100000000000u, 0xbfd7664e1239e000u,
    0x3d30c4fb6aeb27afu, 0x3ff6f00000000000u, 0xbfd70d42e2789000u, 0xbd21aead337ee287u, 0x3ff6d00000000000u,
    0xbfd6b3bb22359000u, 0xbd30f6257a933268u, 0x3ff6b00000000000u, 0xbfd659b57303e000u, 0xbd1f281db0af8efcu,
    0x3ff6900000000000u, 0xbfd5ff3070a79000u, 0xbd2e9e439f105039u, 0x3ff6700000000000u, 0xbfd5a42ab0f4d000u,
    0x3cde63af2df7ba69u, 0x3ff6500000000000u, 0xbfd548a2c3add000u, 0xbd23167e63081cf7u, 0x3ff6300000000000u,
    0xbfd4ec9732600000u, 0xbd234d7aaf04d104u, 0x3ff6180000000000u, 0xbfd4a7373ced0000u, 0x3d39a234ebf35449u,
    0x3ff5f80000000000u, 0xbfd44a41b463c000u, 0xbd31ee28f37cf612u, 0x3ff5d80000000000u, 0xbfd3ecc460ef6000u,
    0x3d06028627c1300fu, 0x3ff5b80000000000u, 0xbfd38ebdb38ed000u, 0xbd290582e67d4ca0u, 0x3ff5a00000000000u,
    0xbfd347dd9a988000u, 0x3d25594dd4c58092u, 0x3ff5800000000000u, 0xbfd2e8e2bae12000u, 0x3d267b1e99b72bd8u,
    0x3ff5600000000000u, 0xbfd2895a13de8000u, 0xbd3a8d7ad24c13f0u, 0x3ff5480000000000u, 0xbfd241558bfd1000u,
    0xbd300fff3228fcadu, 0x3ff5280000000000u, 0xbfd1e0d0c3371000u, 0xbd3af8f2a9b0d4a0u, 0x3ff5100000000000u,
    0xbfd1980d2dd42000u, 0xbd2b7b3a7a361c9au, 0x3ff4f00000000000u, 0xbfd136870293b000u, 0x3d3d3e8499d67123u,
    0x3ff4d80000000000u, 0xbfd0ed005f658000u, 0x3d22dc75285aa803u, 0x3ff4c00000000000u, 0xbfd0a324e2739000u,
    0xbd0c6bee7ef4030eu, 0x3ff4a00000000000u, 0xbfd0402594b4d000u, 0xbcf036b89ef42d7fu, 0x3ff4880000000000u,
    0xbfcfeb0233e60000u, 0xbd2f316e32d5e8c7u, 0x3ff4700000000000u, 0xbfcf550a564b8000u, 0x3d2323e3a09202feu,
    0x3ff4500000000000u, 0xbfce8c0252aa6000u, 0x3d26805b80e8e6ffu, 0x3ff4380000000000u, 0xbfcdf46c0c722000u,
    0xbd3a5e82b0b79039u, 0x3ff4200000000000u, 0xbfcd5c216b4fc000u, 0x3d21ba91bbca681bu, 0x3ff4080000000000u,
    0xbfccc320c0176000u, 0xbd2409039a653794u, 0x3ff3f00000000000u, 0xbfcc2968558c2000u, 0x3d2cfd73dee38a40u,
    0x3ff3d80000000000u, 0xbfcb8ef670420000u, 0xbd387533321788e0u, 0x3ff3c00000000000u, 0xbfcaf3c94e80c000u,
    0x3cba4e633fcd9066u, 0x3ff3a80000000000u, 0xbfca57df28244000u, 0xbd3b99c8ca1d9abbu, 0x3ff3900000000000u,
    0xbfc9bb362e7e0000u, 0x3d21f2a8a1ce0ffcu, 0x3ff3780000000000u, 0xbfc91dcc8c340000u, 0xbd37bc6abddeff46u,
    0x3ff3600000000000u, 0xbfc87fa06520c000u, 0xbd322120401202fcu, 0x3ff3480000000000u, 0xbfc7e0afd630c000u,
    0xbd139e7c1d8f1034u, 0x3ff3300000000000u, 0xbfc740f8f5404000u, 0x3d30b66c99018aa1u, 0x3ff3180000000000u,
    0xbfc6a079d0f7a000u, 0xbd35a3f8448d14f5u, 0x3ff3000000000000u, 0xbfc5ff3070a7a000u, 0x3d38586f183bebf2u,
    0x3ff2e80000000000u, 0xbfc55d1ad4232000u, 0xbd3add94dda647e8u, 0x3ff2d80000000000u, 0xbfc4f099f4a24000u,
    0x3d3e9bf2fafeaf27u, 0x3ff2c00000000000u, 0xbfc44d2b6ccb8000u, 0x3d170cc16135783cu, 0x3ff2a80000000000u,
    0xbfc3a8eb2d31a000u, 0xbd1bafb77d5d503eu, 0x3ff2900000000000u, 0xbfc303d718e48000u, 0x3cd680b5ce3ecb05u,
    0x3ff2800000000000u, 0xbfc29552f8200000u, 0x3d35b967f4471dfcu, 0x3ff2680000000000u, 0xbfc1eed90e2dc000u,
    0xbd1615637097648fu, 0x3ff2500000000000u, 0xbfc1478584674000u, 0xbd1563451027c750u, 0x3ff2400000000000u,
    0xbfc0d77e7cd08000u, 0xbd3cb2cd2ee2f482u, 0x3ff2280000000000u, 0xbfc02ebb42bf4000u, 0x3d15a8fa5ce00e5du,
    0x3ff2180000000000u, 0xbfbf7b79fec38000u, 0x3d010987e897ed01u, 0x3ff2000000000000u, 0xbfbe27076e2b0000u,
    0x3d2a342c2af0003cu, 0x3ff1f00000000000u, 0xbfbd4313d66cc000u, 0x3d29454379135713u, 0x3ff1d80000000000u,
    0xbfbbeba818148000u, 0x3d389b78b6df1f57u, 0x3ff1c80000000000u, 0xbfbb05b49bee4000u, 0xbd0ff22c18f84a5eu,
    0x3ff1b00000000000u, 0xbfb9ab4246204000u, 0x3d28a64826787061u, 0x3ff1a00000000000u, 0xbfb8c345d6318000u,
    0xbd3b20f5acb42a66u, 0x3ff1880000000000u, 0xbfb765bf23a6c000u, 0x3cfecbc035c4256au, 0x3ff1780000000000u,
    0xbfb67bb0726ec000u, 0xbcef724b69ef5912u, 0x3ff1680000000000u, 0xbfb590cafdf00000u, 0xbd3c284f5722abaau,
    0x3ff1500000000000u, 0xbfb42edcbea64000u, 0xbd1bc0eeea7c9acdu, 0x3ff1400000000000u, 0xbfb341d7961bc000u,
    0xbd31d09299837610u, 0x3ff1300000000000u, 0xbfb253f62f0a0000u, 0xbd3416f8fb69a701u, 0x3ff1180000000000u,
    0xbfb0ed839b554000u, 0x3d3901f46d48abb4u, 0x3ff1080000000000u, 0xbfaffae9119b8000u, 0xbd2303374262c554u,
    0x3ff0f80000000000u, 0xbfae19070c278000u, 0x3d2fea4664629e86u, 0x3ff0e80000000000u, 0xbfac355dd0920000u,
    0xbd2f2ccc9abf8388u, 0x3ff0d00000000000u, 0xbfa95c830ec90000u, 0x3d2c148297c5feb8u, 0x3ff0c00000000000u,
    0xbfa77458f6330000u, 0x3d3181dce586af09u, 0x3ff0b00000000000u, 0xbfa58a5bafc90000u, 0x3d2b2b739570ad39u,
    0x3ff0a00000000000u, 0xbfa39e87b9fe8000u, 0xbd3eafd480ad9015u, 0x3ff0900000000000u, 0xbfa1b0d989240000u,
    0x3d33401e9ae889bbu, 0x3ff0780000000000u, 0xbf9d91a66c540000u, 0xbd2e61f1658cfb9au, 0x3ff0680000000000u,
    0xbf99ace7551d0000u, 0x3d2d75d97ec7c410u, 0x3ff0580000000000u, 0xbf95c45a51b90000u, 0x3d263bb6216d87d8u,
    0x3ff0480000000000u, 0xbf91d7f7eb9f0000u, 0x3d14193a83fcc7a6u, 0x3ff0380000000000u, 0xbf8bcf712c740000u,
    0xbd1c25e097bd9771u, 0x3ff0280000000000u, 0xbf83e7295d260000u, 0x3d2609c1ff29a114u, 0x3ff0180000000000u,
    0xbf77ee11ebd80000u, 0xbd0749d3c2d23a07u, 0x3ff0000000000000u, 0x0000000000000000u, 0x0000000000000000u,
    0x3ff0000000000000u, 0x0000000000000000u, 0x0000000000000000u, 0x3fefa00000000000u, 0x3f882448a3880000u,
    0x3d34554412c584e0u, 0x3fef600000000000u, 0x3f9432a925980000u, 0x3d098139928637feu, 0x3fef200000000000u,
    0x3f9c63d2ec150000u, 0xbd35439ce030a687u, 0x3feef00000000000u, 0x3fa149e3e4008000u, 0xbd32b98a9a4168fdu,
    0x3feeb00000000000u, 0x3fa5715c4c040000u, 0xbd38888ddfc47628u, 0x3fee700000000000u, 0x3fa9a187b5740000u,
    0xbd30c22e4ec4d90du, 0x3fee400000000000u, 0x3faccb73cddd8000u, 0x3d3965c36e09f5feu, 0x3fee000000000000u,
    0x3fb08598b59e4000u, 0xbd17e5dd7009902cu, 0x3fedd00000000000u, 0x3fb2207b5c784000u, 0x3d349d8cfc10c7bfu,
    0x3fed900000000000u, 0x3fb4485e03dbc000u, 0x3d3fad46e8d26ab7u, 0x3fed600000000000u, 0x3fb5e95a4d978000u,
    0x3d31cb7ce1d17171u, 0x3fed200000000000u, 0x3fb8197e2f410000u, 0xbd3c0fe460d20041u, 0x3fecf00000000000u,
    0x3fb9c0c32d4d4000u, 0xbd3ab7c09e838668u, 0x3fecc00000000000u, 0x3fbb6ac88dad4000u, 0x3d3b1bdff50225c7u,
    0x3fec900000000000u, 0x3fbd179788218000u, 0x3d336433b5efbeedu, 0x3fec600000000000u, 0x3fbec739830a0000u,
    0x3d311fcba80cdd10u, 0x3fec200000000000u, 0x3fc08598b59e4000u, 0xbd27e5dd7009902cu, 0x3febf00000000000u,
    0x3fc160c8024b2000u, 0x3d2ec2d2a9009e3du, 0x3febc00000000000u, 0x3fc23d712a49c000u, 0x3d100d238fd3df5cu,
    0x3feb900000000000u, 0x3fc31b994d3a4000u, 0x3d3f098ee3a50810u, 0x3feb600000000000u, 0x3fc3fb45a5992000u,
    0x3d319713c0cae559u, 0x3feb300000000000u, 0x3fc4dc7b897bc000u, 0x3d0c79b60ae1ff0fu, 0x3feb100000000000u,
    0x3fc5737cc9018000u, 0x3d39baa7a6b887f6u, 0x3feae00000000000u, 0x3fc6574ebe8c2000u, 0xbd398c1d34f0f462u,
    0x3feab00000000000u, 0x3fc73cb9074fe000u, 0xbd3d66a90d0005a6u, 0x3fea800000000000u, 0x3fc823c16551a000u,
    0x3d1e0ddb9a631e83u, 0x3fea500000000000u, 0x3fc90c6db9fcc000u, 0xbd1935f57718d7cau, 0x3fea300000000000u,
    0x3fc9a8778deba000u, 0x3d3470fa3efec390u, 0x3fea000000000000u, 0x3fca93ed3c8ae000u, 0xbd28724350562169u,
    0x3fe9d00000000000u, 0x3fcb811730b82000u, 0x3d1e90683b9cd768u, 0x3fe9b00000000000u, 0x3fcc2028ab180000u,
    0xbd292e0ee55c7ac6u, 0x3fe9800000000000u, 0x3fcd1037f2656000u, 0xbd084a7e75b6f6e4u, 0x3fe9600000000000u,
    0x3fcdb13db0d48000u, 0x3d32806a847527e6u, 0x3fe9300000000000u, 0x3fcea4449f04a000u, 0x3d35e91663732a36u,
    0x3fe9100000000000u, 0x3fcf474b134e0000u, 0xbd3bae49f1df7b5eu, 0x3fe8e00000000000u, 0x3fd01eae5626c000u,
    0x3d3a43dcfade85aeu, 0x3fe8c00000000000u, 0x3fd07138604d6000u, 0xbd3e76324e912b17u, 0x3fe8a00000000000u,
    0x3fd0c42d67616000u, 0x3d27188b163ceae9u, 0x3fe8700000000000u, 0x3fd14167ef367000u, 0x3d3e0c07824daaf5u,
    0x3fe8500000000000u, 0x3fd1956d3b9bc000u, 0x3d27d2f73ad1aa14u, 0x3fe8300000000000u, 0x3fd1e9e16788a000u,
    0xbd382eaed3c8b65eu, 0x3fe8000000000000u, 0x3fd269621134e000u, 0xbd31b61f10522625u, 0x3fe7e00000000000u,
    0x3fd2bef07cdc9000u, 0x3d2a9cfa4a5004f4u, 0x3fe7c00000000000u, 0x3fd314f1e1d36000u, 0xbd28e27ad3213cb8u,
    0x3fe7a00000000000u, 0x3fd36b6776be1000u, 0x3d116ecdb0f177c8u, 0x3fe7800000000000u, 0x3fd3c25277333000u,
    0x3d183b54b606bd5cu, 0x3fe7500000000000u, 0x3fd44591e053a000u, 0xbd06e95892923d88u,
};

typedef struct ttm_log_parts {
  double r, r_lo;      // x = 2^k c (1 + r + r_lo), exact
  double base, extra;  // k ln 2 + ln c; base is a multiple of 2^-42
} ttm_log_parts;

// Requires: x is positive and finite.
static inline ttm_log_parts ttm_log_split(double x) {
  uint64_t bits = ttm_bits(x);
  int32_t k = -1023;
  if (bits < 0x0010000000000000u) {
    bits = ttm_bits(ttm_mul(x, 4503599627370496.0));
    k = -1023 - 52;
  }
  uint64_t place = bits - 0x3fe6000000000000u + TTM_ONE_BITS;
  unsigned index = (unsigned)(place >> 45) & 127u;
  k += (int32_t)(place >> 52);
  uint64_t z_bits = bits - (place & 0xfff0000000000000u) + TTM_ONE_BITS;
  double z = ttm_from_bits(z_bits), z_hi = ttm_from_bits(z_bits & 0xffffffff00000000u);
  double inverse = ttm_from_bits(ttm_log_table[3 * index]), double_k = (double)k;
  double a = ttm_mul(z_hi, inverse) - 1.0, b = ttm_mul(z - z_hi, inverse);
  ttm_log_parts parts;
  ttm_pair sum = ttm_two_sum(a, b);
  parts.r = sum.hi;
  parts.r_lo = sum.lo;
  parts.base = ttm_mul(double_k, 0.69314718055989033) + ttm_from_bits(ttm_log_table[3 * index + 1]);
  parts.extra = ttm_mul(double_k, 5.4979230187083712e-14) + ttm_from_bits(ttm_log_table[3 * index + 2]);
  return parts;
}

static inline double ticktrue_log(double x) {
  if (!(x > 0.0 && x <= DBL_MAX)) {
    if (x == 0.0) return -ttm_infinity();
    return x > 0.0 ? x : ttm_nan();
  }
  ttm_log_parts parts = ttm_log_split(x);
  double r = parts.r, r2 = ttm_mul(r, r);
  double p = (0.333333333333028 + ttm_mul(-0.25000000001258504, r)) +
             ttm_mul(r2, (0.20000004203511151 + ttm_mul(-0.16666829245435949, r)) + ttm_mul(r2, 0.14151890348236254));
  ttm_pair sum = ttm_fast_two_sum(parts.base, r);
  return sum.hi + ((sum.lo + parts.extra) + ttm_mul(r2, -0.5 + ttm_mul(r, p)));
}

// ln x in double for a float, with an error of 2^-42. Requires: x is positive, finite and a normal double.
static inline double ttm_log_f32(double x) {
  uint64_t bits = ttm_bits(x), place = bits - 0x3fe6000000000000u + TTM_ONE_BITS;
  unsigned index = (unsigned)(place >> 45) & 127u;
  double k = (double)((int32_t)(place >> 52) - 1023);
  double z = ttm_from_bits(bits - (place & 0xfff0000000000000u) + TTM_ONE_BITS);
  double r = ttm_mul(z, ttm_from_bits(ttm_log_table[3 * index])) - 1.0, r2 = ttm_mul(r, r);
  double base = ttm_mul(k, 0.69314718055994529) +
                (ttm_from_bits(ttm_log_table[3 * index + 1]) + ttm_from_bits(ttm_log_table[3 * index + 2]));
  return base + (r + ttm_mul(r2, (-0.49999999998284622 + ttm_mul(0.33333335787019325, r)) +
                                     ttm_mul(r2, -0.25000338637230152 + ttm_mul(0.19873393682268714, r))));
}
static inline float ticktrue_logf(float x) {
  if (!(x > 0.0f && x <= FLT_MAX)) {
    if (x == 0.0f) return -ttm_infinity_f32();
    return x > 0.0f ? x : ttm_nan_f32();
  }
  return (float)ttm_log_f32((double)x);
}

// --- powers ---------------------------------------------------------------------------------------------------------

// 0: y is not an integer; 1: odd; 2: even.
static inline int ttm_parity(double y) {
  uint64_t bits = ttm_bits(y) & ~TTM_SIGN;
  int exponent = (int)(bits >> 52);
  if (exponent < 1023) return bits == 0 ? 2 : 0;
  if (exponent > 1075) return 2;
  if (exponent == 1075) return (bits & 1u) ? 1 : 2;
  uint64_t unit = (uint64_t)1 << (1075 - exponent);
  if (((bits | 0x0010000000000000u) & (unit - 1)) != 0) return 0;
  return ((bits | 0x0010000000000000u) & unit) ? 1 : 2;
}

// The cases that C11, F.10.4.4, defines. Returns 1 for such a case.
static inline int ttm_pow_special(double x, double y, double* result) {
  double magnitude = ttm_abs(x), size = ttm_abs(y);
  if (y == 0.0 || x == 1.0) {
    *result = 1.0;
  } else if (x != x || y != y) {
    *result = ttm_nan();
  } else if (size > DBL_MAX) {
    *result = magnitude == 1.0 ? 1.0 : ((magnitude > 1.0) == (y > 0.0) ? ttm_infinity() : 0.0);
  } else if (magnitude == 0.0 || magnitude > DBL_MAX) {
    *result = (magnitude > 1.0) == (y > 0.0) ? ttm_infinity() : 0.0;
    if (ttm_parity(y) == 1) *result = ttm_with_sign_of(*result, x);
  } else if (x < 0.0 && ttm_parity(y) == 0) {
    *result = ttm_nan();
  } else {
    return 0;
  }
  return 1;
}

// ln x as a pair, with a relative error of 2^-67. Requires: x is positive and finite.
static inline ttm_pair ttm_log_pair(double x) {
  ttm_log_parts parts = ttm_log_split(x);
  double r = parts.r, r2 = ttm_mul(r, r);
  double upper = ttm_upper(r), lower = r - upper;  // r^2 = upper^2 + lower (r + upper)
  double p = (0.33333333333333287 + ttm_mul(-0.24999999999962555, r)) +
             ttm_mul(r2, (0.20000000006527291 + ttm_mul(-0.166666712381868, r)) +
                             ttm_mul(r2, 0.14285723817860382 + ttm_mul(-0.12362439863265613, r)));
  ttm_pair first = ttm_fast_two_sum(parts.base, r);
  ttm_pair second = ttm_fast_two_sum(first.hi, ttm_mul(-0.5, ttm_mul(upper, upper)));
  double square_rest = ttm_mul(0.5, ttm_mul(lower, r + upper)) + ttm_mul(r, parts.r_lo);
  double lo = (first.lo + second.lo + parts.r_lo + parts.extra) + (ttm_mul(ttm_mul(r, r2), p) - square_rest);
  return ttm_fast_two_sum(second.hi, lo);
}

static inline double ticktrue_pow(double x, double y) {
  double special, magnitude = ttm_abs(x), size = ttm_abs(y);
  unsigned negative = 0;
  if (ttm_bits(x) - 1u >= TTM_INFINITY_BITS - 1u || 2 * ttm_bits(y) - 1u >= 2 * TTM_INFINITY_BITS - 1u) {
    if (ttm_pow_special(x, y, &special)) return special;
    negative = ttm_parity(y) == 1;
  }
  if (magnitude == 1.0) return ttm_negate_if(1.0, negative);
  if (size < 2.7105054312137611e-20) return 1.0;                                                    // 2^-65
  if (size > 18446744073709551616.0) return (magnitude > 1.0) == (y > 0.0) ? ttm_infinity() : 0.0;  // y is even
  ttm_pair logarithm = ttm_log_pair(magnitude), exponent = ttm_mul_pair(y, logarithm.hi);
  exponent.lo += ttm_mul(y, logarithm.lo);
  if (!(exponent.hi < 710.0)) return ttm_negate_if(ttm_infinity(), negative);
  if (!(exponent.hi > -746.0)) return ttm_negate_if(0.0, negative);
  return ttm_negate_if(ttm_exp(exponent.hi, exponent.lo), negative);
}
static inline float ticktrue_powf(float x, float y) {
  double special, magnitude = ttm_abs((double)x);
  unsigned negative = 0;
  if (ttm_bits_f32(x) - 1u >= 0x7f7fffffu || 2 * ttm_bits_f32(y) - 1u >= 0xfeffffffu) {
    if (ttm_pow_special((double)x, (double)y, &special)) return ttm_to_f32(special);
    negative = ttm_parity((double)y) == 1;
  }
  double exponent = ttm_mul((double)y, ttm_log_f32(magnitude));
  if (exponent > 88.722839111673) return ttm_negate_if_f32(ttm_infinity_f32(), negative);
  if (exponent < -104.0) return ttm_negate_if_f32(0.0f, negative);
  return ttm_negate_if_f32((float)ttm_exp_f32(exponent), negative);
}

// --- inverse functions ----------------------------------------------------------------------------------------------

// atan c for c = 2^e (1 + (2 j + 1) / 16), e = -4 .. 3, j = 0 .. 7: rounded, and its error.
static const uint64_t ttm_atan_table[128] = {
    0x3fb0f99ea71d52a7u, 0xbc22069feec3624fu, 0x3fb2f719318a4a9au, 0x3c03fd1779b9801fu, 0x3fb4f3fd677292fbu,
    0x3c4008d36264979eu, 0x3fb6f03bdcea4b0du, 0xbc33f00e512fa17du, 0x3fb8ebc54478fb28u, 0x3c4732880cad24ccu,
    0x3fbae68a71c722b8u, 0x3c4c014e6910b9dbu, 0x3fbce07c5c3cca32u, 0x3c4138e6425918a7u, 0x3fbed98c2190043bu,
    0xbc23a598592c7b13u, 0x3fc0e6adccf40882u, 0xbc6d71a31bb98d0du, 0x3fc2dcbdb2fba1ffu, 0x3c58f28705561534u,
    0x3fc4d087a9da4f17u, 0x3c61f323f1adf158u, 0x3fc6c1d4898933d9u, 0xbc52954a7603c427u, 0x3fc8b06ee2879c29u,
    0xbc6118cd30308c4fu, 0x3fca9c231b403279u, 0x3c60e8bbe89cca85u, 0x3fcc84bf8a742e6eu, 0xbc595bdd0682ea26u,
    0x3fce6a148e96ec4du, 0x3c6866b22029f765u, 0x3fd09dc597d86362u, 0x3c762e47390cb865u, 0x3fd278372057ef46u,
    0xbc7077cdd36dfc81u, 0x3fd44aa436c2af0au, 0xbc75d5e43c55b3bau, 0x3fd614840309cfe2u, 0xbc7a725715711f00u,
    0x3fd7d5604b63b3f7u, 0x3c769c885c2b249au, 0x3fd98cd5454d6b18u, 0x3c79e6c988fd0a77u, 0x3fdb3a911da65c6cu,
    0x3c7ae187b1ca5040u, 0x3fdcde53432c1351u, 0xbc7a2cfa4418f1adu, 0x3fdf40dd0b541418u, 0xbc6a3992dc382a23u,
    0x3fe1255d9bfbd2a9u, 0xbc52bdaee1c0ee35u, 0x3fe2958e59308e31u, 0xbc709e73b0c6c087u, 0x3fe3f13fb89e96f4u,
    0x3c7ecf8b492644f0u, 0x3fe538f57b89061fu, 0xbc81bb74abda520cu, 0x3fe66d663923e087u, 0xbc76ea6febe8bbbau,
    0x3fe78f6bbd5d315eu, 0x3c8406a089803740u, 0x3fe89ff5ff57f1f8u, 0xbc855b9a5e177a1bu, 0x3fea1a25f2c82506u,
    0xbc68b4c3611182fcu, 0x3febde70ed439fe7u, 0xbc7a2b56372c05efu, 0x3fed6e57cf4f0acau, 0xbc8763b9456ae66eu,
    0x3feed0d97c9041c9u, 0xbc52629e3b5da490u, 0x3ff006132e34d617u, 0x3c9b343dfa868d93u, 0x3ff092ce471853ccu,
    0x3c8269f9b3e200c2u, 0x3ff110eb007f39f7u, 0xbc912b2ff85e5500u, 0x3ff1825f074030d9u, 0xbc59523f0af0d3b5u,
    0x3ff21862f3fade36u, 0x3c94887628d68748u, 0x3ff2c1a241d66dc3u, 0x3c982b2d58b6a8e9u, 0x3ff34f1fbb19eb09u,
    0x3c880d79b4cf61d5u, 0x3ff3c6e650b38047u, 0x3c96b63b358e746du, 0x3ff42d70411f9ec1u, 0x3c82b08db7f10896u,
    0x3ff4861b4cfbe710u, 0xbc6567d3d25932d1u, 0x3ff4d378c1999a0du, 0xbc6c857a639541c8u, 0x3ff51784fa1544bau,
    0xbc9236e3c857c019u, 0x3ff56f6f33a3e6a7u, 0xbc7df6edd6f1ec3bu, 0x3ff5d013c41adabdu, 0x3c9f82bba194dd5du,
    0x3ff61f06c6a92b89u, 0xbc8487d50bceb1a5u, 0x3ff660b02c736a06u, 0xbc7acb6afb332a0fu, 0x3ff698213a9d5053u,
    0xbc9b9839085189e3u, 0x3ff6c78c7edeb195u, 0x3c99239ad620ffe2u, 0x3ff6f08f07435fecu, 0xbc8957a7170df016u,
    0x3ff7145eac2088a4u, 0xbc9fda5797b32a0bu, 0x3ff7424de90454d4u, 0xbc93a75d182e1a5fu, 0x3ff77467e364f601u,
    0xbc9bfda44f3537b8u, 0x3ff79d0f3fad1c92u, 0x3c838727dc4fb7d1u, 0x3ff7beb396c5699au, 0xbc83dc969c7e2365u,
    0x3ff7daff85a63058u, 0x3c91ee9bcca84eb2u, 0x3ff7f320a0f9f587u, 0x3c738dbb20936502u, 0x3ff807f2112987c7u,
    0x3c9178e474ec8c66u, 0x3ff81a16e43f190bu, 0xbc9e6b0733383ad4u,
};

typedef struct ttm_arc {
  double hi, s, rest;  // hi + s + rest, |s| < 1/16
} ttm_arc;

// atan s - s, and the part of `lo` that is lost. |s| < 1/16.
static inline double ttm_atan_rest(double s, double lo) {
  double z = ttm_mul(s, s), z2 = ttm_mul(z, z);
  double p = (-0.33333333333333159 + ttm_mul(0.19999999999372328, z)) +
             ttm_mul(z2, (-0.14285713547908777 + ttm_mul(0.11110732475737307, z)) + ttm_mul(z2, -0.090026116823454128));
  return ttm_mul(ttm_mul(s, z), p) + lo;
}

// atan(y / x), x > 0, 1/16 <= ratio < 16: atan c + atan s, s = (y - c x) / (x + c y). `ratio` is close to y / x.
static inline ttm_arc ttm_atan_middle(double y, double x, double ratio) {
  uint64_t bits = ttm_bits(ratio);
  unsigned index = (unsigned)(bits >> 49) - (1019u << 3);
  double c =
      ttm_from_bits((bits & 0xfffe000000000000u) | 0x0001000000000000u);  // 5 bits, so that its products are exact
  double x_hi = ttm_upper(x);
  ttm_arc arc;
  arc.hi = ttm_from_bits(ttm_atan_table[2 * index]);
  arc.s = ((y - ttm_mul(c, x_hi)) - ttm_mul(c, x - x_hi)) / (x + ttm_mul(c, y));
  arc.rest = ttm_atan_rest(arc.s, ttm_from_bits(ttm_atan_table[2 * index + 1]));
  return arc;
}
static inline ttm_arc ttm_atan_steep(double inverse) {  // of 1 / inverse, 0 <= inverse <= 1/16
  ttm_arc arc;
  arc.hi = 1.5707963267948966;
  arc.s = -inverse;
  arc.rest = ttm_atan_rest(arc.s, 6.123233995736766e-17);
  return arc;
}

static inline double ticktrue_atan(double x) {
  double size = ttm_abs(x);
  if (size < 0.0625) {
    if (size < 7.450580596923828e-09) return x;
    return x + ttm_atan_rest(x, 0.0);
  }
  if (x != x) return ttm_nan();
  ttm_arc arc = size < 16.0 ? ttm_atan_middle(size, 1.0, size) : ttm_atan_steep(1.0 / size);
  return ttm_with_sign_of(arc.hi + (arc.s + arc.rest), x);
}

static inline double ticktrue_atan2(double y, double x) {
  if (x != x || y != y) return ttm_nan();
  double a = ttm_abs(y), b = ttm_abs(x);
  unsigned left = (unsigned)(ttm_bits(x) >> 63);
  if (a > DBL_MAX && b > DBL_MAX) return ttm_with_sign_of(left ? 2.3561944901923448 : 0.78539816339744828, y);
  double larger = a > b ? a : b;
  if (larger > 3.2733906078961419e+150) {  // 2^500
    a = ttm_mul(a, 2.409919865102884e-181);
    b = ttm_mul(b, 2.409919865102884e-181);
  } else if (larger < 3.0549363634996047e-151) {  // 2^-500
    a = ttm_mul(a, 4.149515568880993e+180);
    b = ttm_mul(b, 4.149515568880993e+180);
  }
  if (b < ttm_mul(a, 8.6736173798840355e-19)) return ttm_with_sign_of(1.5707963267948966, y);  // 2^-60
  if (a < ttm_mul(b, 8.6736173798840355e-19) || y == 0.0) {
    if (left) return ttm_with_sign_of(3.1415926535897931, y);
    return y == 0.0 ? y : ttm_with_sign_of(ttm_abs(y) / ttm_abs(x), y);
  }
  ttm_arc arc;
  double ratio = a / b;
  if (ratio < 0.0625) {
    ttm_pair product = ttm_mul_pair(ratio, b);
    arc.hi = 0.0;
    arc.s = ratio;
    arc.rest = ttm_atan_rest(ratio, ((a - product.hi) - product.lo) / b);
  } else {
    arc = ratio < 16.0 ? ttm_atan_middle(a, b, ratio) : ttm_atan_steep(b / a);
  }
  if (!left) return ttm_with_sign_of(arc.hi + (arc.s + arc.rest), y);
  ttm_pair base = ttm_fast_two_sum(3.1415926535897931, -arc.hi);
  return ttm_with_sign_of(base.hi - (arc.s + (arc.rest - (base.lo + 1.2246467991473532e-16))), y);
}

static inline double ttm_asin_rest(double z) {
  double z2 = ttm_mul(z, z), z4 = ttm_mul(z2, z2), z8 = ttm_mul(z4, z4);
  double p = (0.16666666666666763 + ttm_mul(0.074999999999702624, z)) +
             ttm_mul(z2, 0.044642857175120197 + ttm_mul(0.030381942683649504, z));
  double q = (0.022372215659390616 + ttm_mul(0.01735160010729471, z)) +
             ttm_mul(z2, 0.013980961283868752 + ttm_mul(0.01139777718601169, z));
  double r = (0.010786523358220978 + ttm_mul(0.0036830596820055005, z)) +
             ttm_mul(z2, 0.02176346482756809 + ttm_mul(-0.021077254975695479, z));
  return ttm_mul(z, (p + ttm_mul(z4, q)) + ttm_mul(z8, r + ttm_mul(z4, 0.032676872808444273)));
}
// asin(sqrt z), 0 < z < 1/4, as root + rest.
static inline ttm_pair ttm_asin_root(double z) {
  ttm_pair result;
  result.hi = ttm_sqrt(z);
  ttm_pair square = ttm_mul_pair(result.hi, result.hi);
  result.lo = ((z - square.hi) - square.lo) / (result.hi + result.hi) + ttm_mul(result.hi, ttm_asin_rest(z));
  return result;
}

static inline double ticktrue_asin(double x) {
  double magnitude = ttm_abs(x);
  if (magnitude <= 0.5) {
    if (magnitude < 7.450580596923828e-09) return x;
    return x + ttm_mul(x, ttm_asin_rest(ttm_mul(x, x)));
  }
  if (!(magnitude < 1.0)) return magnitude == 1.0 ? ttm_with_sign_of(1.5707963267948966, x) : ttm_nan();
  ttm_pair root = ttm_asin_root(ttm_mul(0.5, 1.0 - magnitude));
  ttm_pair sum = ttm_fast_two_sum(1.5707963267948966, ttm_mul(-2.0, root.hi));
  return ttm_with_sign_of(sum.hi + ((sum.lo + 6.123233995736766e-17) - ttm_mul(2.0, root.lo)), x);
}
static inline double ticktrue_acos(double x) {
  double magnitude = ttm_abs(x);
  if (magnitude <= 0.5) {
    ttm_pair sum = ttm_fast_two_sum(1.5707963267948966, -x);
    if (magnitude < 6.9388939039072284e-18) return 1.5707963267948966;  // 2^-57
    return sum.hi + ((sum.lo + 6.123233995736766e-17) - ttm_mul(x, ttm_asin_rest(ttm_mul(x, x))));
  }
  if (!(magnitude < 1.0)) return magnitude == 1.0 ? (x > 0.0 ? 0.0 : 3.1415926535897931) : ttm_nan();
  ttm_pair root = ttm_asin_root(ttm_mul(0.5, 1.0 - magnitude));
  if (x > 0.0) return ttm_mul(2.0, root.hi + root.lo);
  ttm_pair sum = ttm_fast_two_sum(3.1415926535897931, ttm_mul(-2.0, root.hi));
  return sum.hi + ((sum.lo + 1.2246467991473532e-16) - ttm_mul(2.0, root.lo));
}

// atan(q) - q relative to q^3, with an error of 2^-34 of q. 0 <= q <= 1.
static inline double ttm_atan_f32(double q) {
  double z = ttm_mul(q, q), z2 = ttm_mul(z, z), z4 = ttm_mul(z2, z2), z8 = ttm_mul(z4, z4);
  double a = (-0.33333332235360047 + ttm_mul(0.19999932196925113, z)) +
             ttm_mul(z2, -0.14284250835159112 + ttm_mul(0.11095202095659647, z));
  double b = (-0.089887900765057746 + ttm_mul(0.072693778217999119, z)) +
             ttm_mul(z2, -0.054704359321404709 + ttm_mul(0.034704499437939212, z));
  double c = (-0.016471336820692219 + ttm_mul(0.0049992659253692822, z)) + ttm_mul(z2, -0.00071129555370954818);
  return q + ttm_mul(ttm_mul(q, z), (a + ttm_mul(z4, b)) + ttm_mul(z8, c));
}
static inline float ticktrue_atanf(float x) {
  double magnitude = ttm_abs((double)x);
  if (x != x) return ttm_nan_f32();
  if (magnitude < 6.103515625e-05) return x;  // 2^-14
  double result = magnitude > 1.0 ? 1.5707963267948966 - ttm_atan_f32(1.0 / magnitude) : ttm_atan_f32(magnitude);
  return (float)ttm_with_sign_of(result, (double)x);
}
static inline float ticktrue_atan2f(float y, float x) {
  if (x != x || y != y) return ttm_nan_f32();
  double a = ttm_abs((double)y), b = ttm_abs((double)x), result;
  unsigned left = ttm_bits_f32(x) >> 31;
  if (a == b) {
    result = a == 0.0 ? 0.0 : 0.78539816339744828;
  } else {
    result = a > b ? 1.5707963267948966 - ttm_atan_f32(b / a) : ttm_atan_f32(a / b);
  }
  if (left) result = 3.1415926535897931 - result;
  return ticktrue_copysignf((float)result, y);
}

static inline double ttm_asin_rest_f32(double z) {
  double z2 = ttm_mul(z, z), z4 = ttm_mul(z2, z2);
  double p = (0.16666667189824752 + ttm_mul(0.074999481570465473, z)) +
             ttm_mul(z2, 0.044660163318584627 + ttm_mul(0.030110255256954526, z));
  double q = (0.024618348352862165 + ttm_mul(0.0074691667947384167, z)) + ttm_mul(z2, 0.034692923365238805);
  return ttm_mul(z, p + ttm_mul(z4, q));
}
// asin of 0 .. 1 in double.
static inline double ttm_acos_f32(double x) {  // of 0.5 .. 1
  double z = ttm_mul(0.5, 1.0 - x), root = ttm_sqrt(z);
  return ttm_mul(2.0, root + ttm_mul(root, ttm_asin_rest_f32(z)));
}
static inline float ticktrue_asinf(float x) {
  double wide = (double)x, magnitude = ttm_abs(wide);
  if (magnitude <= 0.5) {
    if (magnitude < 6.103515625e-05) return x;
    return (float)(wide + ttm_mul(wide, ttm_asin_rest_f32(ttm_mul(wide, wide))));
  }
  if (!(magnitude <= 1.0)) return ttm_nan_f32();
  return (float)ttm_with_sign_of(1.5707963267948966 - ttm_acos_f32(magnitude), wide);
}
static inline float ticktrue_acosf(float x) {
  double wide = (double)x, magnitude = ttm_abs(wide);
  if (magnitude <= 0.5)
    return (float)(1.5707963267948966 - (wide + ttm_mul(wide, ttm_asin_rest_f32(ttm_mul(wide, wide)))));
  if (!(magnitude <= 1.0)) return ttm_nan_f32();
  return (float)(x > 0.0f ? ttm_acos_f32(magnitude) : 3.1415926535897931 - ttm_acos_f32(magnitude));
}

// --- random numbers -------------------------------------------------------------------------------------------------

// PCG32: 16 bytes, a part of the simulation's state. Seed and stream give 2^63 sequences of 2^64 numbers.
// Source: O'Neill, "PCG: a family of simple fast space-efficient statistically good algorithms", 2014 (XSH RR 64/32).
typedef struct ticktrue_random {
  uint64_t state;
  uint64_t increment;  // odd
} ticktrue_random;

// 0 .. 2^32 - 1, all equally likely.
static inline uint32_t ticktrue_random_u32(ticktrue_random* random) {
  uint64_t old = random->state;
  random->state = old * 6364136223846793005u + random->increment;
  uint32_t mixed = (uint32_t)(((old >> 18) ^ old) >> 27), turn = (uint32_t)(old >> 59);
  return (mixed >> turn) | (mixed << ((0u - turn) & 31u));
}
static inline ticktrue_random ticktrue_random_seeded(uint64_t seed, uint64_t stream) {
  ticktrue_random random;
  random.state = 0;
  random.increment = (stream << 1) | 1u;
  (void)ticktrue_random_u32(&random);
  random.state += seed;
  (void)ticktrue_random_u32(&random);
  return random;
}
// The number drawn first is the upper half.
static inline uint64_t ticktrue_random_u64(ticktrue_random* random) {
  uint64_t upper = ticktrue_random_u32(random);
  return (upper << 32) | ticktrue_random_u32(random);
}
// 0 .. count - 1, without bias; 0 if count is 0. A second draw is needed with a probability below 1/2.
// Source: Lemire, "Fast random integer generation in an interval", 2019.
static inline uint32_t ticktrue_random_below(ticktrue_random* random, uint32_t count) {
  uint64_t product = (uint64_t)ticktrue_random_u32(random) * count;
  if ((uint32_t)product < count) {
    uint32_t least = (0u - count) % count;
    while ((uint32_t)product < least) product = (uint64_t)ticktrue_random_u32(random) * count;
  }
  return (uint32_t)(product >> 32);
}
// low .. high, inclusive. Requires: low <= high.
static inline int32_t ticktrue_random_between(ticktrue_random* random, int32_t low, int32_t high) {
  uint32_t count = (uint32_t)high - (uint32_t)low + 1u;
  uint32_t offset = count == 0 ? ticktrue_random_u32(random) : ticktrue_random_below(random, count);
  return (int32_t)((uint32_t)low + offset);
}
// 0 <= value < 1, a multiple of 2^-24.
static inline float ticktrue_random_float(ticktrue_random* random) {
  return (float)(int32_t)(ticktrue_random_u32(random) >> 8) * 5.9604644775390625e-08f;
}
// 0 <= value < 1, a multiple of 2^-53.
static inline double ticktrue_random_double(ticktrue_random* random) {
  return ttm_mul((double)(int64_t)(ticktrue_random_u64(random) >> 11), 1.1102230246251565e-16);
}

// --- sorting --------------------------------------------------------------------------------------------------------

// Keys whose order as unsigned numbers is the total order. (Without a branch on the sign: g++ 12.2 for aarch64 -O1
// compares the keys as signed numbers if they are chosen by ?: and compared by (x > y) - (x < y) < 0.)
static inline uint64_t ttm_order_key(double a) {
  uint64_t bits = ttm_bits(a);
  return bits ^ (((uint64_t)0 - (bits >> 63)) | TTM_SIGN);
}
static inline uint32_t ttm_order_key_f32(float a) {
  uint32_t bits = ttm_bits_f32(a);
  return bits ^ (((uint32_t)0 - (bits >> 31)) | 0x80000000u);
}
// IEEE 754 totalOrder: -1, 0 or 1. -NaN < -infinity < ... < -0 < 0 < ... < infinity < NaN; 0 only for the same bits.
static inline int ticktrue_total_order(double a, double b) {
  uint64_t x = ttm_order_key(a), y = ttm_order_key(b);
  return (x > y) - (x < y);
}
static inline int ticktrue_total_orderf(float a, float b) {
  uint32_t x = ttm_order_key_f32(a), y = ttm_order_key_f32(b);
  return (x > y) - (x < y);
}

// < 0: a is before b; > 0: after; 0: they keep their order.
typedef int (*ticktrue_compare)(const void* a, const void* b, void* user);

// Stable: rows that compare equal keep their order. So the result depends only on rows and comparison.
// `buffer`: capacity for count rows of `size` bytes.
static inline void ticktrue_sort(void* rows, size_t count, size_t size, ticktrue_compare compare, void* user,
                                 void* buffer) {
  unsigned char *from = (unsigned char*)rows, *to = (unsigned char*)buffer;
  size_t width, begin;
  for (width = 1; width<count; width = width> count / 2 ? count : 2 * width) {
    for (begin = 0; begin < count;) {
      size_t middle = count - begin < width ? count : begin + width;
      size_t end = count - middle < width ? count : middle + width;
      size_t left = begin, right = middle, out = begin;
      if (middle < end && compare(from + size * (middle - 1), from + size * middle, user) > 0) {
        while (left < middle && right < end) {
          size_t* next = compare(from + size * left, from + size * right, user) > 0 ? &right : &left;
          memcpy(to + size * out++, from + size * (*next)++, size);
        }
      }
      memcpy(to + size * out, from + size * left, size * (middle - left));
      out += middle - left;
      memcpy(to + size * out, from + size * right, size * (end - right));
      begin = end;
    }
    unsigned char* swapped = from;
    from = to;
    to = swapped;
  }
  if (from != (unsigned char*)rows) memcpy(rows, from, size * count);
}

#if defined(__GNUC__) || defined(__clang__)
#pragma GCC diagnostic pop
#endif

#ifdef __cplusplus
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>
#include <vector>

namespace ticktrue {
namespace math {

#define TTM_ONE_ARGUMENT(name)          \
  static inline float name(float x) {   \
    return ticktrue_##name##f(x);       \
  }                                     \
  static inline double name(double x) { \
    return ticktrue_##name(x);          \
  }
#define TTM_TWO_ARGUMENTS(name)                   \
  static inline float name(float x, float y) {    \
    return ticktrue_##name##f(x, y);              \
  }                                               \
  static inline double name(double x, double y) { \
    return ticktrue_##name(x, y);                 \
  }
TTM_ONE_ARGUMENT(sin)
TTM_ONE_ARGUMENT(cos)
TTM_ONE_ARGUMENT(tan)
TTM_ONE_ARGUMENT(asin)
TTM_ONE_ARGUMENT(acos)
TTM_ONE_ARGUMENT(atan)
TTM_ONE_ARGUMENT(exp)
TTM_ONE_ARGUMENT(log)
TTM_ONE_ARGUMENT(sqrt)
TTM_ONE_ARGUMENT(fabs)
TTM_ONE_ARGUMENT(floor)
TTM_ONE_ARGUMENT(ceil)
TTM_ONE_ARGUMENT(trunc)
TTM_ONE_ARGUMENT(round)
TTM_ONE_ARGUMENT(rint)
TTM_TWO_ARGUMENTS(atan2)
TTM_TWO_ARGUMENTS(pow)
TTM_TWO_ARGUMENTS(hypot)
TTM_TWO_ARGUMENTS(fmod)
TTM_TWO_ARGUMENTS(remainder)
TTM_TWO_ARGUMENTS(copysign)
#undef TTM_ONE_ARGUMENT
#undef TTM_TWO_ARGUMENTS
static inline void sincos(float x, float& sine, float& cosine) {
  ticktrue_sincosf(x, &sine, &cosine);
}
static inline void sincos(double x, double& sine, double& cosine) {
  ticktrue_sincos(x, &sine, &cosine);
}

// `ticktrue_random` as an object. It is also a generator for std::shuffle and others, whose results differ between
// libraries.
class Random {
 public:
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0) : state(ticktrue_random_seeded(seed, stream)) {}
  std::uint32_t u32() { return ticktrue_random_u32(&state); }
  std::uint64_t u64() { return ticktrue_random_u64(&state); }
  std::uint32_t below(std::uint32_t count) { return ticktrue_random_below(&state, count); }
  std::int32_t between(std::int32_t low, std::int32_t high) { return ticktrue_random_between(&state, low, high); }
  float unit_float() { return ticktrue_random_float(&state); }
  double unit_double() { return ticktrue_random_double(&state); }

  ticktrue_random state;
};

// All orders of the rows are equally likely. At most 2^32 - 1 rows.
template <class Iterator>
void shuffle(Iterator first, Iterator last, Random& random) {
  using Distance = typename std::iterator_traits<Iterator>::difference_type;
  for (Distance left = last - first; left > 1; --left) {
    using std::swap;
    swap(first[left - 1], first[static_cast<Distance>(random.below(static_cast<std::uint32_t>(left)))]);
  }
}

// < for all types, but the total order for float and double.
struct TotalLess {
  template <class T>
  bool operator()(const T& a, const T& b) const {
    return a < b;
  }
  bool operator()(float a, float b) const { return ttm_order_key_f32(a) < ttm_order_key_f32(b); }
  bool operator()(double a, double b) const { return ttm_order_key(a) < ttm_order_key(b); }
};

// Stable, as ticktrue_sort. Rows must be movable and default-constructible.
template <class Iterator, class Less>
void sort(Iterator first, Iterator last, Less less) {
  using Row = typename std::iterator_traits<Iterator>::value_type;
  using Distance = typename std::iterator_traits<Iterator>::difference_type;
  const Distance count = last - first, run = 12;
  for (Distance begin = 0; begin < count; begin += run)
    for (Distance i = begin + 1; i < begin + run && i < count; ++i) {
      Row row = std::move(first[i]);
      Distance hole = i;
      for (; hole > begin && less(row, first[hole - 1]); --hole) first[hole] = std::move(first[hole - 1]);
      first[hole] = std::move(row);
    }
  if (count <= run) return;
  std::vector<Row> buffer(static_cast<std::size_t>((count + 1) / 2 > run ? count : run));
  for (Distance width = run; width < count; width *= 2)
    for (Distance begin = 0; count - begin > width; begin += 2 * width) {
      const Distance middle = begin + width, end = count - middle > width ? middle + width : count;
      if (!less(first[middle], first[middle - 1])) continue;
      // The left half moves out; the merge fills from its place.
      typename std::vector<Row>::iterator left = buffer.begin(), left_end = left + width;
      for (Distance i = 0; i < width; ++i) left[i] = std::move(first[begin + i]);
      Distance right = middle, out = begin;
      while (left != left_end && right < end)
        first[out++] = less(first[right], *left) ? std::move(first[right++]) : std::move(*left++);
      while (left != left_end) first[out++] = std::move(*left++);
    }
}
template <class Iterator>
void sort(Iterator first, Iterator last) {
  ::ticktrue::math::sort(first, last, TotalLess());
}

}  // namespace math
}  // namespace ticktrue
#endif
