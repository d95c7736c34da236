// Parts of the kernels of revolute joints: the point constraint of two bodies, several joints at a time.
// SPDX-License-Identifier: MIT
// Source: as joint_rows.h.
#pragma once

#include "engine/joints/batched/revolute_point.h"
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

using Arms = PointArms<RealxN>;

TICKTRUE_INLINE Pair load_pair(const LaneRange& lanes, const Real* bodies) {
  return {gather4<body_record_length>(bodies, lanes.batch.read_a + lanes.first),
          gather4<body_record_length>(bodies, lanes.batch.read_b + lanes.first),
          lanes.load(lanes.batch.inv_mass_a),
          lanes.load(lanes.batch.inv_mass_b),
          lanes.load(lanes.batch.inv_inertia_a),
          lanes.load(lanes.batch.inv_inertia_b)};
}

/// Arms to the point of the impulse. `a`, `b`: delta positions and delta rotations of the bodies since the tick began.
TICKTRUE_INLINE Arms arms_of(const LaneRange& lanes, const Pair& pair, const Columns4xN& a, const Columns4xN& b) {
  const RevoluteBatch& batch = lanes.batch;
  const auto load_two = [&](const Lanes& x, const Lanes& y) -> PointPair<RealxN> {
    return {lanes.load(x), lanes.load(y)};
  };
  Arms arms =
      anchor_arms<RealxN>({a.at[0], a.at[1], a.at[2], a.at[3]}, {b.at[0], b.at[1], b.at[2], b.at[3]},
                          load_two(batch.anchor_a_x, batch.anchor_a_y), load_two(batch.anchor_b_x, batch.anchor_b_y),
                          load_two(batch.center_offset_x, batch.center_offset_y));
  meet_in_the_middle(arms, middle_share(arms, pair.inv_inertia_a, pair.inv_inertia_b));
  return arms;
}

TICKTRUE_INLINE Arms load_arms(const LaneRange& lanes, const Pair& pair, const Real* bodies) {
  const Columns4xN a = gather4<body_record_length>(bodies + 4, lanes.batch.read_a + lanes.first);
  const Columns4xN b = gather4<body_record_length>(bodies + 4, lanes.batch.read_b + lanes.first);
  return arms_of(lanes, pair, a, b);
}

TICKTRUE_INLINE PointMobility<RealxN> mobility_of(const Pair& pair, const Arms& arms) {
  return point_mobility(arms, pair.inv_mass_a + pair.inv_mass_b, pair.inv_inertia_a, pair.inv_inertia_b);
}

/// Applies impulse (px, py) at the point, -on A, +on B.
TICKTRUE_INLINE void apply_impulse(Pair& pair, const Arms& arms, RealxN px, RealxN py) {
  pair.a.at[0] -= pair.inv_mass_a * px;
  pair.a.at[1] -= pair.inv_mass_a * py;
  pair.a.at[2] -= pair.inv_inertia_a * (arms.ax * py - arms.ay * px);
  pair.b.at[0] += pair.inv_mass_b * px;
  pair.b.at[1] += pair.inv_mass_b * py;
  pair.b.at[2] += pair.inv_inertia_b * (arms.bx * py - arms.by * px);
}

TICKTRUE_INLINE void store_pair(const LaneRange& lanes, const Pair& pair, Real* bodies) {
  scatter4<body_record_length>(bodies, lanes.batch.write_a + lanes.first, pair.a);
  scatter4<body_record_length>(bodies, lanes.batch.write_b + lanes.first, pair.b);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
