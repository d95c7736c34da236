// Stops the compilation where floats would not follow IEEE 754 operation by operation.
// SPDX-License-Identifier: MIT
//
// docs/determinism.md has the reasons.
// base/bytes.h includes this header, so that every object that handles state is checked, and not only one.
// Two things are not checked here. No macro reports fused multiply-add; tests/base/float_rules_test.cpp probes it.
// clang's single flags such as -fassociative-math are refused by name in cmake/refuse_flags.cmake.
#pragma once

#include <cfloat>

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) || \
    defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || defined(__NO_SIGNED_ZEROS__)
#error "fast-math changes results: build without -ffast-math, -Ofast and -funsafe-math-optimizations"
#endif
#if defined(__wasm_simd128__)
#error "WebAssembly's vectors (-msimd128) give other bits in f64 scenes with clang 14: build without them"
#endif
static_assert(FLT_EVAL_METHOD == 0, "floats must be evaluated in their own precision: on i386 use -mfpmath=sse");
static_assert(FLT_RADIX == 2 && FLT_MANT_DIG == 24 && DBL_MANT_DIG == 53, "floats must be IEEE 754 binary32, binary64");
