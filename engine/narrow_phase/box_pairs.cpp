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
  if (rest > 0 && rest < pairs_per_batch_least) {
    count_ -= rest;
    for (std::uint8_t& place : place_)
      if (place != no_place && place >= count_) place = no_place;
  }
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

void BoxBlock::write(std::size_t i, Manifold& manifold) const {
  const BoxContactLanes& lanes = contacts_[place_[i] / lane_count];
  const std::size_t lane = place_[i] % lane_count;
  const auto reference = static_cast<std::uint32_t>(lanes.reference_edge.at[lane]);
  const auto incident = static_cast<std::uint32_t>(lanes.incident_edge.at[lane]);
  const bool flipped = lanes.flipped.at[lane] > 0;
  manifold.normal = {lanes.normal_x.at[lane], lanes.normal_y.at[lane]};
  manifold.point_count = 0;
  for (std::uint32_t p = 0; p < 2; ++p) {
    const BoxContactLanes::Point& point = lanes.points[p];
    if (!(point.exists.at[lane] > 0)) continue;
    // The incident edge runs the other way: its end is at the beginning of the reference edge.
    const std::uint32_t on_reference = (reference + p) & 3;
    const std::uint32_t on_other = (incident + 1 - p) & 3;
    manifold.points[manifold.point_count++] = {
        {point.anchor_a_x.at[lane], point.anchor_a_y.at[lane]},
        {point.anchor_b_x.at[lane], point.anchor_b_y.at[lane]},
        point.separation.at[lane],
        flipped ? feature_of(on_other, on_reference) : feature_of(on_reference, on_other)};
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
