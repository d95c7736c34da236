// The inner loops of revolute joints with a spring, limits or a motor, several joints at a time.
// SPDX-License-Identifier: MIT
// Source: as joint_rows.h. Each lane does the operations of solve_revolute (joint_point.cpp) in the same order, with
// selections instead of branches.
#include "engine/joints/batched/revolute_simd.h"
#include "engine/math/arc_tangent.h"

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {
namespace {

using MaskxN = decltype(RealxN{} > RealxN{});
using Doubles = double __attribute__((vector_size(simd_size)));
constexpr int double_count = simd_size / static_cast<int>(sizeof(double));
constexpr int angle_parts = simd_width / double_count;

/// joint_rows.h, relative_angle.
TICKTRUE_INLINE RealxN relative_angle(const RealxN& ac, const RealxN& as, const RealxN& bc, const RealxN& bs,
                                      RealxN rotation_c, RealxN rotation_s) {
  const RealxN c = ac * bc + as * bs;
  const RealxN s = ac * bs - as * bc;
  const RealxN qc = c * rotation_c - s * rotation_s;
  const RealxN qs = s * rotation_c + c * rotation_s;
  Real angles[simd_width];
  for (int part = 0; part < angle_parts; ++part) {
    Doubles y{}, x{};
    for (int i = 0; i < double_count; ++i) {
      y[i] = static_cast<double>(qs[part * double_count + i]);
      x[i] = static_cast<double>(qc[part * double_count + i]);
    }
    const Doubles angle = arc_tangent_of(y, x);
    for (int i = 0; i < double_count; ++i) angles[part * double_count + i] = static_cast<Real>(angle[i]);
  }
  return load_xn(angles);
}

/// The row of the angle, with the reaction of the point constraint (joint_rows.h, ConstrainedAngleRow).
struct AngleRow {
  RealxN mobility;
  RealxN reaction_x, reaction_y;  // 1/m
  RealxN torque_a, torque_b;      // of the impulse and its reaction, per impulse
  MaskxN works;
};

/// A joint while it is solved.
struct DrivenRevolute {
  Pair pair;
  Arms arms;
  AngleRow row;
  RealxN linear_x, linear_y;  // N s, accumulated

  TICKTRUE_INLINE RealxN speed() const { return pair.b.at[2] - pair.a.at[2]; }
  TICKTRUE_INLINE void apply(MaskxN where, RealxN impulse) {
    const RealxN px = impulse * row.reaction_x;
    const RealxN py = impulse * row.reaction_y;
    const auto set = [&](RealxN& value, RealxN changed) { value = where ? changed : value; };
    set(pair.a.at[0], pair.a.at[0] - pair.inv_mass_a * px);
    set(pair.a.at[1], pair.a.at[1] - pair.inv_mass_a * py);
    set(pair.a.at[2], pair.a.at[2] - pair.inv_inertia_a * row.torque_a * impulse);
    set(pair.b.at[0], pair.b.at[0] + pair.inv_mass_b * px);
    set(pair.b.at[1], pair.b.at[1] + pair.inv_mass_b * py);
    set(pair.b.at[2], pair.b.at[2] + pair.inv_inertia_b * row.torque_b * impulse);
    set(linear_x, linear_x + px);
    set(linear_y, linear_y + py);
  }
};

/// The sum of a joint's impulses about the angle, N m s.
TICKTRUE_INLINE RealxN impulse_about(const LaneRange& lanes, const DrivenRevoluteBatch& batch) {
  return (lanes.load(batch.spring_impulse) + lanes.load(batch.motor_impulse)) +
         (lanes.load(batch.lower_impulse) - lanes.load(batch.upper_impulse));
}

TICKTRUE_INLINE RealxN clamped(RealxN value, RealxN limit) {
  return larger(smaller(value, limit), -limit);
}

TICKTRUE_INLINE void solve_spring(const LaneRange& lanes, DrivenRevoluteBatch& batch, DrivenRevolute& joint,
                                  RealxN angle) {
  constexpr Real no_limit = sizeof(Real) == 4 ? Real(0x1p127) : Real(0x1p1023);
  const MaskxN where = (lanes.load(batch.has_spring) > RealxN{}) & joint.row.works;
  const RealxN old = lanes.load(batch.spring_impulse);
  const RealxN start = lanes.load(batch.start_speed);
  const RealxN others = (joint.speed() - joint.row.mobility * old) - start;
  const RealxN wanted = -(lanes.load(batch.velocity_gain) * start + lanes.load(batch.position_gain) * angle +
                          lanes.load(batch.change_gain) * others) /
                        joint.row.mobility;
  const RealxN total = clamped(wanted, broadcast(no_limit));
  joint.apply(where, total - old);
  lanes.store(batch.spring_impulse, where ? total : old);
}

TICKTRUE_INLINE void solve_motor(const LaneRange& lanes, DrivenRevoluteBatch& batch, DrivenRevolute& joint) {
  const MaskxN where = (lanes.load(batch.has_motor) > RealxN{}) & joint.row.works;
  const RealxN old = lanes.load(batch.motor_impulse);
  const RealxN total = clamped(old - (joint.speed() - lanes.load(batch.motor_speed)) / joint.row.mobility,
                               lanes.load(batch.motor_impulse_max));
  joint.apply(where, total - old);
  lanes.store(batch.motor_impulse, where ? total : old);
}

/// joint_rows.h, solve_limit. `soft`: softness in this pass.
TICKTRUE_INLINE void solve_limit(const LaneRange& lanes, DrivenRevoluteBatch& batch, DrivenRevolute& joint,
                                 RealxN slack, Real sign, RealxN h, const Softness& soft, Lanes& impulse) {
  const RealxN zero{};
  const RealxN one = broadcast(1);
  const MaskxN where = (lanes.load(batch.has_limits) > zero) & joint.row.works;
  const MaskxN is_beyond = slack < zero;
  const RealxN target = is_beyond ? broadcast(soft.bias_rate) * slack : slack / h;
  const RealxN mass_scale = is_beyond ? broadcast(soft.mass_scale) : one;
  const RealxN impulse_scale = is_beyond ? broadcast(soft.impulse_scale) : zero;
  const RealxN old = lanes.load(impulse);
  const RealxN wanted = mass_scale * (broadcast(sign) * joint.speed() + target) / joint.row.mobility;
  const RealxN total = larger((old - wanted) - impulse_scale * old, zero);
  joint.apply(where, broadcast(sign) * (total - old));
  lanes.store(impulse, where ? total : old);
}

template <bool is_soft>
void solve(const DrivenRevoluteWork& work) {
  const RealxN zero{};
  const RealxN one = broadcast(1);
  const RealxN h = broadcast(work.h);
  const RealxN inv_h = broadcast(1 / work.h);
  const Softness soft = is_soft ? work.soft : Softness{};
  for (std::size_t i = 0; i < work.batch_count; ++i) {
    DrivenRevoluteBatch& batch = work.batches[i];
    for (int first = 0; first < batch.point.count; first += simd_width) {
      const LaneRange lanes{batch.point, first};
      DrivenRevolute joint;
      joint.pair = load_pair(lanes, work.bodies);
      const Columns4xN pose_a = gather4<body_record_length>(work.bodies + 4, batch.point.read_a + first);
      const Columns4xN pose_b = gather4<body_record_length>(work.bodies + 4, batch.point.read_b + first);
      joint.arms = arms_of(lanes, joint.pair, pose_a, pose_b);
      const Pair& pair = joint.pair;
      const Arms& arms = joint.arms;
      const RealxN m = pair.inv_mass_a + pair.inv_mass_b;
      const RealxN ia = pair.inv_inertia_a;
      const RealxN ib = pair.inv_inertia_b;
      const PointMobility<RealxN> k = mobility_of(pair, arms);
      const RealxN inv_determinant = one / (k.determinant > zero ? k.determinant : one);
      const RealxN length2_a = arms.ax * arms.ax + arms.ay * arms.ay;
      const RealxN length2_b = arms.bx * arms.bx + arms.by * arms.by;
      const RealxN difference_x = arms.ax - arms.bx;
      const RealxN difference_y = arms.ay - arms.by;
      const MaskxN works = ~((m <= zero) | (ia + ib <= zero));
      const RealxN some_m = works ? m : one;
      const RealxN over = some_m * (ia + ib) + ia * ib * (difference_x * difference_x + difference_y * difference_y);
      const RealxN under = some_m + (ia * length2_a + ib * length2_b) + ia * k.area * (ib * k.area / some_m);
      const RealxN coupling_x = -(ia * arms.ay + ib * arms.by);
      const RealxN coupling_y = ia * arms.ax + ib * arms.bx;
      joint.row.mobility = works ? over / under : one;
      joint.row.works = works & ~(joint.row.mobility <= zero);
      joint.row.mobility = joint.row.works ? joint.row.mobility : one;
      const RealxN inv_under = one / under;
      const RealxN leaned = ia * k.area * (ib / some_m);
      joint.row.reaction_x = inv_under * (leaned * difference_x - coupling_x);
      joint.row.reaction_y = inv_under * (leaned * difference_y - coupling_y);
      joint.row.torque_a = (some_m - ib * (arms.bx * difference_x + arms.by * difference_y)) / under;
      joint.row.torque_b = (some_m + ia * (arms.ax * difference_x + arms.ay * difference_y)) / under;
      joint.linear_x = lanes.load(batch.point.impulse_x);
      joint.linear_y = lanes.load(batch.point.impulse_y);

      const RealxN wa = joint.pair.a.at[2];
      const RealxN wb = joint.pair.b.at[2];
      RealxN vx = (joint.pair.b.at[0] - wb * arms.by) - (joint.pair.a.at[0] - wa * arms.ay);
      RealxN vy = (joint.pair.b.at[1] + wb * arms.bx) - (joint.pair.a.at[1] + wa * arms.ax);
      RealxN arm_rate_x = zero, arm_rate_y = zero;
      if constexpr (is_soft) {
        const RealxN versine_a = versine(h * wa);
        const RealxN versine_b = versine(h * wb);
        arm_rate_x = inv_h * (versine_a * arms.ax - versine_b * arms.bx);
        arm_rate_y = inv_h * (versine_a * arms.ay - versine_b * arms.by);
      }
      vx = (vx + arm_rate_x) + broadcast(soft.bias_rate) * arms.ex;
      vy = (vy + arm_rate_y) + broadcast(soft.bias_rate) * arms.ey;
      const RealxN wanted_x = inv_determinant * (k.k22 * vx - k.k12 * vy);
      const RealxN wanted_y = inv_determinant * (k.k11 * vy - k.k12 * vx);
      // joint_rows.h, stiff_share
      const RealxN driven = impulse_about(lanes, batch);
      const RealxN reaction_x = works ? driven * joint.row.reaction_x : zero;
      const RealxN reaction_y = works ? driven * joint.row.reaction_y : zero;
      const RealxN moved_x = k.k11 * reaction_x + k.k12 * reaction_y;
      const RealxN moved_y = k.k12 * reaction_x + k.k22 * reaction_y;
      const RealxN part = joint.linear_x * moved_x + joint.linear_y * moved_y;
      const RealxN whole = reaction_x * moved_x + reaction_y * moved_y;
      const RealxN wanted_share = whole > zero ? part / (whole > zero ? whole : one) : zero;
      const RealxN share = larger(smaller(wanted_share, one), zero);
      const RealxN soft_x = joint.linear_x - share * reaction_x;
      const RealxN soft_y = joint.linear_y - share * reaction_y;
      const RealxN px = -(broadcast(soft.mass_scale) * wanted_x) - broadcast(soft.impulse_scale) * soft_x;
      const RealxN py = -(broadcast(soft.mass_scale) * wanted_y) - broadcast(soft.impulse_scale) * soft_y;
      joint.linear_x += px;
      joint.linear_y += py;
      apply_impulse(joint.pair, arms, px, py);

      RealxN angle = zero;
      if (batch.needs_angle != 0)
        angle = relative_angle(pose_a.at[2], pose_a.at[3], pose_b.at[2], pose_b.at[3], lanes.load(batch.rotation_c),
                               lanes.load(batch.rotation_s));
      if (is_soft) solve_spring(lanes, batch, joint, angle);
      solve_motor(lanes, batch, joint);
      solve_limit(lanes, batch, joint, angle - lanes.load(batch.lower), 1, h, soft, batch.lower_impulse);
      solve_limit(lanes, batch, joint, lanes.load(batch.upper) - angle, -1, h, soft, batch.upper_impulse);
      lanes.store(batch.point.impulse_x, joint.linear_x);
      lanes.store(batch.point.impulse_y, joint.linear_y);
      store_pair(lanes, joint.pair, work.bodies);
    }
  }
}

void warm_start(const DrivenRevoluteWork& work) {
  for (std::size_t i = 0; i < work.batch_count; ++i) {
    DrivenRevoluteBatch& batch = work.batches[i];
    for (int first = 0; first < batch.point.count; first += simd_width) {
      const LaneRange lanes{batch.point, first};
      Pair pair = load_pair(lanes, work.bodies);
      const Arms arms = load_arms(lanes, pair, work.bodies);
      const RealxN impulse = impulse_about(lanes, batch);
      pair.a.at[2] -= pair.inv_inertia_a * impulse;
      pair.b.at[2] += pair.inv_inertia_b * impulse;
      apply_impulse(pair, arms, lanes.load(batch.point.impulse_x), lanes.load(batch.point.impulse_y));
      store_pair(lanes, pair, work.bodies);
    }
  }
}

void save_velocities(const DrivenRevoluteWork& work) {
  for (std::size_t i = 0; i < work.batch_count; ++i) {
    DrivenRevoluteBatch& batch = work.batches[i];
    for (int first = 0; first < batch.point.count; first += simd_width) {
      const LaneRange lanes{batch.point, first};
      const Pair pair = load_pair(lanes, work.bodies);
      lanes.store(batch.start_speed, pair.b.at[2] - pair.a.at[2]);
    }
  }
}

}  // namespace

DrivenRevoluteKernels driven_revolute_kernels() {
  return {save_velocities, warm_start, solve<true>, solve<false>};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
