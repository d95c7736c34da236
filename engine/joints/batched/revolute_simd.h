// Parts of the kernels of revolute joints: the point constraint of two bodies, several joints at a time.
// SPDX-License-Identifier: MIT
// Source: as joint_rows.h.
#pragma once

#include "engine/model/solver_kernels.h"
#include "engine/simd/transpose.h"

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {

/// simd_width joints of a batch, from lane `first` on.
struct LaneRange {
  RevoluteBatch& batch;
  int first;

  TICKTRUE_INLINE RealxN load(const Lanes& lanes) const { return load_xn(lanes.at + first); }
  TICKTRUE_INLINE void store(Lanes& lanes, RealxN value) const { store_xn(lanes.at + first, value); }
};

/// Velocities and inverse masses of the two bodies.
struct Pair {
  Columns4xN a, b;  // x, y, angular, unused
  RealxN inv_mass_a, inv_mass_b, inv_inertia_a, inv_inertia_b;
};

/// Where the impulse acts.
struct Arms {
  RealxN ax, ay, bx, by;  // from the centres of mass, m
  RealxN ex, ey;          // from A's anchor to B's, m
};

TICKTRUE_INLINE Pair load_pair(const LaneRange& lanes, const Real* bodies) {
  return {gather4<body_record_length>(bodies, lanes.batch.read_a + lanes.first),
          gather4<body_record_length>(bodies, lanes.batch.read_b + lanes.first),
          lanes.load(lanes.batch.inv_mass_a),
          lanes.load(lanes.batch.inv_mass_b),
          lanes.load(lanes.batch.inv_inertia_a),
          lanes.load(lanes.batch.inv_inertia_b)};
}

/// joint_rows.h, middle_share.
TICKTRUE_INLINE RealxN middle_share(const Pair& pair, const Arms& arms) {
  const RealxN zero{};
  const RealxN arm2_a = pair.inv_inertia_a > zero ? arms.ax * arms.ax + arms.ay * arms.ay : zero;
  const RealxN arm2_b = pair.inv_inertia_b > zero ? arms.bx * arms.bx + arms.by * arms.by : zero;
  const RealxN arm2 = larger(arm2_a, arm2_b);
  const RealxN most = larger(broadcast(Real(0.25)) * (arms.ex * arms.ex + arms.ey * arms.ey), arm2);
  const RealxN half = broadcast(Real(0.5));
  return arm2 > zero ? half * (arm2 / (arm2 > zero ? most : broadcast(1))) : half;
}

/// `a`, `b`: delta positions and delta rotations of the bodies since the tick began.
TICKTRUE_INLINE Arms arms_of(const LaneRange& lanes, const Pair& pair, const Columns4xN& a, const Columns4xN& b) {
  const RevoluteBatch& batch = lanes.batch;
  const RealxN anchor_a_x = lanes.load(batch.anchor_a_x), anchor_a_y = lanes.load(batch.anchor_a_y);
  const RealxN anchor_b_x = lanes.load(batch.anchor_b_x), anchor_b_y = lanes.load(batch.anchor_b_y);
  Arms arms;
  arms.ax = a.at[2] * anchor_a_x - a.at[3] * anchor_a_y;
  arms.ay = a.at[3] * anchor_a_x + a.at[2] * anchor_a_y;
  arms.bx = b.at[2] * anchor_b_x - b.at[3] * anchor_b_y;
  arms.by = b.at[3] * anchor_b_x + b.at[2] * anchor_b_y;
  arms.ex = (lanes.load(batch.center_offset_x) + (b.at[0] - a.at[0])) + (arms.bx - arms.ax);
  arms.ey = (lanes.load(batch.center_offset_y) + (b.at[1] - a.at[1])) + (arms.by - arms.ay);
  const RealxN share = middle_share(pair, arms);
  arms.ax = arms.ax + share * arms.ex;
  arms.ay = arms.ay + share * arms.ey;
  arms.bx = arms.bx - share * arms.ex;
  arms.by = arms.by - share * arms.ey;
  return arms;
}

TICKTRUE_INLINE Arms load_arms(const LaneRange& lanes, const Pair& pair, const Real* bodies) {
  const Columns4xN a = gather4<body_record_length>(bodies + 4, lanes.batch.read_a + lanes.first);
  const Columns4xN b = gather4<body_record_length>(bodies + 4, lanes.batch.read_b + lanes.first);
  return arms_of(lanes, pair, a, b);
}

/// The mobility of the point: velocity per impulse (joint_rows.h, point_row).
struct PointMobility {
  RealxN k11, k12, k22;
  RealxN determinant;
  RealxN area;  // cross(arm of A, arm of B), m^2
};

TICKTRUE_INLINE PointMobility mobility_of(const Pair& pair, const Arms& arms) {
  const RealxN inv_mass = pair.inv_mass_a + pair.inv_mass_b;
  const RealxN ia = pair.inv_inertia_a;
  const RealxN ib = pair.inv_inertia_b;
  PointMobility k;
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

/// Applies impulse (px, py) at the point, -on A, +on B, and writes the velocities back.
TICKTRUE_INLINE void apply_impulse(const LaneRange& lanes, Pair& pair, const Arms& arms, RealxN px, RealxN py,
                                   Real* bodies) {
  pair.a.at[0] -= pair.inv_mass_a * px;
  pair.a.at[1] -= pair.inv_mass_a * py;
  pair.a.at[2] -= pair.inv_inertia_a * (arms.ax * py - arms.ay * px);
  pair.b.at[0] += pair.inv_mass_b * px;
  pair.b.at[1] += pair.inv_mass_b * py;
  pair.b.at[2] += pair.inv_inertia_b * (arms.bx * py - arms.by * px);
  scatter4<body_record_length>(bodies, lanes.batch.write_a + lanes.first, pair.a);
  scatter4<body_record_length>(bodies, lanes.batch.write_b + lanes.first, pair.b);
}

/// 1 - cos(angle) of an arm that rotates by `angle` (joint_rows.h, arm_rotation_rate).
TICKTRUE_INLINE RealxN versine(RealxN angle) {
  const RealxN x2 = angle * angle;
  return x2 / (broadcast(2) + broadcast(Real(0.5)) * x2);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
