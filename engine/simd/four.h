// Four: four Reals with the operators of Real, in registers of 16 bytes, which every target has or does without.
// SPDX-License-Identifier: MIT
//
// Element-wise operations give each lane the bits that scalar code would give it.
#pragma once

#include <cstdint>
#include <cstring>

#include "engine/math/vec2.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Four {
  static constexpr int part_size = 16 / static_cast<int>(sizeof(Real));  // lanes
  static constexpr int part_count = 4 / part_size;
  using Part = Real __attribute__((vector_size(16)));
  Part part[part_count];
};

inline Four load_four(const Real* from) {
  Four value;
  std::memcpy(&value, from, sizeof value);
  return value;
}
inline void store_four(Real* to, const Four& value) {
  std::memcpy(to, &value, sizeof value);
}
inline Four operator+(const Four& a, const Four& b) {
  Four result;
  for (int i = 0; i < Four::part_count; ++i) result.part[i] = a.part[i] + b.part[i];
  return result;
}
inline Four operator-(const Four& a, const Four& b) {
  Four result;
  for (int i = 0; i < Four::part_count; ++i) result.part[i] = a.part[i] - b.part[i];
  return result;
}
inline Four operator*(const Four& a, const Four& b) {
  Four result;
  for (int i = 0; i < Four::part_count; ++i) result.part[i] = a.part[i] * b.part[i];
  return result;
}
inline Four operator+(Real a, const Four& b) {
  Four result;
  for (int i = 0; i < Four::part_count; ++i) result.part[i] = a + b.part[i];
  return result;
}
inline Four operator*(Real a, const Four& b) {
  Four result;
  for (int i = 0; i < Four::part_count; ++i) result.part[i] = a * b.part[i];
  return result;
}
inline Four smaller(const Four& a, const Four& b) {
  Four result;
  for (int i = 0; i < Four::part_count; ++i) result.part[i] = a.part[i] < b.part[i] ? a.part[i] : b.part[i];
  return result;
}
inline Four larger(const Four& a, const Four& b) {
  Four result;
  for (int i = 0; i < Four::part_count; ++i) result.part[i] = a.part[i] > b.part[i] ? a.part[i] : b.part[i];
  return result;
}
/// The least of the four.
inline Real least_of(const Four& a) {
  Four::Part least = a.part[0];
  for (int i = 1; i < Four::part_count; ++i) least = least < a.part[i] ? least : a.part[i];
  Real result = least[0];
  for (int i = 1; i < Four::part_size; ++i) result = least[i] < result ? least[i] : result;
  return result;
}
/// The largest of the four.
inline Real most_of(const Four& a) {
  Four::Part most = a.part[0];
  for (int i = 1; i < Four::part_count; ++i) most = most > a.part[i] ? most : a.part[i];
  Real result = most[0];
  for (int i = 1; i < Four::part_size; ++i) result = most[i] > result ? most[i] : result;
  return result;
}
/// Whether a[i] <= b[i] for every i.
inline bool all_at_most(const Four& a, const Four& b) {
  using Halves = std::uint64_t __attribute__((vector_size(16)));
  auto all = a.part[0] <= b.part[0];
  for (int i = 1; i < Four::part_count; ++i) all &= a.part[i] <= b.part[i];
  Halves halves;
  std::memcpy(&halves, &all, sizeof halves);
  return (halves[0] & halves[1]) == ~std::uint64_t{0};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
