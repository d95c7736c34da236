// Twin: two Wides side by side. A chain of operations that waits for its own results leaves half of the machine idle;
// two such chains at once fill it. Each lane gets the bits that Wide gives it.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/simd/quads.h"

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
TICKTRUE_INLINE Twin operator/(Twin a, Twin b) {
  return {a.at[0] / b.at[0], a.at[1] / b.at[1]};
}
TICKTRUE_INLINE Twin operator-(Twin a) {
  return {-a.at[0], -a.at[1]};
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

// A single lane is a Real.
TICKTRUE_INLINE Real larger(Real a, Real b) {
  return a > b ? a : b;
}
TICKTRUE_INLINE Real smaller(Real a, Real b) {
  return a < b ? a : b;
}
TICKTRUE_INLINE Real choose(bool condition, Real a, Real b) {
  return condition ? a : b;
}

/// What kernels need to know of Real, Wide and Twin, to be written once.
template <typename Vector>
struct VectorOf;

template <>
struct VectorOf<Real> {
  static constexpr int count = 1;
  TICKTRUE_INLINE static Real load(const Real* from) { return *from; }
  TICKTRUE_INLINE static void store(Real* to, Real value) { *to = value; }
  TICKTRUE_INLINE static Real spread(Real value) { return value; }
};

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

/// A quad in as many registers as it takes: loaded and stored whole, as other batches do (quads.h).
inline constexpr int quad_part_length = wide_count < 4 ? wide_count : 4;
using QuadPart = Real __attribute__((vector_size(quad_part_length * sizeof(Real))));

/// As gather_quads.
template <typename V, int stride>
TICKTRUE_INLINE QuadsOf<V> gather_quads_of(const Real* rows, const std::uint32_t* index) {
  QuadsOf<V> quads;
  if constexpr (VectorOf<V>::count == 1) {
    QuadPart part[4 / quad_part_length];
    std::memcpy(part, rows + static_cast<std::size_t>(index[0]) * stride, sizeof part);
    for (int i = 0; i < 4; ++i) quads.at[i] = part[i / quad_part_length][i % quad_part_length];
  } else if constexpr (VectorOf<V>::count == wide_count) {
    const Quads all = gather_quads<stride>(rows, index);
    for (int i = 0; i < 4; ++i) quads.at[i] = all.at[i];
  } else {
    const Quads low = gather_quads<stride>(rows, index);
    const Quads high = gather_quads<stride>(rows, index + wide_count);
    for (int i = 0; i < 4; ++i) quads.at[i] = {{low.at[i], high.at[i]}};
  }
  return quads;
}
/// As scatter_quads.
template <typename V, int stride>
TICKTRUE_INLINE void scatter_quads_of(Real* rows, const std::uint32_t* index, const QuadsOf<V>& quads) {
  if constexpr (VectorOf<V>::count == 1) {
    QuadPart part[4 / quad_part_length];
    for (int i = 0; i < 4; ++i) part[i / quad_part_length][i % quad_part_length] = quads.at[i];
    std::memcpy(rows + static_cast<std::size_t>(index[0]) * stride, part, sizeof part);
  } else if constexpr (VectorOf<V>::count == wide_count) {
    scatter_quads<stride>(rows, index, {{quads.at[0], quads.at[1], quads.at[2], quads.at[3]}});
  } else {
    for (int half = 0; half < 2; ++half)
      scatter_quads<stride>(rows, index + half * wide_count,
                            {{quads.at[0].at[half], quads.at[1].at[half], quads.at[2].at[half], quads.at[3].at[half]}});
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
