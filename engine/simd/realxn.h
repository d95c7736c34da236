// RealxN: a vector register of Reals, with the operators of Real.
// SPDX-License-Identifier: MIT
//
// The vector types are named Realx<lanes>: Realx4 has four lanes, RealxN those of a register, Realx2N those of two
// registers. An element-wise operation gives each lane the bits of scalar code, so the number of lanes changes no
// result. All names are in a namespace of the instruction set, and no standard header with code is included. Therefore
// the linker cannot replace a function compiled for every machine by one compiled for AVX2.
#pragma once

#include <cstring>

#include "engine/math/scalar.h"

#if !defined(TICKTRUE_ISA)
#define TICKTRUE_ISA baseline
#endif

/// For the parts of a kernel, so that shared values stay in registers.
#define TICKTRUE_INLINE inline __attribute__((always_inline))

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {

#if defined(__AVX__)
inline constexpr int simd_size = 32;  // bytes
#else
inline constexpr int simd_size = 16;
#endif
inline constexpr int simd_width = simd_size / static_cast<int>(sizeof(Real));  // lanes

using RealxN = Real __attribute__((vector_size(simd_size)));

TICKTRUE_INLINE RealxN load_xn(const Real* from) {
  RealxN value;
  std::memcpy(&value, from, sizeof value);
  return value;
}
TICKTRUE_INLINE void store_xn(Real* to, RealxN value) {
  std::memcpy(to, &value, sizeof value);
}
TICKTRUE_INLINE RealxN broadcast(Real value) {
  return value - RealxN{};
}
TICKTRUE_INLINE RealxN larger(RealxN a, RealxN b) {
  return a > b ? a : b;
}
TICKTRUE_INLINE RealxN smaller(RealxN a, RealxN b) {
  return a < b ? a : b;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
