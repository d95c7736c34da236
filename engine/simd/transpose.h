// Gather and scatter: rows of four values in memory become four vectors, one for each column, and back.
// SPDX-License-Identifier: MIT
//
// A load or store moves a whole row. Rows are transposed in registers, so that no lane is moved alone. The next batch
// loads a row with the size of its store, so that the processor can forward the store.
#pragma once

#include "engine/simd/realxn.h"

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {

using Floatx4 = float __attribute__((vector_size(16)));
using Floatx8 = float __attribute__((vector_size(32)));
using Doublex2 = double __attribute__((vector_size(16)));
using Doublex4 = double __attribute__((vector_size(32)));

/// at[i]: value i of the rows, one row per lane of V.
template <typename V>
struct Columns4 {
  V at[4];
};
using Columns4xN = Columns4<RealxN>;

template <typename Scalar, int count>
struct Transposer;

#if defined(__AVX__)
/// The halves of a register are inserted and extracted by intrinsics, which compilers merge with loads and stores.
template <>
struct Transposer<float, 8> {
  TICKTRUE_INLINE static Floatx4 load(const float* from) {
    Floatx4 row;
    std::memcpy(&row, from, sizeof row);
    return row;
  }
  /// place(i): the begin of record i's row.
  template <typename Place>
  TICKTRUE_INLINE static void gather(Place place, Floatx8* out) {
    const auto pair = [&place](int low, int high) {
      const Floatx4 half = load(place(low));
      const Floatx8 wide = __builtin_shufflevector(half, half, 0, 1, 2, 3, -1, -1, -1, -1);
      return __builtin_ia32_vinsertf128_ps256(wide, load(place(high)), 1);
    };
    const Floatx8 r0 = pair(0, 4), r1 = pair(1, 5), r2 = pair(2, 6), r3 = pair(3, 7);
    const Floatx8 low_01 = __builtin_shufflevector(r0, r1, 0, 8, 1, 9, 4, 12, 5, 13);
    const Floatx8 low_23 = __builtin_shufflevector(r2, r3, 0, 8, 1, 9, 4, 12, 5, 13);
    const Floatx8 high_01 = __builtin_shufflevector(r0, r1, 2, 10, 3, 11, 6, 14, 7, 15);
    const Floatx8 high_23 = __builtin_shufflevector(r2, r3, 2, 10, 3, 11, 6, 14, 7, 15);
    out[0] = __builtin_shufflevector(low_01, low_23, 0, 1, 8, 9, 4, 5, 12, 13);
    out[1] = __builtin_shufflevector(low_01, low_23, 2, 3, 10, 11, 6, 7, 14, 15);
    out[2] = __builtin_shufflevector(high_01, high_23, 0, 1, 8, 9, 4, 5, 12, 13);
    out[3] = __builtin_shufflevector(high_01, high_23, 2, 3, 10, 11, 6, 7, 14, 15);
  }
  template <typename Place>
  TICKTRUE_INLINE static void scatter(Place place, const Floatx8* in) {
    const auto pair = [&place](int low, int high, const Floatx8& both) {
      const Floatx4 first = __builtin_shufflevector(both, both, 0, 1, 2, 3);
      const Floatx4 second = __builtin_ia32_vextractf128_ps256(both, 1);
      std::memcpy(place(low), &first, sizeof first);
      std::memcpy(place(high), &second, sizeof second);
    };
    const Floatx8 low_01 = __builtin_shufflevector(in[0], in[1], 0, 8, 1, 9, 4, 12, 5, 13);
    const Floatx8 high_01 = __builtin_shufflevector(in[0], in[1], 2, 10, 3, 11, 6, 14, 7, 15);
    const Floatx8 low_23 = __builtin_shufflevector(in[2], in[3], 0, 8, 1, 9, 4, 12, 5, 13);
    const Floatx8 high_23 = __builtin_shufflevector(in[2], in[3], 2, 10, 3, 11, 6, 14, 7, 15);
    pair(0, 4, __builtin_shufflevector(low_01, low_23, 0, 1, 8, 9, 4, 5, 12, 13));
    pair(1, 5, __builtin_shufflevector(low_01, low_23, 2, 3, 10, 11, 6, 7, 14, 15));
    pair(2, 6, __builtin_shufflevector(high_01, high_23, 0, 1, 8, 9, 4, 5, 12, 13));
    pair(3, 7, __builtin_shufflevector(high_01, high_23, 2, 3, 10, 11, 6, 7, 14, 15));
  }
};
#endif

/// Four rows of four values: vectors of 16 bytes in f32, of 32 bytes in f64.
template <typename Row4, bool is_single>
struct SquareTransposer {
  TICKTRUE_INLINE static void transpose(const Row4* in, Row4* out) {
    if constexpr (is_single) {
      const Row4 low_01 = __builtin_shufflevector(in[0], in[1], 0, 4, 1, 5);
      const Row4 low_23 = __builtin_shufflevector(in[2], in[3], 0, 4, 1, 5);
      const Row4 high_01 = __builtin_shufflevector(in[0], in[1], 2, 6, 3, 7);
      const Row4 high_23 = __builtin_shufflevector(in[2], in[3], 2, 6, 3, 7);
      out[0] = __builtin_shufflevector(low_01, low_23, 0, 1, 4, 5);
      out[1] = __builtin_shufflevector(low_01, low_23, 2, 3, 6, 7);
      out[2] = __builtin_shufflevector(high_01, high_23, 0, 1, 4, 5);
      out[3] = __builtin_shufflevector(high_01, high_23, 2, 3, 6, 7);
    } else {
      const Row4 even_01 = __builtin_shufflevector(in[0], in[1], 0, 4, 2, 6);
      const Row4 even_23 = __builtin_shufflevector(in[2], in[3], 0, 4, 2, 6);
      const Row4 odd_01 = __builtin_shufflevector(in[0], in[1], 1, 5, 3, 7);
      const Row4 odd_23 = __builtin_shufflevector(in[2], in[3], 1, 5, 3, 7);
      out[0] = __builtin_shufflevector(even_01, even_23, 0, 1, 4, 5);
      out[1] = __builtin_shufflevector(odd_01, odd_23, 0, 1, 4, 5);
      out[2] = __builtin_shufflevector(even_01, even_23, 2, 3, 6, 7);
      out[3] = __builtin_shufflevector(odd_01, odd_23, 2, 3, 6, 7);
    }
  }
  template <typename Place>
  TICKTRUE_INLINE static void gather(Place place, Row4* out) {
    Row4 rows[4];
    for (int i = 0; i < 4; ++i) std::memcpy(&rows[i], place(i), sizeof(Row4));
    transpose(rows, out);
  }
  template <typename Place>
  TICKTRUE_INLINE static void scatter(Place place, const Row4* in) {
    Row4 rows[4];
    transpose(in, rows);
    for (int i = 0; i < 4; ++i) std::memcpy(place(i), &rows[i], sizeof(Row4));
  }
};

template <>
struct Transposer<float, 4> : SquareTransposer<Floatx4, true> {};
template <>
struct Transposer<double, 4> : SquareTransposer<Doublex4, false> {};

template <>
struct Transposer<double, 2> {
  template <typename Place>
  TICKTRUE_INLINE static void gather(Place place, Doublex2* out) {
    for (int half = 0; half < 2; ++half) {
      Doublex2 first, second;
      std::memcpy(&first, place(0) + 2 * half, sizeof first);
      std::memcpy(&second, place(1) + 2 * half, sizeof second);
      out[2 * half] = __builtin_shufflevector(first, second, 0, 2);
      out[2 * half + 1] = __builtin_shufflevector(first, second, 1, 3);
    }
  }
  template <typename Place>
  TICKTRUE_INLINE static void scatter(Place place, const Doublex2* in) {
    for (int half = 0; half < 2; ++half) {
      const Doublex2 first = __builtin_shufflevector(in[2 * half], in[2 * half + 1], 0, 2);
      const Doublex2 second = __builtin_shufflevector(in[2 * half], in[2 * half + 1], 1, 3);
      std::memcpy(place(0) + 2 * half, &first, sizeof first);
      std::memcpy(place(1) + 2 * half, &second, sizeof second);
    }
  }
};

/// The rows that begin at rows[index[i] * stride].
template <int stride>
TICKTRUE_INLINE Columns4xN gather4(const Real* rows, const std::uint32_t* index) {
  Columns4xN columns;
  Transposer<Real, simd_width>::gather([&](int i) { return rows + static_cast<std::size_t>(index[i]) * stride; },
                                       columns.at);
  return columns;
}
template <int stride>
TICKTRUE_INLINE void scatter4(Real* rows, const std::uint32_t* index, const Columns4xN& columns) {
  Transposer<Real, simd_width>::scatter([&](int i) { return rows + static_cast<std::size_t>(index[i]) * stride; },
                                        columns.at);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
