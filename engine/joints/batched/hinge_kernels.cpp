// The inner loops of revolute joints with spring, limits or motor, several at a time.
// SPDX-License-Identifier: MIT
// Source: as joint_rows.h; each lane does what solve_revolute (joint_pin.cpp) does for such a joint, in the same order,
// with selections in the place of branches.
#include "engine/joints/batched/pin_wide.h"
#include "engine/math/arc_tangent_terms.h"

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {
namespace {

using Mask = decltype(Wide{} > Wide{});
using Doubles = double __attribute__((vector_size(wide_size)));
constexpr int double_count = wide_size / static_cast<int>(sizeof(double));
constexpr int angle_parts = wide_count / double_count;

TICKTRUE_INLINE Doubles all(double value) {
  return value - Doubles{};
}

/// Element by element what arc_tangent does (math/trig.cpp).
TICKTRUE_INLINE Doubles arc_tangent(Doubles y, Doubles x) {
  const Doubles zero{};
  Doubles abs_y = y < zero ? -y : y;
  Doubles abs_x = x < zero ? -x : x;
  const Doubles high = abs_y > abs_x ? abs_y : abs_x;
  const auto is_number = (abs_y + abs_x >= zero) & (high <= all(0x1.fffffffffffffp1023));
  const Doubles scale = high > all(0x1p1000) ? all(0x1p-100) : (high < all(0x1p-900) ? all(0x1p100) : all(1));
  abs_y *= scale;
  abs_x *= scale;
  const auto is_steep = abs_y > abs_x;
  const Doubles below = is_steep ? abs_x : abs_y;
  Doubles above = is_steep ? abs_y : abs_x;
  above = above > zero ? above : all(1);
  // The nearest eighth: cut off after adding a half.
  const Doubles share = below / above * all(8) + all(0.5);
  const Doubles round = all(0x1p52);
  const Doubles nearest = (share + round) - round;
  const Doubles eighths = nearest > share ? nearest - all(1) : nearest;
  const Doubles c = eighths * all(0.125);
  const Doubles u = (below - c * above) / (above + c * below);
  const Doubles z = u * u;
  Doubles p = all(1.0 / 13.0);
  p = p * z - all(1.0 / 11.0);
  p = p * z + all(1.0 / 9.0);
  p = p * z - all(1.0 / 7.0);
  p = p * z + all(1.0 / 5.0);
  p = p * z - all(1.0 / 3.0);
  Doubles base = zero;
  for (int i = 1; i < 9; ++i) base = eighths >= all(i) ? all(atan_of_eighths[i]) : base;
  const Doubles octant = base + (u + u * z * p);
  Doubles angle = is_steep ? all(half_pi_near) - (octant - all(half_pi_rest)) : octant;
  angle = x < zero ? all(2 * half_pi_near) - (angle - all(2 * half_pi_rest)) : angle;
  angle = y < zero ? -angle : angle;
  angle = high == zero ? zero : angle;
  return is_number ? angle : all(__builtin_nan(""));
}

/// joint_rows.h, relative_angle.
TICKTRUE_INLINE Wide relative_angle(const Wide& ac, const Wide& as, const Wide& bc, const Wide& bs, Wide turn_c,
                                    Wide turn_s) {
  const Wide c = ac * bc + as * bs;
  const Wide s = ac * bs - as * bc;
  const Wide qc = c * turn_c - s * turn_s;
  const Wide qs = s * turn_c + c * turn_s;
  Real angles[wide_count];
  for (int part = 0; part < angle_parts; ++part) {
    Doubles y{}, x{};
    for (int i = 0; i < double_count; ++i) {
      y[i] = static_cast<double>(qs[part * double_count + i]);
      x[i] = static_cast<double>(qc[part * double_count + i]);
    }
    const Doubles angle = arc_tangent(y, x);
    for (int i = 0; i < double_count; ++i) angles[part * double_count + i] = static_cast<Real>(angle[i]);
  }
  return load_wide(angles);
}

/// The angle's row, with the reaction of the pin that it draws along (joint_rows.h, PinnedAngleRow).
struct AngleRow {
  Wide mobility;
  Wide reaction_x, reaction_y;  // 1/m
  Mask works;
};

/// Everything of a joint while it is worked on.
struct Hinge {
  Pair pair;
  Arms arms;
  AngleRow row;
  Wide linear_x, linear_y;  // N s, accumulated

  TICKTRUE_INLINE Wide speed() const { return pair.b.at[2] - pair.a.at[2]; }
  TICKTRUE_INLINE void apply(Mask where, Wide impulse) {
    const Wide px = impulse * row.reaction_x;
    const Wide py = impulse * row.reaction_y;
    const auto set = [&](Wide& value, Wide changed) { value = where ? changed : value; };
    const Wide wa = pair.a.at[2] - pair.inv_inertia_a * impulse;
    const Wide wb = pair.b.at[2] + pair.inv_inertia_b * impulse;
    set(pair.a.at[0], pair.a.at[0] - pair.inv_mass_a * px);
    set(pair.a.at[1], pair.a.at[1] - pair.inv_mass_a * py);
    set(pair.a.at[2], wa - pair.inv_inertia_a * (arms.ax * py - arms.ay * px));
    set(pair.b.at[0], pair.b.at[0] + pair.inv_mass_b * px);
    set(pair.b.at[1], pair.b.at[1] + pair.inv_mass_b * py);
    set(pair.b.at[2], wb + pair.inv_inertia_b * (arms.bx * py - arms.by * px));
    set(linear_x, linear_x + px);
    set(linear_y, linear_y + py);
  }
};

TICKTRUE_INLINE Wide clamped(Wide value, Wide limit) {
  return larger(smaller(value, limit), -limit);
}

TICKTRUE_INLINE void solve_spring(const Group& group, HingeBatch& batch, Hinge& hinge, Wide angle) {
  constexpr Real no_limit = sizeof(Real) == 4 ? Real(0x1p127) : Real(0x1p1023);
  const Mask where = (group.load(batch.is_sprung) > Wide{}) & hinge.row.works;
  const Wide old = group.load(batch.spring_impulse);
  const Wide start = group.load(batch.start_speed);
  const Wide others = (hinge.speed() - hinge.row.mobility * old) - start;
  const Wide wanted =
      -(group.load(batch.loss) * start + group.load(batch.pull) * angle + group.load(batch.give) * others) /
      hinge.row.mobility;
  const Wide total = clamped(wanted, spread(no_limit));
  hinge.apply(where, total - old);
  group.store(batch.spring_impulse, where ? total : old);
}

TICKTRUE_INLINE void solve_motor(const Group& group, HingeBatch& batch, Hinge& hinge) {
  const Mask where = (group.load(batch.is_driven) > Wide{}) & hinge.row.works;
  const Wide old = group.load(batch.motor_impulse);
  const Wide total = clamped(old - (hinge.speed() - group.load(batch.motor_speed)) / hinge.row.mobility,
                             group.load(batch.motor_impulse_max));
  hinge.apply(where, total - old);
  group.store(batch.motor_impulse, where ? total : old);
}

/// joint_rows.h, solve_limit. `soft`: of this pass.
TICKTRUE_INLINE void solve_limit(const Group& group, HingeBatch& batch, Hinge& hinge, Wide room, Real sign, Wide h,
                                 const Softness& soft, Lanes& impulse) {
  const Wide zero{};
  const Wide one = spread(1);
  const Mask where = (group.load(batch.is_limited) > zero) & hinge.row.works;
  const Mask is_beyond = room < zero;
  const Wide target = is_beyond ? spread(soft.bias_rate) * room : room / h;
  const Wide mass_scale = is_beyond ? spread(soft.mass_scale) : one;
  const Wide impulse_scale = is_beyond ? spread(soft.impulse_scale) : zero;
  const Wide old = group.load(impulse);
  const Wide wanted = mass_scale * (spread(sign) * hinge.speed() + target) / hinge.row.mobility;
  const Wide total = larger((old - wanted) - impulse_scale * old, zero);
  hinge.apply(where, spread(sign) * (total - old));
  group.store(impulse, where ? total : old);
}

template <bool is_soft>
void solve(const HingeWork& work) {
  const Wide zero{};
  const Wide one = spread(1);
  const Wide h = spread(work.h);
  const Wide inv_h = spread(1 / work.h);
  const Softness soft = is_soft ? work.soft : Softness{};
  for (std::size_t i = 0; i < work.batch_count; ++i) {
    HingeBatch& batch = work.batches[i];
    for (int first = 0; first < batch.pin.count; first += wide_count) {
      const Group group{batch.pin, first};
      Hinge hinge;
      hinge.pair = load_pair(group, work.bodies);
      const Quads pose_a = gather_quads<body_record_length>(work.bodies + 4, batch.pin.read_a + first);
      const Quads pose_b = gather_quads<body_record_length>(work.bodies + 4, batch.pin.read_b + first);
      hinge.arms = arms_of(group, hinge.pair, pose_a, pose_b);
      const Pair& pair = hinge.pair;
      const Arms& arms = hinge.arms;
      const Wide m = pair.inv_mass_a + pair.inv_mass_b;
      const Wide ia = pair.inv_inertia_a;
      const Wide ib = pair.inv_inertia_b;
      const PinMobility k = mobility_of(pair, arms);
      const Wide inv_determinant = one / (k.determinant > zero ? k.determinant : one);
      const Wide length2_a = arms.ax * arms.ax + arms.ay * arms.ay;
      const Wide length2_b = arms.bx * arms.bx + arms.by * arms.by;
      const Wide apart_x = arms.ax - arms.bx;
      const Wide apart_y = arms.ay - arms.by;
      const Mask works = ~((m <= zero) | (ia + ib <= zero));
      const Wide some_m = works ? m : one;
      const Wide over = some_m * (ia + ib) + ia * ib * (apart_x * apart_x + apart_y * apart_y);
      const Wide under = some_m + (ia * length2_a + ib * length2_b) + ia * k.area * (ib * k.area / some_m);
      const Wide coupling_x = -(ia * arms.ay + ib * arms.by);
      const Wide coupling_y = ia * arms.ax + ib * arms.bx;
      hinge.row.mobility = works ? over / under : one;
      hinge.row.works = works & ~(hinge.row.mobility <= zero);
      hinge.row.mobility = hinge.row.works ? hinge.row.mobility : one;
      hinge.row.reaction_x = -(inv_determinant * (k.k22 * coupling_x - k.k12 * coupling_y));
      hinge.row.reaction_y = -(inv_determinant * (k.k11 * coupling_y - k.k12 * coupling_x));
      hinge.linear_x = group.load(batch.pin.impulse_x);
      hinge.linear_y = group.load(batch.pin.impulse_y);

      Wide angle = zero;
      if (batch.needs_angle != 0)
        angle = relative_angle(pose_a.at[2], pose_a.at[3], pose_b.at[2], pose_b.at[3], group.load(batch.turn_c),
                               group.load(batch.turn_s));
      if (is_soft) solve_spring(group, batch, hinge, angle);
      solve_motor(group, batch, hinge);
      solve_limit(group, batch, hinge, angle - group.load(batch.lower), 1, h, soft, batch.lower_impulse);
      solve_limit(group, batch, hinge, group.load(batch.upper) - angle, -1, h, soft, batch.upper_impulse);

      const Wide wa = hinge.pair.a.at[2];
      const Wide wb = hinge.pair.b.at[2];
      Wide vx = (hinge.pair.b.at[0] - wb * arms.by) - (hinge.pair.a.at[0] - wa * arms.ay);
      Wide vy = (hinge.pair.b.at[1] + wb * arms.bx) - (hinge.pair.a.at[1] + wa * arms.ax);
      Wide turning_x = zero, turning_y = zero;
      if constexpr (is_soft) {
        const Wide short_a = short_of(h * wa);
        const Wide short_b = short_of(h * wb);
        turning_x = inv_h * (short_a * arms.ax - short_b * arms.bx);
        turning_y = inv_h * (short_a * arms.ay - short_b * arms.by);
      }
      vx = (vx + turning_x) + spread(soft.bias_rate) * arms.ex;
      vy = (vy + turning_y) + spread(soft.bias_rate) * arms.ey;
      const Wide wanted_x = inv_determinant * (k.k22 * vx - k.k12 * vy);
      const Wide wanted_y = inv_determinant * (k.k11 * vy - k.k12 * vx);
      const Wide px = -(spread(soft.mass_scale) * wanted_x) - spread(soft.impulse_scale) * hinge.linear_x;
      const Wide py = -(spread(soft.mass_scale) * wanted_y) - spread(soft.impulse_scale) * hinge.linear_y;
      group.store(batch.pin.impulse_x, hinge.linear_x + px);
      group.store(batch.pin.impulse_y, hinge.linear_y + py);
      push(group, hinge.pair, arms, px, py, work.bodies);
    }
  }
}

void warm_start(const HingeWork& work) {
  for (std::size_t i = 0; i < work.batch_count; ++i) {
    HingeBatch& batch = work.batches[i];
    for (int first = 0; first < batch.pin.count; first += wide_count) {
      const Group group{batch.pin, first};
      Pair pair = load_pair(group, work.bodies);
      const Arms arms = load_arms(group, pair, work.bodies);
      const Wide impulse = (group.load(batch.spring_impulse) + group.load(batch.motor_impulse)) +
                           (group.load(batch.lower_impulse) - group.load(batch.upper_impulse));
      pair.a.at[2] -= pair.inv_inertia_a * impulse;
      pair.b.at[2] += pair.inv_inertia_b * impulse;
      push(group, pair, arms, group.load(batch.pin.impulse_x), group.load(batch.pin.impulse_y), work.bodies);
    }
  }
}

void note(const HingeWork& work) {
  for (std::size_t i = 0; i < work.batch_count; ++i) {
    HingeBatch& batch = work.batches[i];
    for (int first = 0; first < batch.pin.count; first += wide_count) {
      const Group group{batch.pin, first};
      const Pair pair = load_pair(group, work.bodies);
      group.store(batch.start_speed, pair.b.at[2] - pair.a.at[2]);
    }
  }
}

}  // namespace

HingeKernels hinge_kernels() {
  return {note, warm_start, solve<true>, solve<false>};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
