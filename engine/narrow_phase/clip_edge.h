// Clipping of an incident edge to the width of a reference edge, for one pair of polygons or several at a time.
// SPDX-License-Identifier: MIT
// Source: Sutherland and Hodgman, "Reentrant Polygon Clipping", 1974.
// `V` is Real or a vector of lanes: each lane does the same operations. Kernels include this header, so all its code is
// inlined.
#pragma once

#include "engine/math/scalar.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The ends of an edge, in the order of its polygon, m.
template <typename V>
struct EdgeEnds {
  V x1, y1, x2, y2;
};

/// The remaining part of the incident edge. Point 0 is at the first end of the reference edge.
template <typename V>
struct ClippedEdge {
  decltype(V{} > V{}) is_beside;  // nothing remains
  V middle_x[2], middle_y[2];     // halfway between each point and the reference edge, m
  V separation[2];                // m
};

/// `above / below`, in lanes where `wanted` is true.
[[gnu::always_inline]] inline Real quotient_where(bool wanted, Real above, Real below) {
  return wanted ? above / below : Real(0);
}
template <typename V, typename Mask>
[[gnu::always_inline]] inline V quotient_where(Mask, V above, V below) {
  return above / below;
}

/// `normal_x`, `normal_y`: of the reference edge.
template <typename V>
[[gnu::always_inline]] inline ClippedEdge<V> clip_edge(const EdgeEnds<V>& reference, V normal_x, V normal_y,
                                                       const EdgeEnds<V>& incident) {
  const V zero{};
  // Along the reference edge. The incident edge runs in the opposite direction, from its second end to its first.
  const V tangent_x = -normal_y;
  const V tangent_y = normal_x;
  const auto along = [&](V x, V y) __attribute__((always_inline)) {
    return (x - reference.x1) * tangent_x + (y - reference.y1) * tangent_y;
  };
  const V reference_end = along(reference.x2, reference.y2);
  const V lower = along(incident.x2, incident.y2);
  const V upper = along(incident.x1, incident.y1);
  const V length = upper - lower;
  const auto has_length = length > zero;
  const V divisor = has_length ? length : Real(1) - zero;
  const V incident_x = incident.x1 - incident.x2;
  const V incident_y = incident.y1 - incident.y2;
  const auto cuts_lower = (lower < zero) & has_length;
  const auto cuts_upper = (upper > reference_end) & has_length;
  const V share_lower = quotient_where(cuts_lower, -lower, divisor);
  const V share_upper = quotient_where(cuts_upper, reference_end - lower, divisor);
  const V x[2] = {cuts_lower ? incident.x2 + share_lower * incident_x : incident.x2,
                  cuts_upper ? incident.x2 + share_upper * incident_x : incident.x1};
  const V y[2] = {cuts_lower ? incident.y2 + share_lower * incident_y : incident.y2,
                  cuts_upper ? incident.y2 + share_upper * incident_y : incident.y1};
  ClippedEdge<V> out;
  out.is_beside = (upper < zero) | (lower > reference_end);
  for (int p = 0; p < 2; ++p) {
    out.separation[p] = (x[p] - reference.x1) * normal_x + (y[p] - reference.y1) * normal_y;
    const V half = (Real(0.5) - zero) * out.separation[p];
    out.middle_x[p] = x[p] - half * normal_x;
    out.middle_y[p] = y[p] - half * normal_y;
  }
  return out;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
