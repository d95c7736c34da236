// The parts that kernels of pinned joints share: two bodies held together at a point, several at a time.
// SPDX-License-Identifier: MIT
// Source: as joint_rows.h.
#pragma once

#include "engine/contacts/solver_kernels.h"
#include "engine/simd/quads.h"

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {

/// wide_count pins of a batch, starting at lane `first`.
struct Group {
  PinBatch& batch;
  int first;

  TICKTRUE_INLINE Wide load(const Lanes& lanes) const { return load_wide(lanes.at + first); }
  TICKTRUE_INLINE void store(Lanes& lanes, Wide value) const { store_wide(lanes.at + first, value); }
};

/// The two bodies and what the joint knows of them.
struct Pair {
  Quads a, b;  // x, y, angular, unused
  Wide inv_mass_a, inv_mass_b, inv_inertia_a, inv_inertia_b;
};

/// Where the impulse acts.
struct Arms {
  Wide ax, ay, bx, by;  // from the centres of mass, m
  Wide ex, ey;          // the anchors' gap, m
};

TICKTRUE_INLINE Pair load_pair(const Group& group, const Real* bodies) {
  return {gather_quads<body_record_length>(bodies, group.batch.read_a + group.first),
          gather_quads<body_record_length>(bodies, group.batch.read_b + group.first),
          group.load(group.batch.inv_mass_a),
          group.load(group.batch.inv_mass_b),
          group.load(group.batch.inv_inertia_a),
          group.load(group.batch.inv_inertia_b)};
}

/// joint_rows.h, middle_share.
TICKTRUE_INLINE Wide middle_share(const Pair& pair, const Arms& arms) {
  const Wide zero{};
  const Wide reach_a = pair.inv_inertia_a > zero ? arms.ax * arms.ax + arms.ay * arms.ay : zero;
  const Wide reach_b = pair.inv_inertia_b > zero ? arms.bx * arms.bx + arms.by * arms.by : zero;
  const Wide reach = larger(reach_a, reach_b);
  const Wide most = larger(spread(Real(0.25)) * (arms.ex * arms.ex + arms.ey * arms.ey), reach);
  const Wide half = spread(Real(0.5));
  return reach > zero ? half * (reach / (reach > zero ? most : spread(1))) : half;
}

/// `a`, `b`: what the bodies have moved and turned since the tick began.
TICKTRUE_INLINE Arms arms_of(const Group& group, const Pair& pair, const Quads& a, const Quads& b) {
  const PinBatch& batch = group.batch;
  const Wide anchor_a_x = group.load(batch.anchor_a_x), anchor_a_y = group.load(batch.anchor_a_y);
  const Wide anchor_b_x = group.load(batch.anchor_b_x), anchor_b_y = group.load(batch.anchor_b_y);
  Arms arms;
  arms.ax = a.at[2] * anchor_a_x - a.at[3] * anchor_a_y;
  arms.ay = a.at[3] * anchor_a_x + a.at[2] * anchor_a_y;
  arms.bx = b.at[2] * anchor_b_x - b.at[3] * anchor_b_y;
  arms.by = b.at[3] * anchor_b_x + b.at[2] * anchor_b_y;
  arms.ex = (group.load(batch.apart_x) + (b.at[0] - a.at[0])) + (arms.bx - arms.ax);
  arms.ey = (group.load(batch.apart_y) + (b.at[1] - a.at[1])) + (arms.by - arms.ay);
  const Wide share = middle_share(pair, arms);
  arms.ax = arms.ax + share * arms.ex;
  arms.ay = arms.ay + share * arms.ey;
  arms.bx = arms.bx - share * arms.ex;
  arms.by = arms.by - share * arms.ey;
  return arms;
}

TICKTRUE_INLINE Arms load_arms(const Group& group, const Pair& pair, const Real* bodies) {
  const Quads a = gather_quads<body_record_length>(bodies + 4, group.batch.read_a + group.first);
  const Quads b = gather_quads<body_record_length>(bodies + 4, group.batch.read_b + group.first);
  return arms_of(group, pair, a, b);
}

/// What an impulse at the point does to its velocity (joint_rows.h, point_row).
struct PinMobility {
  Wide k11, k12, k22;
  Wide determinant;
  Wide area;  // cross(arm of A, arm of B), m^2
};

TICKTRUE_INLINE PinMobility mobility_of(const Pair& pair, const Arms& arms) {
  const Wide inv_mass = pair.inv_mass_a + pair.inv_mass_b;
  const Wide ia = pair.inv_inertia_a;
  const Wide ib = pair.inv_inertia_b;
  PinMobility k;
  k.k11 = inv_mass + (ia * arms.ay * arms.ay + ib * arms.by * arms.by);
  k.k12 = -(ia * arms.ax * arms.ay + ib * arms.bx * arms.by);
  k.k22 = inv_mass + (ia * arms.ax * arms.ax + ib * arms.bx * arms.bx);
  k.area = arms.ax * arms.by - arms.ay * arms.bx;
  k.determinant =
      inv_mass *
          (inv_mass + (ia * (arms.ax * arms.ax + arms.ay * arms.ay) + ib * (arms.bx * arms.bx + arms.by * arms.by))) +
      (ia * k.area) * (ib * k.area);
  return k;
}

/// Adds impulse (px, py) at the point, -on A, +on B, and puts the velocities back.
TICKTRUE_INLINE void push(const Group& group, Pair& pair, const Arms& arms, Wide px, Wide py, Real* bodies) {
  pair.a.at[0] -= pair.inv_mass_a * px;
  pair.a.at[1] -= pair.inv_mass_a * py;
  pair.a.at[2] -= pair.inv_inertia_a * (arms.ax * py - arms.ay * px);
  pair.b.at[0] += pair.inv_mass_b * px;
  pair.b.at[1] += pair.inv_mass_b * py;
  pair.b.at[2] += pair.inv_inertia_b * (arms.bx * py - arms.by * px);
  scatter_quads<body_record_length>(bodies, group.batch.write_a + group.first, pair.a);
  scatter_quads<body_record_length>(bodies, group.batch.write_b + group.first, pair.b);
}

/// How far an arm that turns ends short of where its tangent leads, in shares of the arm (joint_rows.h, turning_rate).
TICKTRUE_INLINE Wide short_of(Wide turn) {
  const Wide x2 = turn * turn;
  return x2 / (spread(2) + spread(Real(0.5)) * x2);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
