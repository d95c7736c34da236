// Four 32-bit words at once: compiler vectors, the same values on every platform.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace ticktrue {

using Words4 = std::uint32_t __attribute__((vector_size(16)));
using Sums2 = std::uint64_t __attribute__((vector_size(16)));

inline Words4 load_words(const std::uint8_t* at) {
  Words4 words;
  std::memcpy(&words, at, sizeof words);
  return words;
}

/// Products of words 0 and 2 of both, as 64 bits each.
inline Sums2 multiply_even(Words4 a, Words4 b) {
#ifdef __SSE2__
  return reinterpret_cast<Sums2>(_mm_mul_epu32(reinterpret_cast<__m128i>(a), reinterpret_cast<__m128i>(b)));
#else
  return Sums2{std::uint64_t{a[0]} * b[0], std::uint64_t{a[2]} * b[2]};
#endif
}

/// Words 1 and 3, in the places of words 0 and 2; the others are of no use.
inline Words4 odd_words(Words4 a) {
  return __builtin_shufflevector(a, a, 1, 1, 3, 3);
}

/// Calls `blocks(first, count)` for blocks of four words that cover a row, several at a time: the last overlaps the one
/// before where the row is no multiple of four. Requires: at least four words.
template <typename Blocks>
void cover_words(std::size_t word_count, const Blocks& blocks) {
  std::size_t word = 0;
  for (; word + 8 <= word_count; word += 8) blocks(word, std::integral_constant<std::size_t, 2>());
  for (; word + 4 <= word_count; word += 4) blocks(word, std::integral_constant<std::size_t, 1>());
  if (word < word_count) blocks(word_count - 4, std::integral_constant<std::size_t, 1>());
}

}  // namespace ticktrue
