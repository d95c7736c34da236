// Wide: as many Reals as a vector register of the target holds, with the operators of Real.
// SPDX-License-Identifier: MIT
//
// Element-wise operations give each lane the bits that scalar code would give it, so the width changes no result.
#pragma once

#include <cstring>

#include "engine/math/real.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

#if defined(__AVX__)
inline constexpr int wide_size = 32;  // bytes
#else
inline constexpr int wide_size = 16;
#endif
inline constexpr int wide_count = wide_size / static_cast<int>(sizeof(Real));

using Wide = Real __attribute__((vector_size(wide_size)));

inline Wide load_wide(const Real* from) {
  Wide value;
  std::memcpy(&value, from, sizeof value);
  return value;
}
inline void store_wide(Real* to, Wide value) {
  std::memcpy(to, &value, sizeof value);
}
inline Wide spread(Real value) {
  return Wide{} + value;
}
inline Wide larger(Wide a, Wide b) {
  return a > b ? a : b;
}
inline Wide smaller(Wide a, Wide b) {
  return a < b ? a : b;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
