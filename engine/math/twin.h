// Twin: two Wides side by side. A chain of operations that waits for its own results leaves half of the machine idle;
// two such chains at once fill it. Each lane gets the bits that Wide gives it.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/math/quads.h"

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {

using WideMask = decltype(Wide{} > Wide{});

struct Twin {
  Wide at[2];
};
struct TwinMask {
  WideMask at[2];
};

TICKTRUE_INLINE Twin operator+(Twin a, Twin b) {
  return {a.at[0] + b.at[0], a.at[1] + b.at[1]};
}
TICKTRUE_INLINE Twin operator-(Twin a, Twin b) {
  return {a.at[0] - b.at[0], a.at[1] - b.at[1]};
}
TICKTRUE_INLINE Twin operator*(Twin a, Twin b) {
  return {a.at[0] * b.at[0], a.at[1] * b.at[1]};
}
TICKTRUE_INLINE Twin& operator+=(Twin& a, Twin b) {
  return a = a + b;
}
TICKTRUE_INLINE Twin& operator-=(Twin& a, Twin b) {
  return a = a - b;
}
TICKTRUE_INLINE TwinMask operator>(Twin a, Twin b) {
  return {a.at[0] > b.at[0], a.at[1] > b.at[1]};
}
TICKTRUE_INLINE Twin larger(Twin a, Twin b) {
  return {larger(a.at[0], b.at[0]), larger(a.at[1], b.at[1])};
}
TICKTRUE_INLINE Twin smaller(Twin a, Twin b) {
  return {smaller(a.at[0], b.at[0]), smaller(a.at[1], b.at[1])};
}
TICKTRUE_INLINE Wide choose(WideMask mask, Wide a, Wide b) {
  return mask ? a : b;
}
TICKTRUE_INLINE Twin choose(TwinMask mask, Twin a, Twin b) {
  return {choose(mask.at[0], a.at[0], b.at[0]), choose(mask.at[1], a.at[1], b.at[1])};
}

/// What kernels need to know of Wide and of Twin, to be written once.
template <typename Vector>
struct VectorOf;

template <>
struct VectorOf<Wide> {
  static constexpr int count = wide_count;
  TICKTRUE_INLINE static Wide load(const Real* from) { return load_wide(from); }
  TICKTRUE_INLINE static void store(Real* to, Wide value) { store_wide(to, value); }
  TICKTRUE_INLINE static Wide spread(Real value) { return TICKTRUE_ISA::spread(value); }
};

template <>
struct VectorOf<Twin> {
  static constexpr int count = 2 * wide_count;
  TICKTRUE_INLINE static Twin load(const Real* from) { return {load_wide(from), load_wide(from + wide_count)}; }
  TICKTRUE_INLINE static void store(Real* to, Twin value) {
    store_wide(to, value.at[0]);
    store_wide(to + wide_count, value.at[1]);
  }
  TICKTRUE_INLINE static Twin spread(Real value) { return {TICKTRUE_ISA::spread(value), TICKTRUE_ISA::spread(value)}; }
};

/// [0]..[3] of as many records as V has lanes.
template <typename V>
struct QuadsOf {
  V at[4];
};

/// As gather_quads.
template <typename V, int stride>
TICKTRUE_INLINE QuadsOf<V> gather_quads_of(const Real* rows, const std::uint32_t* index) {
  const Quads low = gather_quads<stride>(rows, index);
  if constexpr (VectorOf<V>::count == wide_count) {
    return {{low.at[0], low.at[1], low.at[2], low.at[3]}};
  } else {
    const Quads high = gather_quads<stride>(rows, index + wide_count);
    return {
        {{{low.at[0], high.at[0]}}, {{low.at[1], high.at[1]}}, {{low.at[2], high.at[2]}}, {{low.at[3], high.at[3]}}}};
  }
}
/// As scatter_quads.
template <typename V, int stride>
TICKTRUE_INLINE void scatter_quads_of(Real* rows, const std::uint32_t* index, const QuadsOf<V>& quads) {
  if constexpr (VectorOf<V>::count == wide_count) {
    scatter_quads<stride>(rows, index, {{quads.at[0], quads.at[1], quads.at[2], quads.at[3]}});
  } else {
    for (int half = 0; half < 2; ++half)
      scatter_quads<stride>(rows, index + half * wide_count,
                            {{quads.at[0].at[half], quads.at[1].at[half], quads.at[2].at[half], quads.at[3].at[half]}});
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
