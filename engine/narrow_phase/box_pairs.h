// Pairs of shapes with four sharp corners, a block at a time, for the kernels that take eight of them.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/narrow_phase/narrow_phase.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The manifolds of the pairs of a block that kernels can do; they have the bits that collide() gives.
class BoxBlock {
 public:
  static constexpr std::size_t pair_count_max = 64;

  void clear(std::size_t pair_count) {
    count_ = 0;
    for (std::size_t i = 0; i < pair_count; ++i) place_[i] = no_place;
  }
  /// Adds the i-th pair of the block, if it is one for kernels.
  void add(const ShapeModel& a, const ShapeModel& b, std::size_t i, std::uint32_t body_a, std::uint32_t body_b,
           Real fall) {
    if (a.quad == no_quad || b.quad == no_quad) return;
    const Real size = pair_size(a, b);
    const std::size_t lane = count_ % lane_count;
    BoxPairs& pairs = pairs_[count_ / lane_count];
    pairs.body_a[lane] = body_a;
    pairs.body_b[lane] = body_b;
    pairs.quad_a[lane] = a.quad;
    pairs.quad_b[lane] = b.quad;
    pairs.margin.at[lane] = speculative_margin(size, fall);
    pairs.preference.at[lane] = Real(0.1) * linear_slop(size);
    place_[i] = static_cast<std::uint8_t>(count_++);
  }
  /// Finds the contacts of those that were added.
  void collide(const Model& model, const State& state);
  /// Whether the i-th pair is among them.
  bool has(std::size_t i) const { return place_[i] != no_place; }
  /// Its manifold.
  void write(std::size_t i, Manifold& manifold) const;

 private:
  static constexpr std::uint8_t no_place = 0xff;

  std::size_t count_ = 0;
  std::uint8_t place_[pair_count_max];
  BoxPairs pairs_[pair_count_max / lane_count];
  BoxContactLanes contacts_[pair_count_max / lane_count];
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
