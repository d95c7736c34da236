// Realx2N: two registers of Reals, used as one vector. Each lane gets the same bits as in RealxN.
// SPDX-License-Identifier: MIT
//
// A chain of dependent operations leaves half of the processor idle. Two independent chains use the whole processor.
#pragma once

#include "engine/simd/transpose.h"

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {

using MaskxN = decltype(RealxN{} > RealxN{});

struct Realx2N {
  RealxN at[2];
};
struct Maskx2N {
  MaskxN at[2];
};

TICKTRUE_INLINE Realx2N operator+(Realx2N a, Realx2N b) {
  return {a.at[0] + b.at[0], a.at[1] + b.at[1]};
}
TICKTRUE_INLINE Realx2N operator-(Realx2N a, Realx2N b) {
  return {a.at[0] - b.at[0], a.at[1] - b.at[1]};
}
TICKTRUE_INLINE Realx2N operator*(Realx2N a, Realx2N b) {
  return {a.at[0] * b.at[0], a.at[1] * b.at[1]};
}
TICKTRUE_INLINE Realx2N operator/(Realx2N a, Realx2N b) {
  return {a.at[0] / b.at[0], a.at[1] / b.at[1]};
}
TICKTRUE_INLINE Realx2N operator-(Realx2N a) {
  return {-a.at[0], -a.at[1]};
}
TICKTRUE_INLINE Realx2N& operator+=(Realx2N& a, Realx2N b) {
  return a = a + b;
}
TICKTRUE_INLINE Realx2N& operator-=(Realx2N& a, Realx2N b) {
  return a = a - b;
}
TICKTRUE_INLINE Maskx2N operator>(Realx2N a, Realx2N b) {
  return {a.at[0] > b.at[0], a.at[1] > b.at[1]};
}
TICKTRUE_INLINE Realx2N larger(Realx2N a, Realx2N b) {
  return {larger(a.at[0], b.at[0]), larger(a.at[1], b.at[1])};
}
TICKTRUE_INLINE Realx2N smaller(Realx2N a, Realx2N b) {
  return {smaller(a.at[0], b.at[0]), smaller(a.at[1], b.at[1])};
}
TICKTRUE_INLINE RealxN select(MaskxN mask, RealxN a, RealxN b) {
  return mask ? a : b;
}
TICKTRUE_INLINE Realx2N select(Maskx2N mask, Realx2N a, Realx2N b) {
  return {select(mask.at[0], a.at[0], b.at[0]), select(mask.at[1], a.at[1], b.at[1])};
}

// The same function for one lane, a Real.
TICKTRUE_INLINE Real larger(Real a, Real b) {
  return a > b ? a : b;
}
TICKTRUE_INLINE Real smaller(Real a, Real b) {
  return a < b ? a : b;
}
TICKTRUE_INLINE Real select(bool condition, Real a, Real b) {
  return condition ? a : b;
}

/// Types and functions that let one template serve Real, RealxN and Realx2N.
template <typename Vector>
struct SimdTraits;

template <>
struct SimdTraits<Real> {
  static constexpr int count = 1;
  TICKTRUE_INLINE static Real load(const Real* from) { return *from; }
  TICKTRUE_INLINE static void store(Real* to, Real value) { *to = value; }
  TICKTRUE_INLINE static Real broadcast(Real value) { return value; }
};

template <>
struct SimdTraits<RealxN> {
  static constexpr int count = simd_width;
  TICKTRUE_INLINE static RealxN load(const Real* from) { return load_xn(from); }
  TICKTRUE_INLINE static void store(Real* to, RealxN value) { store_xn(to, value); }
  TICKTRUE_INLINE static RealxN broadcast(Real value) { return TICKTRUE_ISA::broadcast(value); }
};

template <>
struct SimdTraits<Realx2N> {
  static constexpr int count = 2 * simd_width;
  TICKTRUE_INLINE static Realx2N load(const Real* from) { return {load_xn(from), load_xn(from + simd_width)}; }
  TICKTRUE_INLINE static void store(Real* to, Realx2N value) {
    store_xn(to, value.at[0]);
    store_xn(to + simd_width, value.at[1]);
  }
  TICKTRUE_INLINE static Realx2N broadcast(Real value) {
    return {TICKTRUE_ISA::broadcast(value), TICKTRUE_ISA::broadcast(value)};
  }
};

/// A row of four values in the number of registers that it needs.
inline constexpr int row_part_length = simd_width < 4 ? simd_width : 4;
using RowPart = Real __attribute__((vector_size(row_part_length * sizeof(Real))));

/// The rows that begin at rows[index[i] * stride], for any V.
template <typename V, int stride>
TICKTRUE_INLINE Columns4<V> gather4(const Real* rows, const std::uint32_t* index) {
  if constexpr (SimdTraits<V>::count == 1) {
    Columns4<V> columns;
    RowPart part[4 / row_part_length];
    std::memcpy(part, rows + static_cast<std::size_t>(index[0]) * stride, sizeof part);
    for (int i = 0; i < 4; ++i) columns.at[i] = part[i / row_part_length][i % row_part_length];
    return columns;
  } else if constexpr (SimdTraits<V>::count == simd_width) {
    return gather4<stride>(rows, index);
  } else {
    Columns4<V> columns;
    const Columns4xN low = gather4<stride>(rows, index);
    const Columns4xN high = gather4<stride>(rows, index + simd_width);
    for (int i = 0; i < 4; ++i) columns.at[i] = {{low.at[i], high.at[i]}};
    return columns;
  }
}
template <typename V, int stride>
TICKTRUE_INLINE void scatter4(Real* rows, const std::uint32_t* index, const Columns4<V>& columns) {
  if constexpr (SimdTraits<V>::count == 1) {
    RowPart part[4 / row_part_length];
    for (int i = 0; i < 4; ++i) part[i / row_part_length][i % row_part_length] = columns.at[i];
    std::memcpy(rows + static_cast<std::size_t>(index[0]) * stride, part, sizeof part);
  } else if constexpr (SimdTraits<V>::count == simd_width) {
    scatter4<stride>(rows, index, columns);
  } else {
    for (int half = 0; half < 2; ++half)
      scatter4<stride>(
          rows, index + half * simd_width,
          {{columns.at[0].at[half], columns.at[1].at[half], columns.at[2].at[half], columns.at[3].at[half]}});
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
