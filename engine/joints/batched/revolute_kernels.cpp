// The inner loops of plain revolute joints, several joints at a time or one at a time.
// SPDX-License-Identifier: MIT
// Source: as joint_rows.h. Each lane does the operations of solve_revolute (joint_point.cpp) in the same order. The
// serial path does the same, except for some additions of zero, which only affect signs of zeros.
#include "engine/joints/batched/revolute_simd.h"

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {
namespace {

/// The point constraint at the present poses.
struct PointConstraint {
  Arms arms;
  RealxN k11, k12, k22, inv_determinant;
};

/// Computes the constraint at the present poses and caches it for the passes until poses change.
TICKTRUE_INLINE PointConstraint compute_constraint(const LaneRange& lanes, const Pair& pair, const Real* bodies,
                                                   RevoluteArms& out) {
  const RealxN one = broadcast(1);
  const Arms arms = load_arms(lanes, pair, bodies);
  const PointMobility<RealxN> k = mobility_of(pair, arms);
  // Empty lanes have no mobility: their divisor is one.
  const PointConstraint constraint{arms, k.k11, k.k12, k.k22, one / (k.determinant > RealxN{} ? k.determinant : one)};
  lanes.store(out.ax, arms.ax);
  lanes.store(out.ay, arms.ay);
  lanes.store(out.bx, arms.bx);
  lanes.store(out.by, arms.by);
  lanes.store(out.ex, arms.ex);
  lanes.store(out.ey, arms.ey);
  lanes.store(out.k11, constraint.k11);
  lanes.store(out.k12, constraint.k12);
  lanes.store(out.k22, constraint.k22);
  lanes.store(out.inv_determinant, constraint.inv_determinant);
  return constraint;
}

TICKTRUE_INLINE PointConstraint load_constraint(const LaneRange& lanes, const RevoluteArms& from) {
  return {{lanes.load(from.ax), lanes.load(from.ay), lanes.load(from.bx), lanes.load(from.by), lanes.load(from.ex),
           lanes.load(from.ey)},
          lanes.load(from.k11),
          lanes.load(from.k12),
          lanes.load(from.k22),
          lanes.load(from.inv_determinant)};
}

/// Soft passes use the constraint that the pass before has cached. Rigid passes compute the constraint, since bodies
/// have moved.
template <bool is_soft>
void solve(const RevoluteWork& work) {
  const RealxN h = broadcast(work.h);
  const RealxN inv_h = broadcast(1 / work.h);
  for (std::size_t i = 0; i < work.batch_count; ++i) {
    RevoluteBatch& batch = work.batches[i];
    for (int first = 0; first < batch.count; first += simd_width) {
      const LaneRange lanes{batch, first};
      Pair pair = load_pair(lanes, work.bodies);
      PointConstraint constraint;
      if constexpr (is_soft)
        constraint = load_constraint(lanes, work.arms[i]);
      else
        constraint = compute_constraint(lanes, pair, work.bodies, work.arms[i]);
      const Arms& arms = constraint.arms;
      const RealxN wa = pair.a.at[2];
      const RealxN wb = pair.b.at[2];
      RealxN vx = (pair.b.at[0] - wb * arms.by) - (pair.a.at[0] - wa * arms.ay);
      RealxN vy = (pair.b.at[1] + wb * arms.bx) - (pair.a.at[1] + wa * arms.ax);
      if constexpr (is_soft) {
        const RealxN versine_a = versine(h * wa);
        const RealxN versine_b = versine(h * wb);
        const RealxN bias_rate = broadcast(work.soft.bias_rate);
        vx = (vx + inv_h * (versine_a * arms.ax - versine_b * arms.bx)) + bias_rate * arms.ex;
        vy = (vy + inv_h * (versine_a * arms.ay - versine_b * arms.by)) + bias_rate * arms.ey;
      }
      RealxN px = -(constraint.inv_determinant * (constraint.k22 * vx - constraint.k12 * vy));
      RealxN py = -(constraint.inv_determinant * (constraint.k11 * vy - constraint.k12 * vx));
      const RealxN old_x = lanes.load(batch.impulse_x);
      const RealxN old_y = lanes.load(batch.impulse_y);
      if constexpr (is_soft) {
        px = broadcast(work.soft.mass_scale) * px - broadcast(work.soft.impulse_scale) * old_x;
        py = broadcast(work.soft.mass_scale) * py - broadcast(work.soft.impulse_scale) * old_y;
      }
      lanes.store(batch.impulse_x, old_x + px);
      lanes.store(batch.impulse_y, old_y + py);
      apply_impulse(pair, arms, px, py);
      store_pair(lanes, pair, work.bodies);
    }
  }
}

template <bool has_moved>
void warm_start(const RevoluteWork& work) {
  for (std::size_t i = 0; i < work.batch_count; ++i) {
    RevoluteBatch& batch = work.batches[i];
    for (int first = 0; first < batch.count; first += simd_width) {
      const LaneRange lanes{batch, first};
      Pair pair = load_pair(lanes, work.bodies);
      PointConstraint constraint;
      if constexpr (has_moved)
        constraint = compute_constraint(lanes, pair, work.bodies, work.arms[i]);
      else
        constraint = load_constraint(lanes, work.arms[i]);
      apply_impulse(pair, constraint.arms, lanes.load(batch.impulse_x), lanes.load(batch.impulse_y));
      store_pair(lanes, pair, work.bodies);
    }
  }
}

// ---- Serial ----

void compute_constraints(const RevoluteWork& work) {
  for (std::size_t i = 0; i < work.batch_count; ++i)
    for (int first = 0; first < work.batches[i].count; first += simd_width) {
      const LaneRange lanes{work.batches[i], first};
      compute_constraint(lanes, load_pair(lanes, work.bodies), work.bodies, work.arms[i]);
    }
}

/// One joint of the serial path: velocities of its bodies, and the impulse between them.
struct SerialRevolute {
  RevoluteBatch& batch;
  const RevoluteArms& arms;
  Real* bodies;
  int lane;
  Real ax_v, ay_v, aw, bx_v, by_v, bw;  // velocities, m/s and rad/s

  TICKTRUE_INLINE SerialRevolute(const RevoluteWork& work, std::size_t index, int which)
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

  TICKTRUE_INLINE void apply_impulse(Real px, Real py) {
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

template <bool is_soft>
TICKTRUE_INLINE void solve_one(const RevoluteWork& work, const Softness& soft, SerialRevolute joint) {
  const int lane = joint.lane;
  const Real ax = joint.arms.ax.at[lane], ay = joint.arms.ay.at[lane];
  const Real bx = joint.arms.bx.at[lane], by = joint.arms.by.at[lane];
  Real arm_rate_x = 0, arm_rate_y = 0;
  if constexpr (is_soft) {
    const Real versine_a = versine(work.h * joint.aw);
    const Real versine_b = versine(work.h * joint.bw);
    arm_rate_x = (1 / work.h) * (versine_a * ax - versine_b * bx);
    arm_rate_y = (1 / work.h) * (versine_a * ay - versine_b * by);
  }
  const Real vx = (((joint.bx_v - joint.bw * by) - (joint.ax_v - joint.aw * ay)) + arm_rate_x) +
                  soft.bias_rate * joint.arms.ex.at[lane];
  const Real vy = (((joint.by_v + joint.bw * bx) - (joint.ay_v + joint.aw * ax)) + arm_rate_y) +
                  soft.bias_rate * joint.arms.ey.at[lane];
  const Real k11 = joint.arms.k11.at[lane], k12 = joint.arms.k12.at[lane], k22 = joint.arms.k22.at[lane];
  const Real inv_determinant = joint.arms.inv_determinant.at[lane];
  Real& impulse_x = joint.batch.impulse_x.at[lane];
  Real& impulse_y = joint.batch.impulse_y.at[lane];
  const Real px = -(soft.mass_scale * (inv_determinant * (k22 * vx - k12 * vy))) - soft.impulse_scale * impulse_x;
  const Real py = -(soft.mass_scale * (inv_determinant * (k11 * vy - k12 * vx))) - soft.impulse_scale * impulse_y;
  impulse_x = impulse_x + px;
  impulse_y = impulse_y + py;
  joint.apply_impulse(px, py);
}

void warm_start_serial(const RevoluteWork& work) {
  compute_constraints(work);
  for (std::size_t i = 0; i < work.batch_count; ++i)
    for (int lane = 0; lane < work.batches[i].count; ++lane) {
      SerialRevolute joint(work, i, lane);
      joint.bw = joint.bw + Real(0);  // matches the additions of spring, motor and limits in solve_revolute
      joint.apply_impulse(work.batches[i].impulse_x.at[lane], work.batches[i].impulse_y.at[lane]);
    }
}

void solve_serial(const RevoluteWork& work) {
  const Softness soft = work.soft;
  for (std::size_t i = 0; i < work.batch_count; ++i)
    for (int lane = 0; lane < work.batches[i].count; ++lane) solve_one<true>(work, soft, SerialRevolute(work, i, lane));
}

void relax_serial(const RevoluteWork& work) {
  compute_constraints(work);
  const Softness rigid;
  for (std::size_t i = 0; i < work.batch_count; ++i)
    for (int lane = 0; lane < work.batches[i].count; ++lane)
      solve_one<false>(work, rigid, SerialRevolute(work, i, lane));
}

}  // namespace

RevoluteKernels revolute_kernels() {
  return {warm_start<true>,  warm_start<false>, solve<true>, solve<false>,
          warm_start_serial, solve_serial,      relax_serial};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
