// Four values in a row of each of several records, in and out of vectors that hold one value of all records.
// SPDX-License-Identifier: MIT
//
// Loads and stores move whole quads and are transposed in registers: a record written by one batch is read by a later
// one with loads of the same size, and no lane is moved by itself.
#pragma once

#include "engine/simd/wide.h"

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {

/// [0]..[3] of wide_count records.
struct Quads {
  Wide at[4];
};

template <typename Scalar, int count>
struct Transposer;

#if defined(__AVX__)
/// Halves are moved by name: compilers then do it on the way from and to memory.
template <>
struct Transposer<float, 8> {
  using Quad = float __attribute__((vector_size(16)));
  using Row = float __attribute__((vector_size(32)));
  TICKTRUE_INLINE static Quad load(const float* from) {
    Quad quad;
    std::memcpy(&quad, from, sizeof quad);
    return quad;
  }
  /// place(i): where record i's quad begins.
  template <typename Place>
  TICKTRUE_INLINE static void gather(Place place, Row* out) {
    const auto pair = [&place](int low, int high) {
      const Quad half = load(place(low));
      const Row wide = __builtin_shufflevector(half, half, 0, 1, 2, 3, -1, -1, -1, -1);
      return __builtin_ia32_vinsertf128_ps256(wide, load(place(high)), 1);
    };
    const Row r0 = pair(0, 4), r1 = pair(1, 5), r2 = pair(2, 6), r3 = pair(3, 7);
    const Row low_01 = __builtin_shufflevector(r0, r1, 0, 8, 1, 9, 4, 12, 5, 13);
    const Row low_23 = __builtin_shufflevector(r2, r3, 0, 8, 1, 9, 4, 12, 5, 13);
    const Row high_01 = __builtin_shufflevector(r0, r1, 2, 10, 3, 11, 6, 14, 7, 15);
    const Row high_23 = __builtin_shufflevector(r2, r3, 2, 10, 3, 11, 6, 14, 7, 15);
    out[0] = __builtin_shufflevector(low_01, low_23, 0, 1, 8, 9, 4, 5, 12, 13);
    out[1] = __builtin_shufflevector(low_01, low_23, 2, 3, 10, 11, 6, 7, 14, 15);
    out[2] = __builtin_shufflevector(high_01, high_23, 0, 1, 8, 9, 4, 5, 12, 13);
    out[3] = __builtin_shufflevector(high_01, high_23, 2, 3, 10, 11, 6, 7, 14, 15);
  }
  template <typename Place>
  TICKTRUE_INLINE static void scatter(Place place, const Row* in) {
    const auto pair = [&place](int low, int high, const Row& both) {
      const Quad first = __builtin_shufflevector(both, both, 0, 1, 2, 3);
      const Quad second = __builtin_ia32_vextractf128_ps256(both, 1);
      std::memcpy(place(low), &first, sizeof first);
      std::memcpy(place(high), &second, sizeof second);
    };
    const Row low_01 = __builtin_shufflevector(in[0], in[1], 0, 8, 1, 9, 4, 12, 5, 13);
    const Row high_01 = __builtin_shufflevector(in[0], in[1], 2, 10, 3, 11, 6, 14, 7, 15);
    const Row low_23 = __builtin_shufflevector(in[2], in[3], 0, 8, 1, 9, 4, 12, 5, 13);
    const Row high_23 = __builtin_shufflevector(in[2], in[3], 2, 10, 3, 11, 6, 14, 7, 15);
    pair(0, 4, __builtin_shufflevector(low_01, low_23, 0, 1, 8, 9, 4, 5, 12, 13));
    pair(1, 5, __builtin_shufflevector(low_01, low_23, 2, 3, 10, 11, 6, 7, 14, 15));
    pair(2, 6, __builtin_shufflevector(high_01, high_23, 0, 1, 8, 9, 4, 5, 12, 13));
    pair(3, 7, __builtin_shufflevector(high_01, high_23, 2, 3, 10, 11, 6, 7, 14, 15));
  }
};
#endif

/// Four records of four values: in f32 with 16 byte vectors, in f64 with 32 byte ones.
template <typename Quad, bool is_single>
struct SquareTransposer {
  TICKTRUE_INLINE static void transpose(const Quad* in, Quad* out) {
    if constexpr (is_single) {
      const Quad low_01 = __builtin_shufflevector(in[0], in[1], 0, 4, 1, 5);
      const Quad low_23 = __builtin_shufflevector(in[2], in[3], 0, 4, 1, 5);
      const Quad high_01 = __builtin_shufflevector(in[0], in[1], 2, 6, 3, 7);
      const Quad high_23 = __builtin_shufflevector(in[2], in[3], 2, 6, 3, 7);
      out[0] = __builtin_shufflevector(low_01, low_23, 0, 1, 4, 5);
      out[1] = __builtin_shufflevector(low_01, low_23, 2, 3, 6, 7);
      out[2] = __builtin_shufflevector(high_01, high_23, 0, 1, 4, 5);
      out[3] = __builtin_shufflevector(high_01, high_23, 2, 3, 6, 7);
    } else {
      const Quad even_01 = __builtin_shufflevector(in[0], in[1], 0, 4, 2, 6);
      const Quad even_23 = __builtin_shufflevector(in[2], in[3], 0, 4, 2, 6);
      const Quad odd_01 = __builtin_shufflevector(in[0], in[1], 1, 5, 3, 7);
      const Quad odd_23 = __builtin_shufflevector(in[2], in[3], 1, 5, 3, 7);
      out[0] = __builtin_shufflevector(even_01, even_23, 0, 1, 4, 5);
      out[1] = __builtin_shufflevector(odd_01, odd_23, 0, 1, 4, 5);
      out[2] = __builtin_shufflevector(even_01, even_23, 2, 3, 6, 7);
      out[3] = __builtin_shufflevector(odd_01, odd_23, 2, 3, 6, 7);
    }
  }
  template <typename Place>
  TICKTRUE_INLINE static void gather(Place place, Quad* out) {
    Quad rows[4];
    for (int i = 0; i < 4; ++i) std::memcpy(&rows[i], place(i), sizeof(Quad));
    transpose(rows, out);
  }
  template <typename Place>
  TICKTRUE_INLINE static void scatter(Place place, const Quad* in) {
    Quad rows[4];
    transpose(in, rows);
    for (int i = 0; i < 4; ++i) std::memcpy(place(i), &rows[i], sizeof(Quad));
  }
};

using FloatQuad = float __attribute__((vector_size(16)));
using DoubleQuad = double __attribute__((vector_size(32)));
template <>
struct Transposer<float, 4> : SquareTransposer<FloatQuad, true> {};
template <>
struct Transposer<double, 4> : SquareTransposer<DoubleQuad, false> {};

template <>
struct Transposer<double, 2> {
  using Half = double __attribute__((vector_size(16)));
  template <typename Place>
  TICKTRUE_INLINE static void gather(Place place, Half* out) {
    for (int half = 0; half < 2; ++half) {
      Half first, second;
      std::memcpy(&first, place(0) + 2 * half, sizeof first);
      std::memcpy(&second, place(1) + 2 * half, sizeof second);
      out[2 * half] = __builtin_shufflevector(first, second, 0, 2);
      out[2 * half + 1] = __builtin_shufflevector(first, second, 1, 3);
    }
  }
  template <typename Place>
  TICKTRUE_INLINE static void scatter(Place place, const Half* in) {
    for (int half = 0; half < 2; ++half) {
      const Half first = __builtin_shufflevector(in[2 * half], in[2 * half + 1], 0, 2);
      const Half second = __builtin_shufflevector(in[2 * half], in[2 * half + 1], 1, 3);
      std::memcpy(place(0) + 2 * half, &first, sizeof first);
      std::memcpy(place(1) + 2 * half, &second, sizeof second);
    }
  }
};

/// The quads that begin at rows[index[i] * stride].
template <int stride>
TICKTRUE_INLINE Quads gather_quads(const Real* rows, const std::uint32_t* index) {
  Quads quads;
  Transposer<Real, wide_count>::gather([&](int i) { return rows + static_cast<std::size_t>(index[i]) * stride; },
                                       quads.at);
  return quads;
}
template <int stride>
TICKTRUE_INLINE void scatter_quads(Real* rows, const std::uint32_t* index, const Quads& quads) {
  Transposer<Real, wide_count>::scatter([&](int i) { return rows + static_cast<std::size_t>(index[i]) * stride; },
                                        quads.at);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
