// Pairs of quadrilaterals of a block, for kernels that take eight pairs.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstring>

#include "engine/narrow_phase/narrow_phase.h"
#include "engine/narrow_phase/pair_block.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Adds a pair of quadrilaterals to the boxes of a block. Returns its place, or no_place for other shapes.
inline std::uint8_t add_box(PairBlock& block, const ShapeModel& a, const ShapeModel& b, std::uint32_t body_a,
                            std::uint32_t body_b, Real gravity_displacement) {
  if (a.quad == no_quad || b.quad == no_quad) return no_place;
  const Real size = pair_size(a, b);
  const std::size_t lane = block.box_count % lane_count;
  BoxPairs& pairs = block.boxes[block.box_count / lane_count];
  pairs.body_a[lane] = body_a;
  pairs.body_b[lane] = body_b;
  pairs.quad_a[lane] = a.quad;
  pairs.quad_b[lane] = b.quad;
  pairs.margin.at[lane] = speculative_margin(size, gravity_displacement);
  pairs.preference.at[lane] = Real(0.1) * linear_slop(size);
  return static_cast<std::uint8_t>(block.box_count++);
}
/// Completes the last batch: repeats a pair in its empty lanes, or removes the batch if it has too few pairs.
void complete_boxes(PairBlock& block);

/// The manifolds of the boxes of a block, with the bits of collide().
class BoxManifolds {
 public:
  BoxManifolds(const Model& model, const State& state, const PairBlock& block);
  /// Writes the manifold of the pair at a place; only its point count if the pair has no contact.
  void write(std::uint8_t place, Manifold& manifold) const {
    const BoxContacts& found = contacts_[place / lane_count];
    const std::size_t lane = place % lane_count;
    const bool exists[2] = {found.features.at[0].at[lane] >= 0, found.features.at[1].at[lane] >= 0};
    manifold.point_count = exists[0] + exists[1];
    if (manifold.point_count == 0) return;
    std::memcpy(&manifold.normal, found.normals[lane], sizeof manifold.normal);
    if (exists[0]) write_point(found, lane, 0, manifold.points[0]);
    if (exists[1]) write_point(found, lane, 1, manifold.points[exists[0] ? 1 : 0]);
  }

  /// Updates the contacts of all boxes of a block in place. Returns false and changes nothing unless each box has the
  /// same features as before. `contacts`: of these boxes. Requires: block.has_features.
  bool renew(const PairBlock& block, ContactPair* contacts) const {
    for (std::uint32_t first = 0; first < block.box_count; first += lane_count)
      if (std::memcmp(&contacts_[first / lane_count].features, &block.features[first / lane_count],
                      sizeof(BoxFeatures)) != 0)
        return false;
    for (std::uint32_t i = 0; i < block.box_count; ++i) {
      const BoxContacts& found = contacts_[i / lane_count];
      const std::size_t lane = i % lane_count;
      Manifold& manifold = contacts[i].manifold;
      std::memcpy(&manifold.normal, found.normals[lane], sizeof manifold.normal);
      for (int p = 0; p < 2; ++p) {
        std::memcpy(&manifold.points[p].anchor_a, found.anchors[p][lane], 4 * sizeof(Real));
        manifold.points[p].separation = found.normals[lane][2 + p];
      }
    }
    return true;
  }
  /// Saves the features of the boxes in the block.
  void cache_features(PairBlock& block) const;

 private:
  static std::uint32_t as_feature(Real feature) {
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(feature));
  }
  static void write_point(const BoxContacts& found, std::size_t lane, std::size_t p, ManifoldPoint& out) {
    std::memcpy(&out.anchor_a, found.anchors[p][lane], 4 * sizeof(Real));
    out.separation = found.normals[lane][2 + p];
    out.feature = as_feature(found.features.at[p].at[lane]);
  }

  BoxContacts contacts_[PairBlock::pair_count_max / lane_count];
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
