// The row kernels, compiled once for each instruction set. Only their table is visible outside.
// SPDX-License-Identifier: MIT
// Source: Black et al., "UMAC: Fast and Secure Message Authentication", 1999 (NH, for the sums of products).
#include "base/row_kernels.h"

#include "base/assert.h"

#ifndef TICKTRUE_ISA
#define TICKTRUE_ISA baseline
#endif

#include <string.h>

#ifdef __SSE2__
#include <immintrin.h>
#endif

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace ticktrue::TICKTRUE_ISA {
namespace {

template <std::size_t count>
struct Vectors;
template <>
struct Vectors<4> {
  using Words = std::uint32_t __attribute__((vector_size(16)));
  using Sums = std::uint64_t __attribute__((vector_size(16)));
  /// Words 1 and 3, at the places of words 0 and 2; the other words are unused.
  static Words odd_words(Words a) { return __builtin_shufflevector(a, a, 1, 1, 3, 3); }
  /// Products of words 0 and 2 of both, as 64 bits each.
  static Sums multiply_even(Words a, Words b) {
#ifdef __SSE2__
    return reinterpret_cast<Sums>(_mm_mul_epu32(reinterpret_cast<__m128i>(a), reinterpret_cast<__m128i>(b)));
#else
    return Sums{std::uint64_t{a[0]} * b[0], std::uint64_t{a[2]} * b[2]};
#endif
  }
};
#ifdef __AVX2__
template <>
struct Vectors<8> {
  using Words = std::uint32_t __attribute__((vector_size(32)));
  using Sums = std::uint64_t __attribute__((vector_size(32)));
  static Words odd_words(Words a) { return __builtin_shufflevector(a, a, 1, 1, 3, 3, 5, 5, 7, 7); }
  static Sums multiply_even(Words a, Words b) {
    return reinterpret_cast<Sums>(_mm256_mul_epu32(reinterpret_cast<__m256i>(a), reinterpret_cast<__m256i>(b)));
  }
};
constexpr std::size_t widest = 8;
#else
constexpr std::size_t widest = 4;
#endif

template <std::size_t width>
typename Vectors<width>::Words load(const void* at) {
  typename Vectors<width>::Words words;
  memcpy(&words, at, sizeof words);
  return words;
}

template <std::size_t width>
struct Width {};

/// Ends every kernel: gcc 12 leaves it out where a kernel ends in a call. Code without AVX then runs up to four times
/// slower, until something else clears the upper halves.
void clear_upper_halves() {
#ifdef __AVX2__
  _mm256_zeroupper();
#endif
}

/// Calls `block(first, Width)` for vectors of words that cover a row. If the row length is no multiple of four, the
/// last vector overlaps the one before.
template <typename Block>
void cover_words(std::size_t word_count, const Block& block) {
  std::size_t word = 0;
  if constexpr (widest > 4)
    for (; word + widest <= word_count; word += widest) block(word, Width<widest>());
  for (; word + 4 <= word_count; word += 4) block(word, Width<4>());
  if (word < word_count) block(word_count - 4, Width<4>());
}

/// Sums the products of a vector of words and of `more` words behind it: vector and scalar units work side by side.
template <std::size_t width, std::size_t more>
void sum_products_of(const std::uint32_t* rows, std::size_t stride, std::size_t first, std::size_t row_count,
                     std::uint64_t* out) {
  using V = Vectors<width>;
  typename V::Sums even = {}, odd = {};
  std::uint64_t single[more + 1] = {};
  std::uint32_t key = (static_cast<std::uint32_t>(first) + 1) * row_step;
  typename V::Words keys = typename V::Words{} + key, next_keys = keys + row_step;
  const auto add = [&](typename V::Words a, typename V::Words b) {
    even += V::multiply_even(a, b);
    odd += V::multiply_even(V::odd_words(a), V::odd_words(b));
  };
  std::size_t row = 0;
  for (; row + 1 < row_count; row += 2, rows += 2 * stride, key += 2 * row_step) {
    add(load<width>(rows) + keys, load<width>(rows + stride) + next_keys);
    for (std::size_t i = 0; i < more; ++i) {
      const std::uint32_t a = rows[width + i] + key;
      const std::uint32_t b = rows[stride + width + i] + key + row_step;
      single[i] += std::uint64_t{a} * b;
    }
    keys += 2 * row_step;
    next_keys += 2 * row_step;
  }
  if (row < row_count) {
    add(load<width>(rows) + keys, next_keys);
    for (std::size_t i = 0; i < more; ++i) single[i] += std::uint64_t{rows[width + i] + key} * (key + row_step);
  }
  for (std::size_t word = 0; word < width; ++word) out[word] = (word % 2 == 0 ? even : odd)[word / 2];
  for (std::size_t i = 0; i < more; ++i) out[width + i] = single[i];
}

void sum_products(const std::uint32_t* rows, std::size_t word_count, std::size_t first, std::size_t row_count,
                  std::uint64_t* sums) {
  std::size_t word = 0;
  const auto sum_all = [&]<std::size_t width>(Width<width>) {
    while (word + width <= word_count) {
      const std::size_t left = word_count - word - width;
      const std::size_t more = left <= 2 ? left : 0;
      const auto sum = more == 0   ? sum_products_of<width, 0>
                       : more == 1 ? sum_products_of<width, 1>
                                   : sum_products_of<width, 2>;
      sum(rows + word, word_count, first, row_count, sums + word);
      word += width + more;
    }
  };
  sum_all(Width<widest>());
  sum_all(Width<4>());
  if (word < word_count)
    sum_products_of<4, 0>(rows + word_count - 4, word_count, first, row_count, sums + word_count - 4);
  clear_upper_halves();
}

template <std::size_t width>
bool any_match_of(const std::uint8_t* rows, std::size_t stride, std::size_t row_count, const std::uint32_t* mask,
                  const std::uint32_t* want) {
  using Words = typename Vectors<width>::Words;
  const Words masks = load<width>(mask), wants = load<width>(want);
  const auto match = [&](std::size_t row) {
    return reinterpret_cast<Words>((load<width>(rows + row * stride) & masks) == wants);
  };
  Words found = {};
  std::size_t row = 0;
  for (; row + 4 <= row_count; row += 4) found |= (match(row) | match(row + 1)) | (match(row + 2) | match(row + 3));
  for (; row < row_count; ++row) found |= match(row);
  std::uint64_t halves[width / 2], any = 0;
  memcpy(halves, &found, sizeof halves);
  for (const std::uint64_t half : halves) any |= half;
  return any != 0;
}

bool any_match(const std::uint8_t* rows, std::size_t word_count, std::size_t row_count, const std::uint32_t* mask,
               const std::uint32_t* want) {
  bool any = false;
  cover_words(word_count, [&]<std::size_t width>(std::size_t word, Width<width>) {
    std::uint32_t masks = 0;
    for (std::size_t i = 0; i < width; ++i) masks |= mask[word + i];
    if (masks != 0)
      any = any_match_of<width>(rows + 4 * word, 4 * word_count, row_count, mask + word, want + word) || any;
  });
  clear_upper_halves();
  return any;
}

std::uint64_t hash(const std::uint8_t* bytes, std::size_t size, std::uint64_t seed) {
  const std::uint64_t found = XXH3_64bits_withSeed(bytes, size, seed);
  clear_upper_halves();
  return found;
}

void start128(void* state, std::size_t state_size) {
  TICKTRUE_ASSERT(state_size >= sizeof(XXH3_state_t));
  XXH3_128bits_reset(static_cast<XXH3_state_t*>(state));
  clear_upper_halves();
}

void add128(void* state, const std::uint8_t* bytes, std::size_t size) {
  XXH3_128bits_update(static_cast<XXH3_state_t*>(state), bytes, size);
  clear_upper_halves();
}

void value128(const void* state, std::uint64_t* high, std::uint64_t* low) {
  const XXH128_hash_t found = XXH3_128bits_digest(static_cast<const XXH3_state_t*>(state));
  *high = found.high64;
  *low = found.low64;
  clear_upper_halves();
}

}  // namespace

extern const RowKernels row_kernels;
const RowKernels row_kernels{hash, sum_products, any_match, start128, add128, value128};

}  // namespace ticktrue::TICKTRUE_ISA
