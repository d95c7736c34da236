// Contacts of two shapes with four sharp corners, several pairs side by side.
// SPDX-License-Identifier: MIT
// Source: as collide_polygons.cpp; each lane does what collide() does there for such a pair, in the same order, with
// selections in the place of branches.
#include "engine/contacts/solver_kernels.h"
#include "engine/simd/quads.h"

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {
namespace {

constexpr int quad_length = 16;
// A row of State::bodies: two ids, position, rotation, velocity, angular velocity.
constexpr int pose_length = 7 + 8 / static_cast<int>(sizeof(Real));

/// Corners and the normals of the edges that begin there.
struct Outline {
  Quads x, y, normal_x, normal_y;
};

/// `is_same`: all of one shape.
TICKTRUE_INLINE Outline load_outline(const Real* quads, const std::uint32_t* index, bool is_same) {
  if (is_same) {
    const Real* one = quads + static_cast<std::size_t>(index[0]) * quad_length;
    const auto spread_four = [](const Real* from) -> Quads {
      return {{spread(from[0]), spread(from[1]), spread(from[2]), spread(from[3])}};
    };
    return {spread_four(one), spread_four(one + 4), spread_four(one + 8), spread_four(one + 12)};
  }
  return {gather_quads<quad_length>(quads, index), gather_quads<quad_length>(quads + 4, index),
          gather_quads<quad_length>(quads + 8, index), gather_quads<quad_length>(quads + 12, index)};
}

/// An edge: its normal, where it begins and ends, and which it is.
struct Edge {
  Wide normal_x, normal_y;
  Wide x1, y1, x2, y2;
  Wide index;
};

TICKTRUE_INLINE Edge edge_of(const Outline& outline, int i) {
  const int next = (i + 1) & 3;
  return {outline.normal_x.at[i], outline.normal_y.at[i],      outline.x.at[i], outline.y.at[i], outline.x.at[next],
          outline.y.at[next],     spread(static_cast<Real>(i))};
}

using Mask = decltype(Wide{} > Wide{});

TICKTRUE_INLINE Edge select(Mask mask, const Edge& a, const Edge& b) {
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
  Wide separation;
};

TICKTRUE_INLINE Axis best_axis(const Outline& a, const Outline& b) {
  Axis best{};
  for (int i = 0; i < 4; ++i) {
    const Wide nx = a.normal_x.at[i];
    const Wide ny = a.normal_y.at[i];
    Wide deepest = b.x.at[0] * nx + b.y.at[0] * ny;
    for (int j = 1; j < 4; ++j) deepest = smaller(deepest, b.x.at[j] * nx + b.y.at[j] * ny);
    const Wide separation = deepest - (nx * a.x.at[i] + ny * a.y.at[i]);
    if (i == 0) {
      best = {edge_of(a, 0), separation};
      continue;
    }
    const Mask is_better = separation > best.separation;
    best.edge = select(is_better, edge_of(a, i), best.edge);
    best.separation = is_better ? separation : best.separation;
  }
  return best;
}

TICKTRUE_INLINE Edge opposite_edge(const Outline& outline, Wide nx, Wide ny) {
  Edge edge = edge_of(outline, 0);
  Wide least = nx * outline.normal_x.at[0] + ny * outline.normal_y.at[0];
  for (int i = 1; i < 4; ++i) {
    const Wide along = nx * outline.normal_x.at[i] + ny * outline.normal_y.at[i];
    const Mask is_better = along < least;
    edge = select(is_better, edge_of(outline, i), edge);
    least = is_better ? along : least;
  }
  return edge;
}

TICKTRUE_INLINE Quads select(Mask mask, const Quads& a, const Quads& b) {
  return {{mask ? a.at[0] : b.at[0], mask ? a.at[1] : b.at[1], mask ? a.at[2] : b.at[2], mask ? a.at[3] : b.at[3]}};
}

/// wide_count pairs, starting at lane `first`.
struct Group {
  BoxContacts& out;
  int first;

  TICKTRUE_INLINE Wide load(const Lanes& lanes) const { return load_wide(lanes.at + first); }
  TICKTRUE_INLINE void store(Lanes& lanes, Wide value) const { store_wide(lanes.at + first, value); }
  TICKTRUE_INLINE void store_quads(Real (*rows)[4], const Quads& quads) const {
    Transposer<Real, wide_count>::scatter([&](int i) { return rows[first + i]; }, quads.at);
  }
};

TICKTRUE_INLINE void collide_group(const BoxPairs& pairs, const Real* poses, const Real* quads, const Group& group) {
  const Wide zero{};
  const Wide one = spread(1);
  const int first = group.first;
  const Quads a = gather_quads<pose_length>(poses, pairs.body_a + first);
  const Quads b = gather_quads<pose_length>(poses, pairs.body_b + first);
  const Wide ca = a.at[2], sa = a.at[3], cb = b.at[2], sb = b.at[3];
  // B's frame as seen from A.
  const Wide dx = b.at[0] - a.at[0];
  const Wide dy = b.at[1] - a.at[1];
  const Wide px = ca * dx + sa * dy;
  const Wide py = ca * dy - sa * dx;
  const Wide c = ca * cb + sa * sb;
  const Wide s = ca * sb - sa * cb;
  const Outline outline_a = load_outline(quads, pairs.quad_a + first, pairs.same_a);
  Outline outline_b = load_outline(quads, pairs.quad_b + first, pairs.same_b);
  for (int i = 0; i < 4; ++i) {
    const Wide x = outline_b.x.at[i], y = outline_b.y.at[i];
    const Wide nx = outline_b.normal_x.at[i], ny = outline_b.normal_y.at[i];
    outline_b.x.at[i] = px + (c * x - s * y);
    outline_b.y.at[i] = py + (s * x + c * y);
    outline_b.normal_x.at[i] = c * nx - s * ny;
    outline_b.normal_y.at[i] = s * nx + c * ny;
  }

  const Wide margin = group.load(pairs.margin);
  const Axis axis_a = best_axis(outline_a, outline_b);
  const Axis axis_b = best_axis(outline_b, outline_a);
  const Mask is_near = (axis_a.separation <= margin) & (axis_b.separation <= margin);
  const Mask flipped = axis_b.separation > axis_a.separation + group.load(pairs.preference);
  const Edge reference = select(flipped, axis_b.edge, axis_a.edge);
  const Outline other{select(flipped, outline_a.x, outline_b.x), select(flipped, outline_a.y, outline_b.y),
                      select(flipped, outline_a.normal_x, outline_b.normal_x),
                      select(flipped, outline_a.normal_y, outline_b.normal_y)};
  const Wide nx = reference.normal_x;
  const Wide ny = reference.normal_y;
  const Edge incident = opposite_edge(other, nx, ny);

  // Along the reference edge; the incident edge runs the other way, from its second end to its first.
  const Wide tx = spread(-1) * ny;
  const Wide ty = nx;
  const auto along = [&](Wide x, Wide y) { return (x - reference.x1) * tx + (y - reference.y1) * ty; };
  const Wide reference_end = along(reference.x2, reference.y2);
  const Wide lower = along(incident.x2, incident.y2);
  const Wide upper = along(incident.x1, incident.y1);
  const Mask is_beside = (upper < zero) | (lower > reference_end);
  const Wide length = upper - lower;
  const Mask has_length = length > zero;
  const Wide divisor = has_length ? length : one;
  const Wide way_x = incident.x1 - incident.x2;
  const Wide way_y = incident.y1 - incident.y2;
  const Mask cuts_lower = (lower < zero) & has_length;
  const Wide share_lower = -lower / divisor;
  const Mask cuts_upper = (upper > reference_end) & has_length;
  const Wide share_upper = (reference_end - lower) / divisor;
  const Wide ends[2][2] = {{cuts_lower ? incident.x2 + share_lower * way_x : incident.x2,
                            cuts_lower ? incident.y2 + share_lower * way_y : incident.y2},
                           {cuts_upper ? incident.x2 + share_upper * way_x : incident.x1,
                            cuts_upper ? incident.y2 + share_upper * way_y : incident.y1}};

  // The incident edge runs the other way: its end is at the beginning of the reference edge.
  const auto next = [&](Wide corner) { return corner < spread(3) ? corner + one : zero; };
  const Wide on_reference[2] = {reference.index, next(reference.index)};
  const Wide on_other[2] = {next(incident.index), incident.index};
  const Wide back_x = a.at[0] - b.at[0];
  const Wide back_y = a.at[1] - b.at[1];
  Wide separations[2];
  for (int p = 0; p < 2; ++p) {
    const Wide x = ends[p][0], y = ends[p][1];
    const Wide separation = (x - reference.x1) * nx + (y - reference.y1) * ny;
    const Wide half = spread(Real(0.5)) * separation;
    const Wide middle_x = x - half * nx;
    const Wide middle_y = y - half * ny;
    const Wide anchor_x = ca * middle_x - sa * middle_y;
    const Wide anchor_y = sa * middle_x + ca * middle_y;
    const Mask exists = is_near & ~is_beside & (separation <= margin);
    group.store_quads(group.out.anchors[p], {{anchor_x, anchor_y, anchor_x + back_x, anchor_y + back_y}});
    separations[p] = separation;
    const Wide corner_a = flipped ? on_other[p] : on_reference[p];
    const Wide corner_b = flipped ? on_reference[p] : on_other[p];
    group.store(group.out.features.at[p], exists ? spread(256) * corner_a + corner_b : spread(-1));  // feature_of
  }
  const Wide out_x = flipped ? -nx : nx;
  const Wide out_y = flipped ? -ny : ny;
  group.store_quads(group.out.normals,
                    {{ca * out_x - sa * out_y, sa * out_x + ca * out_y, separations[0], separations[1]}});
}

void collide(const BoxPairs& pairs, const Real* poses, const Real* quads, BoxContacts& out) {
  for (int first = 0; first < lane_count; first += wide_count) collide_group(pairs, poses, quads, {out, first});
}

}  // namespace

BoxKernels box_kernels() {
  return {collide};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
