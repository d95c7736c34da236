// Realx4: four Reals with the operators of Real, in registers of 16 bytes on every target.
// SPDX-License-Identifier: MIT
//
// An element-wise operation gives each lane the bits of scalar code. Other vector types: realxn.h.
#pragma once

#include <cstdint>
#include <cstring>

#include "engine/math/vec2.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Realx4 {
  static constexpr int part_size = 16 / static_cast<int>(sizeof(Real));  // lanes
  static constexpr int part_count = 4 / part_size;
  using Part = Real __attribute__((vector_size(16)));
  Part part[part_count];
};

inline Realx4 load_x4(const Real* from) {
  Realx4 value;
  std::memcpy(&value, from, sizeof value);
  return value;
}
inline void store_x4(Real* to, const Realx4& value) {
  std::memcpy(to, &value, sizeof value);
}
inline Realx4 operator+(const Realx4& a, const Realx4& b) {
  Realx4 result;
  for (int i = 0; i < Realx4::part_count; ++i) result.part[i] = a.part[i] + b.part[i];
  return result;
}
inline Realx4 operator-(const Realx4& a, const Realx4& b) {
  Realx4 result;
  for (int i = 0; i < Realx4::part_count; ++i) result.part[i] = a.part[i] - b.part[i];
  return result;
}
inline Realx4 operator*(const Realx4& a, const Realx4& b) {
  Realx4 result;
  for (int i = 0; i < Realx4::part_count; ++i) result.part[i] = a.part[i] * b.part[i];
  return result;
}
inline Realx4 operator+(Real a, const Realx4& b) {
  Realx4 result;
  for (int i = 0; i < Realx4::part_count; ++i) result.part[i] = a + b.part[i];
  return result;
}
inline Realx4 operator*(Real a, const Realx4& b) {
  Realx4 result;
  for (int i = 0; i < Realx4::part_count; ++i) result.part[i] = a * b.part[i];
  return result;
}
inline Realx4 smaller(const Realx4& a, const Realx4& b) {
  Realx4 result;
  for (int i = 0; i < Realx4::part_count; ++i) result.part[i] = a.part[i] < b.part[i] ? a.part[i] : b.part[i];
  return result;
}
inline Realx4 larger(const Realx4& a, const Realx4& b) {
  Realx4 result;
  for (int i = 0; i < Realx4::part_count; ++i) result.part[i] = a.part[i] > b.part[i] ? a.part[i] : b.part[i];
  return result;
}
/// The smallest lane.
inline Real smallest_lane(const Realx4& a) {
  Realx4::Part least = a.part[0];
  for (int i = 1; i < Realx4::part_count; ++i) least = least < a.part[i] ? least : a.part[i];
  Real result = least[0];
  for (int i = 1; i < Realx4::part_size; ++i) result = least[i] < result ? least[i] : result;
  return result;
}
/// The largest lane.
inline Real largest_lane(const Realx4& a) {
  Realx4::Part most = a.part[0];
  for (int i = 1; i < Realx4::part_count; ++i) most = most > a.part[i] ? most : a.part[i];
  Real result = most[0];
  for (int i = 1; i < Realx4::part_size; ++i) result = most[i] > result ? most[i] : result;
  return result;
}
/// Whether a[i] <= b[i] for every i.
inline bool all_at_most(const Realx4& a, const Realx4& b) {
  using Halves = std::uint64_t __attribute__((vector_size(16)));
  auto all = a.part[0] <= b.part[0];
  for (int i = 1; i < Realx4::part_count; ++i) all &= a.part[i] <= b.part[i];
  Halves halves;
  std::memcpy(&halves, &all, sizeof halves);
  return (halves[0] & halves[1]) == ~std::uint64_t{0};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
