// The inner loops of pins: revolute joints without spring, limits and motor, several at a time or in a row.
// SPDX-License-Identifier: MIT
// Source: as joint_rows.h; each lane does what solve_revolute (joint_pin.cpp) does for such a joint, in the same order.
// So does each pin of a row, to the signs of zeros: additions of nothing are among them.
#include "engine/joints/batched/pin_wide.h"

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {
namespace {

/// Where the impulse acts, and what it does there.
struct Hold {
  Arms arms;
  Wide k11, k12, k22, inv_determinant;
};

/// At the present poses; keeps it for passes that meet the same ones.
TICKTRUE_INLINE Hold find_hold(const Group& group, const Pair& pair, const Real* bodies, PinArms& out) {
  const Wide one = spread(1);
  const Arms arms = load_arms(group, pair, bodies);
  const PinMobility k = mobility_of(pair, arms);
  // Empty lanes have no mobility: they divide by one instead.
  const Hold hold{arms, k.k11, k.k12, k.k22, one / (k.determinant > Wide{} ? k.determinant : one)};
  group.store(out.ax, arms.ax);
  group.store(out.ay, arms.ay);
  group.store(out.bx, arms.bx);
  group.store(out.by, arms.by);
  group.store(out.ex, arms.ex);
  group.store(out.ey, arms.ey);
  group.store(out.k11, hold.k11);
  group.store(out.k12, hold.k12);
  group.store(out.k22, hold.k22);
  group.store(out.inv_determinant, hold.inv_determinant);
  return hold;
}

TICKTRUE_INLINE Hold load_hold(const Group& group, const PinArms& from) {
  return {{group.load(from.ax), group.load(from.ay), group.load(from.bx), group.load(from.by), group.load(from.ex),
           group.load(from.ey)},
          group.load(from.k11),
          group.load(from.k12),
          group.load(from.k22),
          group.load(from.inv_determinant)};
}

/// Soft: as the pass before found it. Rigid: bodies have moved since.
template <bool is_soft>
void solve(const PinWork& work) {
  const Wide h = spread(work.h);
  const Wide inv_h = spread(1 / work.h);
  for (std::size_t i = 0; i < work.batch_count; ++i) {
    PinBatch& batch = work.batches[i];
    for (int first = 0; first < batch.count; first += wide_count) {
      const Group group{batch, first};
      Pair pair = load_pair(group, work.bodies);
      Hold hold;
      if constexpr (is_soft)
        hold = load_hold(group, work.arms[i]);
      else
        hold = find_hold(group, pair, work.bodies, work.arms[i]);
      const Arms& arms = hold.arms;
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
      Wide px = -(hold.inv_determinant * (hold.k22 * vx - hold.k12 * vy));
      Wide py = -(hold.inv_determinant * (hold.k11 * vy - hold.k12 * vx));
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

template <bool has_moved>
void warm_start(const PinWork& work) {
  for (std::size_t i = 0; i < work.batch_count; ++i) {
    PinBatch& batch = work.batches[i];
    for (int first = 0; first < batch.count; first += wide_count) {
      const Group group{batch, first};
      Pair pair = load_pair(group, work.bodies);
      Hold hold;
      if constexpr (has_moved)
        hold = find_hold(group, pair, work.bodies, work.arms[i]);
      else
        hold = load_hold(group, work.arms[i]);
      push(group, pair, hold.arms, group.load(batch.impulse_x), group.load(batch.impulse_y), work.bodies);
    }
  }
}

// ---- In a row ----

void find_holds(const PinWork& work) {
  for (std::size_t i = 0; i < work.batch_count; ++i)
    for (int first = 0; first < work.batches[i].count; first += wide_count) {
      const Group group{work.batches[i], first};
      find_hold(group, load_pair(group, work.bodies), work.bodies, work.arms[i]);
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
  find_holds(work);
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
  find_holds(work);
  const Softness rigid;
  for (std::size_t i = 0; i < work.batch_count; ++i)
    for (int lane = 0; lane < work.batches[i].count; ++lane) solve_one<false>(work, rigid, RowPin(work, i, lane));
}

}  // namespace

PinKernels pin_kernels() {
  return {warm_start<true>, warm_start<false>, solve<true>, solve<false>, warm_start_row, solve_row, relax_row};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
