// Pairs of shapes with four sharp corners, a block at a time, for the kernels that take eight of them.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/narrow_phase/narrow_phase.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The manifolds of the pairs of a block that kernels can do; they have the bits that collide() gives.
class BoxBlock {
 public:
  static constexpr std::size_t pair_count_max = 64;
  static constexpr std::uint8_t no_place = 0xff;

  void clear() { count_ = 0; }
  /// Adds a pair, if it is one for kernels. Returns its place. Requires: fewer than pair_count_max were added.
  std::uint8_t add(const ShapeModel& a, const ShapeModel& b, std::uint32_t body_a, std::uint32_t body_b, Real fall) {
    if (a.quad == no_quad || b.quad == no_quad) return no_place;
    const Real size = pair_size(a, b);
    const std::size_t lane = count_ % lane_count;
    BoxPairs& pairs = pairs_[count_ / lane_count];
    pairs.body_a[lane] = body_a;
    pairs.body_b[lane] = body_b;
    pairs.quad_a[lane] = a.quad;
    pairs.quad_b[lane] = b.quad;
    pairs.margin.at[lane] = speculative_margin(size, fall);
    pairs.preference.at[lane] = Real(0.1) * linear_slop(size);
    return static_cast<std::uint8_t>(count_++);
  }
  /// Finds the contacts of those that were added.
  void collide(const Model& model, const State& state);
  /// Whether it did so for the pair at a place: a few that would leave most of a batch empty are left out.
  bool has(std::uint8_t place) const { return place < count_; }
  /// Its manifold.
  void write(std::uint8_t place, Manifold& manifold) const {
    const BoxContactLanes& lanes = contacts_[place / lane_count];
    const std::size_t lane = place % lane_count;
    manifold.normal = {lanes.normal_x.at[lane], lanes.normal_y.at[lane]};
    int count = 0;
    for (const BoxContactLanes::Point& point : lanes.points) {
      const Real feature = point.feature.at[lane];
      if (feature < 0) continue;
      ManifoldPoint& out = manifold.points[count++];
      out.anchor_a = {point.anchor_a_x.at[lane], point.anchor_a_y.at[lane]};
      out.anchor_b = {point.anchor_b_x.at[lane], point.anchor_b_y.at[lane]};
      out.separation = point.separation.at[lane];
      out.feature = static_cast<std::uint32_t>(static_cast<std::int32_t>(feature));
    }
    manifold.point_count = count;
  }

 private:
  std::size_t count_ = 0;
  BoxPairs pairs_[pair_count_max / lane_count];
  BoxContactLanes contacts_[pair_count_max / lane_count];
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
