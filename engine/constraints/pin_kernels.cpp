// The inner loops of pins: revolute joints without spring, limits and motor, several at a time or in a row.
// SPDX-License-Identifier: MIT
// Source: as joint_rows.h; each lane does what solve_revolute (joint_pin.cpp) does for such a joint, in the same order.
// So does each pin of a row, to the signs of zeros: additions of nothing are among them.
#include "engine/constraints/solver_kernels.h"
#include "engine/math/quads.h"

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {
namespace {

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

TICKTRUE_INLINE Arms load_arms(const Group& group, const Pair& pair, const Real* bodies) {
  const PinBatch& batch = group.batch;
  const Quads a = gather_quads<body_record_length>(bodies + 4, batch.read_a + group.first);
  const Quads b = gather_quads<body_record_length>(bodies + 4, batch.read_b + group.first);
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

/// joint_rows.h, point_row.
struct Mobility {
  Wide k11, k12, k22, determinant;
};
TICKTRUE_INLINE Mobility mobility_of(const Pair& pair, const Arms& arms) {
  const Wide inv_mass = pair.inv_mass_a + pair.inv_mass_b;
  const Wide ia = pair.inv_inertia_a;
  const Wide ib = pair.inv_inertia_b;
  const Wide area = arms.ax * arms.by - arms.ay * arms.bx;
  return {inv_mass + (ia * arms.ay * arms.ay + ib * arms.by * arms.by),
          -(ia * arms.ax * arms.ay + ib * arms.bx * arms.by),
          inv_mass + (ia * arms.ax * arms.ax + ib * arms.bx * arms.bx),
          inv_mass * (inv_mass +
                      (ia * (arms.ax * arms.ax + arms.ay * arms.ay) + ib * (arms.bx * arms.bx + arms.by * arms.by))) +
              (ia * area) * (ib * area)};
}

template <bool is_soft>
void solve(const PinWork& work) {
  const Wide h = spread(work.h);
  const Wide inv_h = spread(1 / work.h);
  const Wide one = spread(1);
  for (std::size_t i = 0; i < work.batch_count; ++i) {
    PinBatch& batch = work.batches[i];
    for (int first = 0; first < batch.count; first += wide_count) {
      const Group group{batch, first};
      Pair pair = load_pair(group, work.bodies);
      const Arms arms = load_arms(group, pair, work.bodies);
      const Mobility k = mobility_of(pair, arms);
      const Wide wa = pair.a.at[2];
      const Wide wb = pair.b.at[2];
      Wide vx = (pair.b.at[0] - wb * arms.by) - (pair.a.at[0] - wa * arms.ay);
      Wide vy = (pair.b.at[1] + wb * arms.bx) - (pair.a.at[1] + wa * arms.ax);
      if constexpr (is_soft) {
        const Wide short_a = short_of(h * wa);
        const Wide short_b = short_of(h * wb);
        const Wide bias_rate = spread(work.soft.bias_rate);
        vx = (vx + inv_h * (short_a * arms.ax - short_b * arms.bx)) + bias_rate * arms.ex;
        vy = (vy + inv_h * (short_a * arms.ay - short_b * arms.by)) + bias_rate * arms.ey;
      }
      // Empty lanes have no mobility: they divide by one instead.
      const Wide inv_determinant = one / (k.determinant > Wide{} ? k.determinant : one);
      Wide px = -(inv_determinant * (k.k22 * vx - k.k12 * vy));
      Wide py = -(inv_determinant * (k.k11 * vy - k.k12 * vx));
      const Wide old_x = group.load(batch.impulse_x);
      const Wide old_y = group.load(batch.impulse_y);
      if constexpr (is_soft) {
        px = spread(work.soft.mass_scale) * px - spread(work.soft.impulse_scale) * old_x;
        py = spread(work.soft.mass_scale) * py - spread(work.soft.impulse_scale) * old_y;
      }
      group.store(batch.impulse_x, old_x + px);
      group.store(batch.impulse_y, old_y + py);
      push(group, pair, arms, px, py, work.bodies);
    }
  }
}

void warm_start(const PinWork& work) {
  for (std::size_t i = 0; i < work.batch_count; ++i) {
    PinBatch& batch = work.batches[i];
    for (int first = 0; first < batch.count; first += wide_count) {
      const Group group{batch, first};
      Pair pair = load_pair(group, work.bodies);
      const Arms arms = load_arms(group, pair, work.bodies);
      push(group, pair, arms, group.load(batch.impulse_x), group.load(batch.impulse_y), work.bodies);
    }
  }
}

// ---- In a row ----

void find_arms(const PinWork& work) {
  const Wide one = spread(1);
  for (std::size_t i = 0; i < work.batch_count; ++i) {
    PinArms& out = work.arms[i];
    for (int first = 0; first < work.batches[i].count; first += wide_count) {
      const Group group{work.batches[i], first};
      const Pair pair = load_pair(group, work.bodies);
      const Arms arms = load_arms(group, pair, work.bodies);
      const Mobility k = mobility_of(pair, arms);
      group.store(out.ax, arms.ax);
      group.store(out.ay, arms.ay);
      group.store(out.bx, arms.bx);
      group.store(out.by, arms.by);
      group.store(out.ex, arms.ex);
      group.store(out.ey, arms.ey);
      group.store(out.k11, k.k11);
      group.store(out.k12, k.k12);
      group.store(out.k22, k.k22);
      group.store(out.inv_determinant, one / (k.determinant > Wide{} ? k.determinant : one));
    }
  }
}

/// One pin of a row: its bodies' velocities in and out, and the impulses between them.
struct RowPin {
  PinBatch& batch;
  const PinArms& arms;
  Real* bodies;
  int lane;
  Real ax_v, ay_v, aw, bx_v, by_v, bw;  // velocities, m/s and rad/s

  TICKTRUE_INLINE RowPin(const PinWork& work, std::size_t index, int which)
      : batch(work.batches[index]), arms(work.arms[index]), bodies(work.bodies), lane(which) {
    const Real* a = bodies + static_cast<std::size_t>(batch.read_a[lane]) * body_record_length;
    const Real* b = bodies + static_cast<std::size_t>(batch.read_b[lane]) * body_record_length;
    ax_v = a[0];
    ay_v = a[1];
    aw = a[2];
    bx_v = b[0];
    by_v = b[1];
    bw = b[2];
  }

  TICKTRUE_INLINE void push(Real px, Real py) {
    Real* a = bodies + static_cast<std::size_t>(batch.write_a[lane]) * body_record_length;
    Real* b = bodies + static_cast<std::size_t>(batch.write_b[lane]) * body_record_length;
    a[0] = ax_v - batch.inv_mass_a.at[lane] * px;
    a[1] = ay_v - batch.inv_mass_a.at[lane] * py;
    a[2] = aw - batch.inv_inertia_a.at[lane] * (arms.ax.at[lane] * py - arms.ay.at[lane] * px);
    b[0] = bx_v + batch.inv_mass_b.at[lane] * px;
    b[1] = by_v + batch.inv_mass_b.at[lane] * py;
    b[2] = bw + batch.inv_inertia_b.at[lane] * (arms.bx.at[lane] * py - arms.by.at[lane] * px);
  }
};

TICKTRUE_INLINE Real short_of(Real turn) {
  const Real x2 = turn * turn;
  return x2 / (2 + Real(0.5) * x2);
}

template <bool is_soft>
TICKTRUE_INLINE void solve_one(const PinWork& work, const Softness& soft, RowPin pin) {
  const int lane = pin.lane;
  const Real ax = pin.arms.ax.at[lane], ay = pin.arms.ay.at[lane];
  const Real bx = pin.arms.bx.at[lane], by = pin.arms.by.at[lane];
  Real turning_x = 0, turning_y = 0;
  if constexpr (is_soft) {
    const Real short_a = short_of(work.h * pin.aw);
    const Real short_b = short_of(work.h * pin.bw);
    turning_x = (1 / work.h) * (short_a * ax - short_b * bx);
    turning_y = (1 / work.h) * (short_a * ay - short_b * by);
  }
  const Real vx =
      (((pin.bx_v - pin.bw * by) - (pin.ax_v - pin.aw * ay)) + turning_x) + soft.bias_rate * pin.arms.ex.at[lane];
  const Real vy =
      (((pin.by_v + pin.bw * bx) - (pin.ay_v + pin.aw * ax)) + turning_y) + soft.bias_rate * pin.arms.ey.at[lane];
  const Real k11 = pin.arms.k11.at[lane], k12 = pin.arms.k12.at[lane], k22 = pin.arms.k22.at[lane];
  const Real inv_determinant = pin.arms.inv_determinant.at[lane];
  Real& impulse_x = pin.batch.impulse_x.at[lane];
  Real& impulse_y = pin.batch.impulse_y.at[lane];
  const Real px = -(soft.mass_scale * (inv_determinant * (k22 * vx - k12 * vy))) - soft.impulse_scale * impulse_x;
  const Real py = -(soft.mass_scale * (inv_determinant * (k11 * vy - k12 * vx))) - soft.impulse_scale * impulse_y;
  impulse_x = impulse_x + px;
  impulse_y = impulse_y + py;
  pin.push(px, py);
}

void warm_start_row(const PinWork& work) {
  find_arms(work);
  for (std::size_t i = 0; i < work.batch_count; ++i)
    for (int lane = 0; lane < work.batches[i].count; ++lane) {
      RowPin pin(work, i, lane);
      pin.bw = pin.bw + Real(0);  // what springs, motors and limits would push
      pin.push(work.batches[i].impulse_x.at[lane], work.batches[i].impulse_y.at[lane]);
    }
}

void solve_row(const PinWork& work) {
  const Softness soft = work.soft;
  for (std::size_t i = 0; i < work.batch_count; ++i)
    for (int lane = 0; lane < work.batches[i].count; ++lane) solve_one<true>(work, soft, RowPin(work, i, lane));
}

void relax_row(const PinWork& work) {
  find_arms(work);
  const Softness rigid;
  for (std::size_t i = 0; i < work.batch_count; ++i)
    for (int lane = 0; lane < work.batches[i].count; ++lane) solve_one<false>(work, rigid, RowPin(work, i, lane));
}

}  // namespace

PinKernels pin_kernels() {
  return {warm_start, solve<true>, solve<false>, warm_start_row, solve_row, relax_row};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
