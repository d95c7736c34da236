// Conversion from pairs to lanes, and from lanes to manifolds.
// SPDX-License-Identifier: MIT
#include "engine/narrow_phase/box_pairs.h"

#include <algorithm>

#include "engine/narrow_phase/convex_hulls.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// A batch of fewer pairs does not pay.
constexpr std::uint32_t pairs_per_batch_least = 3;

// The layout on which kernels rely.
static_assert(sizeof(BodyRow) == 8 + 7 * sizeof(Real) && sizeof(Quad) == 16 * sizeof(Real));

}  // namespace

void complete_boxes(PairBlock& block) {
  const std::uint32_t rest = block.box_count % lane_count;
  if (rest < pairs_per_batch_least) {
    block.box_count -= rest;
    for (std::uint32_t i = 0; i < block.candidate_count; ++i)
      if (Candidate& candidate = block.candidates[i]; candidate.place >= block.box_count) candidate.place = no_place;
  } else {
    BoxPairs& last = block.boxes[block.box_count / lane_count];
    for (std::uint32_t lane = rest; lane < lane_count; ++lane) {
      last.body_a[lane] = last.body_a[0];
      last.body_b[lane] = last.body_b[0];
      last.quad_a[lane] = last.quad_a[0];
      last.quad_b[lane] = last.quad_b[0];
      last.margin.at[lane] = last.margin.at[0];
      last.preference.at[lane] = last.preference.at[0];
    }
  }
  const auto are_same = [](const std::uint32_t(&quads)[lane_count]) {
    return std::all_of(quads, quads + lane_count, [&](std::uint32_t quad) { return quad == quads[0]; });
  };
  for (std::uint32_t first = 0; first < block.box_count; first += lane_count) {
    BoxPairs& pairs = block.boxes[first / lane_count];
    pairs.same_a = are_same(pairs.quad_a);
    pairs.same_b = are_same(pairs.quad_b);
  }
}

BoxManifolds::BoxManifolds(const Model& model, const State& state, const PairBlock& block) {
  const Real* poses = &state.bodies.data()->position.x;
  for (std::uint32_t first = 0; first < block.box_count; first += lane_count)
    model.kernels.boxes.collide(block.boxes[first / lane_count], poses, model.quads.data()->x,
                                contacts_[first / lane_count]);
}

void BoxManifolds::cache_features(PairBlock& block) const {
  block.has_features = block.box_count > 0 && block.box_count == block.candidate_count;
  for (std::uint32_t i = 0; i < block.box_count && block.has_features; ++i) {
    const BoxFeatures& features = contacts_[i / lane_count].features;
    const Real first = features.at[0].at[i % lane_count];
    const Real second = features.at[1].at[i % lane_count];
    block.has_features = first >= 0 && second >= 0 && first != second;
    block.features[i / lane_count] = features;
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
