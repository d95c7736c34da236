// A small generator of random numbers for builders of scenes and inputs: the same numbers on every platform.
// SPDX-License-Identifier: MIT
// Source: Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014 (SplitMix64).
#pragma once

#include <cstdint>

namespace ticktrue {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }

  /// 0 <= value < 1: a multiple of 2^-53, so the conversion is exact.
  double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }

  /// low <= value <= high.
  double real(double low, double high) { return low + (high - low) * unit(); }

  /// 0 <= value < count. Requires: 0 < count < 2^32. The bias is below count / 2^32.
  std::uint64_t below(std::uint64_t count) { return ((bits() >> 32) * count) >> 32; }

 private:
  std::uint64_t state_;
};

}  // namespace ticktrue
