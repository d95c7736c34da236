// Wide: as many Reals as a vector register of the target holds, with the operators of Real.
// SPDX-License-Identifier: MIT
//
// Element-wise operations give each lane the bits that scalar code would give it, so the width changes no result.
// Everything here is in a namespace of its instruction set, and no standard header with code in it is included: what is
// compiled for AVX2 never stands in for what is compiled for every machine.
#pragma once

#include <cstring>

#include "engine/math/scalar.h"

#if !defined(TICKTRUE_ISA)
#define TICKTRUE_ISA baseline
#endif

/// For the parts of a kernel: what they share stays in registers.
#define TICKTRUE_INLINE inline __attribute__((always_inline))

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {

#if defined(__AVX__)
inline constexpr int wide_size = 32;  // bytes
#else
inline constexpr int wide_size = 16;
#endif
inline constexpr int wide_count = wide_size / static_cast<int>(sizeof(Real));

using Wide = Real __attribute__((vector_size(wide_size)));

TICKTRUE_INLINE Wide load_wide(const Real* from) {
  Wide value;
  std::memcpy(&value, from, sizeof value);
  return value;
}
TICKTRUE_INLINE void store_wide(Real* to, Wide value) {
  std::memcpy(to, &value, sizeof value);
}
TICKTRUE_INLINE Wide spread(Real value) {
  return value - Wide{};
}
TICKTRUE_INLINE Wide larger(Wide a, Wide b) {
  return a > b ? a : b;
}
TICKTRUE_INLINE Wide smaller(Wide a, Wide b) {
  return a < b ? a : b;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
