// From pairs to lanes and from lanes to manifolds.
// SPDX-License-Identifier: MIT
#include "engine/narrow_phase/box_pairs.h"

#include "engine/narrow_phase/convex_hulls.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// A batch with fewer pairs is not worth the lanes.
constexpr std::size_t pairs_per_batch_least = 3;

// What kernels read.
static_assert(sizeof(BodyRow) == 8 + 7 * sizeof(Real) && sizeof(Quad) == 16 * sizeof(Real));

}  // namespace

void BoxBlock::collide(const Model& model, const State& state) {
  const std::size_t rest = count_ % lane_count;
  if (rest < pairs_per_batch_least) count_ -= rest;
  if (count_ == 0) return;
  const std::size_t batch_count = (count_ + lane_count - 1) / lane_count;
  BoxPairs& last = pairs_[batch_count - 1];
  for (std::size_t lane = count_ - (batch_count - 1) * lane_count; lane < lane_count; ++lane) {
    last.body_a[lane] = last.body_a[0];
    last.body_b[lane] = last.body_b[0];
    last.quad_a[lane] = last.quad_a[0];
    last.quad_b[lane] = last.quad_b[0];
    last.margin.at[lane] = last.margin.at[0];
    last.preference.at[lane] = last.preference.at[0];
  }
  for (std::size_t i = 0; i < batch_count; ++i) {
    pairs_[i].poses = &state.bodies.data()->position.x;
    pairs_[i].quads = model.quads.data()->x;
    model.kernels.boxes.collide(pairs_[i], contacts_[i]);
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
