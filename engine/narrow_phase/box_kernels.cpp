// Contacts of two quadrilaterals, several pairs at a time.
// SPDX-License-Identifier: MIT
// Source: as collide_polygons.cpp. Each lane does the operations of collide_polygons for its pair in the same order,
// with selections instead of branches.
#include "engine/model/solver_kernels.h"
#include "engine/narrow_phase/clip_edge.h"
#include "engine/simd/transpose.h"

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {
namespace {

constexpr int quad_length = 16;
// The length of a row of State::bodies in Reals: two ids, position, rotation, velocity, angular velocity.
constexpr int pose_length = 7 + 8 / static_cast<int>(sizeof(Real));

/// Corners, and the normals of the edges that begin there.
struct Outline {
  Columns4xN x, y, normal_x, normal_y;
};

/// `is_same`: all pairs have the same shape.
TICKTRUE_INLINE Outline load_outline(const Real* quads, const std::uint32_t* index, bool is_same) {
  if (is_same) {
    const Real* one = quads + static_cast<std::size_t>(index[0]) * quad_length;
    const auto broadcast4 = [](const Real* from) -> Columns4xN {
      return {{broadcast(from[0]), broadcast(from[1]), broadcast(from[2]), broadcast(from[3])}};
    };
    return {broadcast4(one), broadcast4(one + 4), broadcast4(one + 8), broadcast4(one + 12)};
  }
  return {gather4<quad_length>(quads, index), gather4<quad_length>(quads + 4, index),
          gather4<quad_length>(quads + 8, index), gather4<quad_length>(quads + 12, index)};
}

/// An edge: its normal, its ends and its index.
struct Edge {
  RealxN normal_x, normal_y;
  RealxN x1, y1, x2, y2;
  RealxN index;
};

TICKTRUE_INLINE Edge edge_of(const Outline& outline, int i) {
  const int next = (i + 1) & 3;
  return {outline.normal_x.at[i], outline.normal_y.at[i],         outline.x.at[i], outline.y.at[i], outline.x.at[next],
          outline.y.at[next],     broadcast(static_cast<Real>(i))};
}

using MaskxN = decltype(RealxN{} > RealxN{});

TICKTRUE_INLINE Edge select(MaskxN mask, const Edge& a, const Edge& b) {
  return {mask ? a.normal_x : b.normal_x,
          mask ? a.normal_y : b.normal_y,
          mask ? a.x1 : b.x1,
          mask ? a.y1 : b.y1,
          mask ? a.x2 : b.x2,
          mask ? a.y2 : b.y2,
          mask ? a.index : b.index};
}

struct Axis {
  Edge edge;
  RealxN separation;
};

TICKTRUE_INLINE Axis best_axis(const Outline& a, const Outline& b) {
  Axis best{};
  for (int i = 0; i < 4; ++i) {
    const RealxN nx = a.normal_x.at[i];
    const RealxN ny = a.normal_y.at[i];
    RealxN deepest = b.x.at[0] * nx + b.y.at[0] * ny;
    for (int j = 1; j < 4; ++j) deepest = smaller(deepest, b.x.at[j] * nx + b.y.at[j] * ny);
    const RealxN separation = deepest - (nx * a.x.at[i] + ny * a.y.at[i]);
    if (i == 0) {
      best = {edge_of(a, 0), separation};
      continue;
    }
    const MaskxN is_better = separation > best.separation;
    best.edge = select(is_better, edge_of(a, i), best.edge);
    best.separation = is_better ? separation : best.separation;
  }
  return best;
}

TICKTRUE_INLINE Edge opposite_edge(const Outline& outline, RealxN nx, RealxN ny) {
  Edge edge = edge_of(outline, 0);
  RealxN least = nx * outline.normal_x.at[0] + ny * outline.normal_y.at[0];
  for (int i = 1; i < 4; ++i) {
    const RealxN along = nx * outline.normal_x.at[i] + ny * outline.normal_y.at[i];
    const MaskxN is_better = along < least;
    edge = select(is_better, edge_of(outline, i), edge);
    least = is_better ? along : least;
  }
  return edge;
}

TICKTRUE_INLINE Columns4xN select(MaskxN mask, const Columns4xN& a, const Columns4xN& b) {
  return {{mask ? a.at[0] : b.at[0], mask ? a.at[1] : b.at[1], mask ? a.at[2] : b.at[2], mask ? a.at[3] : b.at[3]}};
}

/// simd_width pairs, from lane `first` on.
struct LaneRange {
  BoxContacts& out;
  int first;

  TICKTRUE_INLINE RealxN load(const Lanes& lanes) const { return load_xn(lanes.at + first); }
  TICKTRUE_INLINE void store(Lanes& lanes, RealxN value) const { store_xn(lanes.at + first, value); }
  TICKTRUE_INLINE void store4(Real (*rows)[4], const Columns4xN& quads) const {
    Transposer<Real, simd_width>::scatter([&](int i) { return rows[first + i]; }, quads.at);
  }
};

TICKTRUE_INLINE void collide_lanes(const BoxPairs& pairs, const Real* poses, const Real* quads,
                                   const LaneRange& lanes) {
  const RealxN zero{};
  const RealxN one = broadcast(1);
  const int first = lanes.first;
  const Columns4xN a = gather4<pose_length>(poses, pairs.body_a + first);
  const Columns4xN b = gather4<pose_length>(poses, pairs.body_b + first);
  const RealxN ca = a.at[2], sa = a.at[3], cb = b.at[2], sb = b.at[3];
  // The pose of B in A's frame.
  const RealxN dx = b.at[0] - a.at[0];
  const RealxN dy = b.at[1] - a.at[1];
  const RealxN px = ca * dx + sa * dy;
  const RealxN py = ca * dy - sa * dx;
  const RealxN c = ca * cb + sa * sb;
  const RealxN s = ca * sb - sa * cb;
  const Outline outline_a = load_outline(quads, pairs.quad_a + first, pairs.same_a);
  Outline outline_b = load_outline(quads, pairs.quad_b + first, pairs.same_b);
  for (int i = 0; i < 4; ++i) {
    const RealxN x = outline_b.x.at[i], y = outline_b.y.at[i];
    const RealxN nx = outline_b.normal_x.at[i], ny = outline_b.normal_y.at[i];
    outline_b.x.at[i] = px + (c * x - s * y);
    outline_b.y.at[i] = py + (s * x + c * y);
    outline_b.normal_x.at[i] = c * nx - s * ny;
    outline_b.normal_y.at[i] = s * nx + c * ny;
  }

  const RealxN margin = lanes.load(pairs.margin);
  const Axis axis_a = best_axis(outline_a, outline_b);
  const Axis axis_b = best_axis(outline_b, outline_a);
  const MaskxN is_within_margin = (axis_a.separation <= margin) & (axis_b.separation <= margin);
  const MaskxN flipped = axis_b.separation > axis_a.separation + lanes.load(pairs.preference);
  const Edge reference = select(flipped, axis_b.edge, axis_a.edge);
  const Outline other{select(flipped, outline_a.x, outline_b.x), select(flipped, outline_a.y, outline_b.y),
                      select(flipped, outline_a.normal_x, outline_b.normal_x),
                      select(flipped, outline_a.normal_y, outline_b.normal_y)};
  const RealxN nx = reference.normal_x;
  const RealxN ny = reference.normal_y;
  const Edge incident = opposite_edge(other, nx, ny);

  const ClippedEdge<RealxN> clipped = clip_edge<RealxN>({reference.x1, reference.y1, reference.x2, reference.y2}, nx,
                                                        ny, {incident.x1, incident.y1, incident.x2, incident.y2});

  // The incident edge runs in the opposite direction: its end is at the begin of the reference edge.
  const auto next = [&](RealxN corner) { return corner < broadcast(3) ? corner + one : zero; };
  const RealxN on_reference[2] = {reference.index, next(reference.index)};
  const RealxN on_other[2] = {next(incident.index), incident.index};
  const RealxN back_x = a.at[0] - b.at[0];
  const RealxN back_y = a.at[1] - b.at[1];
  for (int p = 0; p < 2; ++p) {
    const RealxN middle_x = clipped.middle_x[p], middle_y = clipped.middle_y[p];
    const RealxN anchor_x = ca * middle_x - sa * middle_y;
    const RealxN anchor_y = sa * middle_x + ca * middle_y;
    const MaskxN exists = is_within_margin & ~clipped.is_beside & (clipped.separation[p] <= margin);
    lanes.store4(lanes.out.anchors[p], {{anchor_x, anchor_y, anchor_x + back_x, anchor_y + back_y}});
    const RealxN corner_a = flipped ? on_other[p] : on_reference[p];
    const RealxN corner_b = flipped ? on_reference[p] : on_other[p];
    lanes.store(lanes.out.features.at[p], exists ? broadcast(256) * corner_a + corner_b : broadcast(-1));  // feature_of
  }
  const RealxN out_x = flipped ? -nx : nx;
  const RealxN out_y = flipped ? -ny : ny;
  lanes.store4(lanes.out.normals,
               {{ca * out_x - sa * out_y, sa * out_x + ca * out_y, clipped.separation[0], clipped.separation[1]}});
}

void collide(const BoxPairs& pairs, const Real* poses, const Real* quads, BoxContacts& out) {
  for (int first = 0; first < lane_count; first += simd_width) collide_lanes(pairs, poses, quads, {out, first});
}

}  // namespace

BoxKernels box_kernels() {
  return {collide};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
