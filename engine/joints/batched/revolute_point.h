// The point constraint of two bodies, for one joint or several at a time: the point of its impulse, and its mobility.
// SPDX-License-Identifier: MIT
// `V` is Real or a vector of lanes: each lane does the same operations. Kernels include this header, so all its code is
// inlined.
// that is not inlined.
#pragma once

#include "engine/math/scalar.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

template <typename V>
struct PointPair {
  V x, y;
};

/// The change of a body's pose since the tick began.
template <typename V>
struct PoseChange {
  V x, y;  // m
  V c, s;  // of the rotation
};

/// Arms from the centres of mass, and the error from A's anchor to B's, m.
template <typename V>
struct PointArms {
  V ax, ay, bx, by;
  V ex, ey;
};

/// Arms to the anchors. `center_offset`: from A's centre of mass to B's at the start of the tick.
template <typename V>
[[gnu::always_inline]] inline PointArms<V> anchor_arms(const PoseChange<V>& a, const PoseChange<V>& b,
                                                       const PointPair<V>& anchor_a, const PointPair<V>& anchor_b,
                                                       const PointPair<V>& center_offset) {
  PointArms<V> arms;
  arms.ax = a.c * anchor_a.x - a.s * anchor_a.y;
  arms.ay = a.s * anchor_a.x + a.c * anchor_a.y;
  arms.bx = b.c * anchor_b.x - b.s * anchor_b.y;
  arms.by = b.s * anchor_b.x + b.c * anchor_b.y;
  arms.ex = (center_offset.x + (b.x - a.x)) + (arms.bx - arms.ax);
  arms.ey = (center_offset.y + (b.y - a.y)) + (arms.by - arms.ay);
  return arms;
}

/// The share of the error by which each arm is lengthened, so that both arms end at the same point. The share is one
/// half while the gap is small. If the gap exceeds the longer arm of a rotating body, the share falls, so that a wide
/// gap is no lever.
template <typename V>
[[gnu::always_inline]] inline V middle_share(const PointArms<V>& arms, V inv_inertia_a, V inv_inertia_b) {
  const V zero{};
  const V half = Real(0.5) - zero;
  const V one = Real(1) - zero;
  const V arm2_a = inv_inertia_a > zero ? arms.ax * arms.ax + arms.ay * arms.ay : zero;
  const V arm2_b = inv_inertia_b > zero ? arms.bx * arms.bx + arms.by * arms.by : zero;
  const V arm2 = arm2_a > arm2_b ? arm2_a : arm2_b;
  const V gap2 = (Real(0.25) - zero) * (arms.ex * arms.ex + arms.ey * arms.ey);
  const V most = gap2 > arm2 ? gap2 : arm2;
  return arm2 > zero ? half * (arm2 / (arm2 > zero ? most : one)) : half;
}

/// Lengthens both arms to the point between the anchors.
template <typename V>
[[gnu::always_inline]] inline void meet_in_the_middle(PointArms<V>& arms, V share) {
  arms.ax = arms.ax + share * arms.ex;
  arms.ay = arms.ay + share * arms.ey;
  arms.bx = arms.bx - share * arms.ex;
  arms.by = arms.by - share * arms.ey;
}

/// The mobility of the point: velocity per impulse, a symmetric matrix.
template <typename V>
struct PointMobility {
  V k11, k12, k22;
  V determinant;
  V area;  // cross(arm of A, arm of B), m^2
};

/// `inv_mass`: of both bodies.
template <typename V>
[[gnu::always_inline]] inline PointMobility<V> point_mobility(const PointArms<V>& arms, V inv_mass, V ia, V ib) {
  PointMobility<V> k;
  k.k11 = inv_mass + (ia * arms.ay * arms.ay + ib * arms.by * arms.by);
  k.k12 = -(ia * arms.ax * arms.ay + ib * arms.bx * arms.by);
  k.k22 = inv_mass + (ia * arms.ax * arms.ax + ib * arms.bx * arms.bx);
  // k11 k22 - k12^2 as a sum of squares (Cauchy-Binet): no digits cancel with long arms.
  k.area = arms.ax * arms.by - arms.ay * arms.bx;
  k.determinant =
      inv_mass *
          (inv_mass + (ia * (arms.ax * arms.ax + arms.ay * arms.ay) + ib * (arms.bx * arms.bx + arms.by * arms.by))) +
      (ia * k.area) * (ib * k.area);
  return k;
}

/// 1 - cos(angle) of an arm that rotates by `angle`, as angle^2 / (2 + angle^2 / 2). The error is about angle^4 / 12,
/// and the value never exceeds 2.
template <typename V>
[[gnu::always_inline]] inline V versine(V angle) {
  const V x2 = angle * angle;
  return x2 / ((Real(2) - V{}) + (Real(0.5) - V{}) * x2);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
