// The inner loops of the contact solver. A vector register holds one contact of a batch in each lane.
// SPDX-License-Identifier: MIT
// Source: Catto, "Iterative Dynamics with Temporal Coherence", GDC 2005 (accumulated impulses); Catto, "Solver2D", 2024
// (soft contacts with relax). Each lane does the same operations in the same order at every vector width.
//
// A contact is solved in the frame of its normal n and tangent t. With u the relative velocity of the centres of mass
// along n or t, w the angular velocities, r the anchors and m the sum of the inverse masses,
//   velocity of the point = u + w_b (r_b x n) - w_a (r_a x n),     an impulse P adds m P to u, i (r x n) P to w.
// The bodies' velocities get the sum of a contact's impulses once, at the end. Normals come first, then friction.
#include "engine/model/solver_kernels.h"
#include "engine/simd/realx2n.h"

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {
namespace {

/// The largest velocity that corrects an overlap, so that bodies created inside each other do not explode.
constexpr Real bias_speed_max = 3;  // m/s

constexpr bool has(unsigned features, unsigned feature) {
  return (features & feature) != 0;
}
constexpr int points_of(unsigned features) {
  return has(features, contact_feature::second_point) ? 2 : 1;
}

/// As many contacts of a batch as V has lanes, from lane `first` on.
template <typename V>
struct LaneRange {
  ContactBatch& batch;
  int first;

  TICKTRUE_INLINE V load(const ContactLanes& lanes) const { return SimdTraits<V>::load(lanes.at + first); }
  TICKTRUE_INLINE void store(ContactLanes& lanes, V value) const { SimdTraits<V>::store(lanes.at + first, value); }
  TICKTRUE_INLINE const std::uint32_t* write_a() const {
    return (has_sinks(batch) ? batch.write_a : batch.read_a) + first;
  }
  TICKTRUE_INLINE const std::uint32_t* write_b() const {
    return (has_sinks(batch) ? batch.write_b : batch.read_b) + first;
  }
};

/// Runs `solve_lanes` over the contacts of all batches. Batches with enough contacts use Widest; serial batches take
/// one contact at a time.
template <typename Widest, typename Solve>
TICKTRUE_INLINE void for_lane_ranges(const ContactWork& work, Solve solve_lanes) {
  for (std::size_t i = 0; i < work.batch_count; ++i) {
    ContactBatch& batch = work.batches[i];
    if (batch.is_serial != 0) {
      for (int lane = 0; lane < batch.count; ++lane) solve_lanes(LaneRange<Real>{batch, lane}, i);
      continue;
    }
    for (int first = 0; first < batch.count; first += SimdTraits<Widest>::count)
      if (first + simd_width < batch.count)
        solve_lanes(LaneRange<Widest>{batch, first}, i);
      else
        solve_lanes(LaneRange<RealxN>{batch, first}, i);
  }
}

/// A word of eight bytes, in Reals: the unit in which batches name records (contact_lanes.h).
constexpr int word_length = 8 / static_cast<int>(sizeof(Real));

/// Velocities of the two bodies, and constants of the contact.
template <typename V>
struct Pair {
  Columns4<V> a, b;  // x, y, angular, unused
  V nx, ny;
  V inv_mass_a, inv_mass_b, inv_inertia_a, inv_inertia_b;
};

template <typename V>
TICKTRUE_INLINE Pair<V> load_pair(const LaneRange<V>& lanes, const Real* bodies) {
  return {gather4<V, word_length>(bodies, lanes.batch.read_a + lanes.first),
          gather4<V, word_length>(bodies, lanes.batch.read_b + lanes.first),
          lanes.load(lanes.batch.normal_x),
          lanes.load(lanes.batch.normal_y),
          lanes.load(lanes.batch.inv_mass_a),
          lanes.load(lanes.batch.inv_mass_b),
          lanes.load(lanes.batch.inv_inertia_a),
          lanes.load(lanes.batch.inv_inertia_b)};
}

/// Adds the contact's impulses to the linear velocities.
template <typename V>
TICKTRUE_INLINE void add_impulses(Pair<V>& pair, V normal_impulse, V tangent_impulse) {
  const V px = normal_impulse * pair.nx + tangent_impulse * pair.ny;
  const V py = normal_impulse * pair.ny - tangent_impulse * pair.nx;
  pair.a.at[0] -= pair.inv_mass_a * px;
  pair.a.at[1] -= pair.inv_mass_a * py;
  pair.b.at[0] += pair.inv_mass_b * px;
  pair.b.at[1] += pair.inv_mass_b * py;
}

/// Writes the velocities back.
template <typename V>
TICKTRUE_INLINE void store_pair(const LaneRange<V>& lanes, Pair<V>& pair, Real* bodies) {
  pair.a.at[3] = pair.b.at[3] = V{};  // it is 0; as a constant it needs no register
  scatter4<V, word_length>(bodies, lanes.write_a(), pair.a);
  scatter4<V, word_length>(bodies, lanes.write_b(), pair.b);
}

/// The relative motion of the bodies since the tick began, in the contact's frame.
template <typename V>
struct RelativeMotion {
  V normal_displacement;               // of B against A, m
  V cosine_less_1_a, cosine_less_1_b;  // cosine of the rotation - 1
  V sine_a, sine_b;                    // sine of the rotation
  V radius_a, radius_b;                // m; a pivot is a radius behind its anchor: the surface of a rolling disc stays
};

template <unsigned features, typename V>
TICKTRUE_INLINE RelativeMotion<V> load_relative_motion(const LaneRange<V>& lanes, const Pair<V>& pair,
                                                       const Real* bodies) {
  const Columns4<V> a = gather4<V, word_length>(bodies + 4, lanes.batch.read_a + lanes.first);
  const Columns4<V> b = gather4<V, word_length>(bodies + 4, lanes.batch.read_b + lanes.first);
  const V one = SimdTraits<V>::broadcast(1);
  RelativeMotion<V> motion{(b.at[0] - a.at[0]) * pair.nx + (b.at[1] - a.at[1]) * pair.ny,
                           a.at[2] - one,
                           b.at[2] - one,
                           a.at[3],
                           b.at[3],
                           {},
                           {}};
  if constexpr (has(features, contact_feature::radius)) {
    motion.radius_a = lanes.load(lanes.batch.radius_a);
    motion.radius_b = lanes.load(lanes.batch.radius_b);
  }
  return motion;
}

/// The present separation of a point. The normal is constant; the pivots rotate with the bodies.
template <unsigned features, typename V>
TICKTRUE_INLINE V separation_of(const LaneRange<V>& lanes, const ContactPointLanes& point,
                                const RelativeMotion<V>& motion, V arm_a, V arm_b) {
  V back_a = lanes.load(point.tangent_arm_a);  // of the pivots, against the normal
  V back_b = lanes.load(point.tangent_arm_b);
  if constexpr (has(features, contact_feature::radius)) {
    back_a = back_a + motion.radius_a;
    back_b = back_b - motion.radius_b;
  }
  const V by_sine = motion.sine_b * arm_b - motion.sine_a * arm_a;
  const V by_cosine = motion.cosine_less_1_a * back_a - motion.cosine_less_1_b * back_b;
  return lanes.load(point.separation) + (motion.normal_displacement + (by_cosine + by_sine));
}

template <typename V>
struct Target {
  V rate;  // m/s
  V mass_scale, impulse_scale;
};

/// The target velocity of a rigid contact: a gap may close within the substep, and an overlap is not corrected.
template <typename V>
TICKTRUE_INLINE V gap_rate(V separation, V inv_h) {
  const V zero{};
  return select(separation > zero, separation * inv_h, zero);
}

/// The target velocity of a soft contact: a gap may close within the substep, and an overlap is corrected softly.
template <typename V>
TICKTRUE_INLINE Target<V> target_of(V separation, V inv_h, const Softness& soft) {
  const auto broadcast = SimdTraits<V>::broadcast;
  const V zero{};
  const auto is_separated = separation > zero;
  const V bias = larger(broadcast(soft.bias_rate) * separation, broadcast(-bias_speed_max));
  return {select(is_separated, separation * inv_h, bias),
          select(is_separated, broadcast(1), broadcast(soft.mass_scale)),
          select(is_separated, zero, broadcast(soft.impulse_scale))};
}

/// solve: no pose has changed since `fill` or the last relax pass.
enum class Pass { solve, relax };

template <unsigned features, Pass pass, typename V>
TICKTRUE_INLINE void solve_lanes(const ContactWork& work, std::size_t i, const LaneRange<V>& lanes, Real inv_h) {
  ContactBatch& batch = lanes.batch;
  const V zero{};
  const Softness& soft = batch.immovable != 0 ? work.immovable : work.moving;
  Pair<V> pair = load_pair(lanes, work.bodies);
  RelativeMotion<V> motion;
  if constexpr (pass == Pass::relax) motion = load_relative_motion<features>(lanes, pair, work.bodies);
  const V inv_mass = pair.inv_mass_a + pair.inv_mass_b;
  const V dx = pair.b.at[0] - pair.a.at[0];
  const V dy = pair.b.at[1] - pair.a.at[1];
  V& wa = pair.a.at[2];
  V& wb = pair.b.at[2];
  if constexpr (has(features, contact_feature::surface)) {
    // A torque against the relative rotation, at most rolling resistance times normal force. Before the points: each
    // of them then sees what the torque does to it.
    SurfaceLanes& surface = work.surfaces[i];
    const V normal_impulse = lanes.load(batch.points[0].normal_impulse) + lanes.load(batch.points[1].normal_impulse);
    const V limit = lanes.load(surface.rolling_resistance) * normal_impulse;
    const V old_impulse = lanes.load(surface.rolling_impulse);
    const V wanted = old_impulse - lanes.load(surface.rolling_mass) * (wb - wa);
    const V impulse = larger(zero - limit, smaller(limit, wanted));
    lanes.store(surface.rolling_impulse, impulse);
    const V change = impulse - old_impulse;
    wa -= pair.inv_inertia_a * change;
    wb += pair.inv_inertia_b * change;
  }
  V normal_velocity = dx * pair.nx + dy * pair.ny;
  V normal_sum = zero;
  for (int p = 0; p < points_of(features); ++p) {
    ContactPointLanes& point = batch.points[p];
    const V arm_a = lanes.load(point.normal_arm_a);
    const V arm_b = lanes.load(point.normal_arm_b);
    V separation;
    if constexpr (pass == Pass::solve) {
      separation = lanes.load(point.present_separation);
    } else {
      separation = separation_of<features>(lanes, point, motion, arm_a, arm_b);
      lanes.store(point.present_separation, separation);
    }
    const V old_impulse = lanes.load(point.normal_impulse);
    V mass = lanes.load(point.normal_mass);
    V base = old_impulse;
    if constexpr (pass == Pass::relax) {
      base -= mass * gap_rate(separation, SimdTraits<V>::broadcast(inv_h));
    } else {
      const Target<V> target = target_of(separation, SimdTraits<V>::broadcast(inv_h), soft);
      mass = mass * target.mass_scale;
      base = (old_impulse - target.impulse_scale * old_impulse) - mass * target.rate;
    }
    const V velocity = normal_velocity + (wb * arm_b - wa * arm_a);
    const V impulse = larger(base - mass * velocity, zero);
    lanes.store(point.normal_impulse, impulse);
    if constexpr (has(features, contact_feature::bounce)) {
      ContactLanes& most = work.bounces[i].impulse_max[p];
      lanes.store(most, larger(lanes.load(most), impulse));
    }
    const V change = impulse - old_impulse;
    normal_velocity += inv_mass * change;
    wa -= (pair.inv_inertia_a * arm_a) * change;
    wb += (pair.inv_inertia_b * arm_b) * change;
    normal_sum += change;
  }
  V tangent_sum = zero;
  if constexpr (has(features, contact_feature::friction)) {
    V tangent_velocity = dx * pair.ny - dy * pair.nx;
    if constexpr (has(features, contact_feature::surface))
      tangent_velocity += lanes.load(work.surfaces[i].tangent_speed);
    const V friction = lanes.load(batch.friction);
    for (int p = 0; p < points_of(features); ++p) {
      ContactPointLanes& point = batch.points[p];
      const V arm_a = lanes.load(point.tangent_arm_a);
      const V arm_b = lanes.load(point.tangent_arm_b);
      const V old_impulse = lanes.load(point.tangent_impulse);
      const V limit = friction * lanes.load(point.normal_impulse);
      const V velocity = tangent_velocity + (wb * arm_b - wa * arm_a);
      const V wanted = old_impulse - lanes.load(point.tangent_mass) * velocity;
      const V impulse = larger(zero - limit, smaller(limit, wanted));
      lanes.store(point.tangent_impulse, impulse);
      const V change = impulse - old_impulse;
      tangent_velocity += inv_mass * change;
      wa -= (pair.inv_inertia_a * arm_a) * change;
      wb += (pair.inv_inertia_b * arm_b) * change;
      tangent_sum += change;
    }
  }
  add_impulses(pair, normal_sum, tangent_sum);
  store_pair(lanes, pair, work.bodies);
}

template <unsigned features, Pass pass>
void solve(const ContactWork& work) {
  const Real inv_h = 1 / work.h;
  for_lane_ranges<Realx2N>(
      work, [&](const auto& lanes, std::size_t i)
                __attribute__((always_inline)) { solve_lanes<features, pass>(work, i, lanes, inv_h); });
}

template <unsigned features, typename V>
TICKTRUE_INLINE void warm_start_lanes(const ContactWork& work, const LaneRange<V>& lanes) {
  ContactBatch& batch = lanes.batch;
  Pair<V> pair = load_pair(lanes, work.bodies);
  V normal_sum{}, tangent_sum{}, moment_a{}, moment_b{};
  for (int p = 0; p < points_of(features); ++p) {
    const ContactPointLanes& point = batch.points[p];
    const V impulse = lanes.load(point.normal_impulse);
    normal_sum += impulse;
    moment_a += lanes.load(point.normal_arm_a) * impulse;
    moment_b += lanes.load(point.normal_arm_b) * impulse;
    if constexpr (has(features, contact_feature::friction)) {
      const V tangent_impulse = lanes.load(point.tangent_impulse);
      tangent_sum += tangent_impulse;
      moment_a += lanes.load(point.tangent_arm_a) * tangent_impulse;
      moment_b += lanes.load(point.tangent_arm_b) * tangent_impulse;
    }
  }
  pair.a.at[2] -= pair.inv_inertia_a * moment_a;
  pair.b.at[2] += pair.inv_inertia_b * moment_b;
  add_impulses(pair, normal_sum, tangent_sum);
  store_pair(lanes, pair, work.bodies);
}

template <unsigned features>
void warm_start(const ContactWork& work) {
  if constexpr (has(features, contact_feature::surface))
    for (std::size_t i = 0; i < work.batch_count; ++i) work.surfaces[i].rolling_impulse = {};
  for_lane_ranges<Realx2N>(
      work, [&](const auto& lanes, std::size_t)
                __attribute__((always_inline)) { warm_start_lanes<features>(work, lanes); });
}

template <typename V>
TICKTRUE_INLINE V inverse_or_zero(V k) {
  const V zero{};
  const V one = SimdTraits<V>::broadcast(1);
  const auto exists = k > zero;
  return select(exists, one / select(exists, k, one), zero);
}

template <unsigned features, typename V>
TICKTRUE_INLINE void prepare_lanes(const ContactWork& work, const FoundPoints* found, std::size_t i,
                                   const LaneRange<V>& lanes) {
  ContactBatch& batch = lanes.batch;
  const V h = SimdTraits<V>::broadcast(work.h);
  const Pair<V> pair = load_pair(lanes, work.bodies);
  const V inv_mass = pair.inv_mass_a + pair.inv_mass_b;
  const V normal_velocity = (pair.b.at[0] - pair.a.at[0]) * pair.nx + (pair.b.at[1] - pair.a.at[1]) * pair.ny;
  for (int p = 0; p < points_of(features); ++p) {
    ContactPointLanes& point = batch.points[p];
    const FoundPointLanes& from = found[i].points[p];
    const V ax = lanes.load(from.anchor_a_x), ay = lanes.load(from.anchor_a_y);
    const V bx = lanes.load(from.anchor_b_x), by = lanes.load(from.anchor_b_y);
    const auto effective_mass = [&](V arm_a, V arm_b) {
      return inverse_or_zero((inv_mass + pair.inv_inertia_a * arm_a * arm_a) + pair.inv_inertia_b * arm_b * arm_b);
    };
    const V arm_a = ax * pair.ny - ay * pair.nx;
    const V arm_b = bx * pair.ny - by * pair.nx;
    const V tangent_a = -(ax * pair.nx + ay * pair.ny);
    const V tangent_b = -(bx * pair.nx + by * pair.ny);
    const V exists = lanes.load(from.exists);
    lanes.store(point.normal_arm_a, arm_a);
    lanes.store(point.normal_arm_b, arm_b);
    lanes.store(point.tangent_arm_a, tangent_a);
    lanes.store(point.tangent_arm_b, tangent_b);
    lanes.store(point.normal_mass, exists * effective_mass(arm_a, arm_b));
    lanes.store(point.normal_impulse, h * lanes.load(from.normal_force));
    if constexpr (has(features, contact_feature::friction)) {
      lanes.store(point.tangent_mass, exists * effective_mass(tangent_a, tangent_b));
      lanes.store(point.tangent_impulse, h * lanes.load(from.tangent_force));
    } else {
      lanes.store(point.tangent_mass, V{});
      lanes.store(point.tangent_impulse, V{});
    }
    if constexpr (has(features, contact_feature::bounce)) {
      const V approach = normal_velocity + (pair.b.at[2] * arm_b - pair.a.at[2] * arm_a);
      lanes.store(work.bounces[i].approach[p], approach);
    }
  }
  for (int p = points_of(features); p < 2; ++p) {
    ContactPointLanes& point = batch.points[p];
    lanes.store(point.normal_mass, V{});
    lanes.store(point.normal_impulse, V{});
    lanes.store(point.tangent_impulse, V{});
  }
}

template <unsigned features>
void prepare(const ContactWork& work, const FoundPoints* found) {
  for_lane_ranges<Realx2N>(
      work, [&](const auto& lanes, std::size_t i)
                __attribute__((always_inline)) { prepare_lanes<features>(work, found, i, lanes); });
}

// Conditions of one lane, and of the lanes of a RealxN.
bool any_of(bool lane) {
  return lane;
}
bool any_of(MaskxN lanes) {
  bool any = false;
  for (int lane = 0; lane < simd_width; ++lane) any |= lanes[lane] != 0;
  return any;
}
bool both(bool a, bool b) {
  return a && b;
}
MaskxN both(MaskxN a, MaskxN b) {
  return a & b;
}
bool either(bool a, bool b) {
  return a || b;
}
MaskxN either(MaskxN a, MaskxN b) {
  return a | b;
}

template <unsigned features, typename V>
TICKTRUE_INLINE bool bounce_lanes(const ContactWork& work, std::size_t i, const LaneRange<V>& lanes, Real threshold) {
  ContactBatch& batch = lanes.batch;
  BounceLanes& bounces = work.bounces[i];
  const V zero{};
  Pair<V> pair = load_pair(lanes, work.bodies);
  const V inv_mass = pair.inv_mass_a + pair.inv_mass_b;
  const V restitution = lanes.load(bounces.restitution);
  V normal_velocity = (pair.b.at[0] - pair.a.at[0]) * pair.nx + (pair.b.at[1] - pair.a.at[1]) * pair.ny;
  V normal_sum = zero;
  auto bounced = zero > zero;
  for (int p = 0; p < points_of(features); ++p) {
    // Newton's law of restitution: v_n after = -e v_n before, for points that approached and had an impulse.
    ContactPointLanes& point = batch.points[p];
    const V approach = lanes.load(bounces.approach[p]);
    const auto hits = both(both(restitution > zero, SimdTraits<V>::broadcast(-threshold) >= approach),
                           lanes.load(bounces.impulse_max[p]) > zero);
    if (!any_of(hits)) continue;
    bounced = either(bounced, hits);
    const V arm_a = lanes.load(point.normal_arm_a);
    const V arm_b = lanes.load(point.normal_arm_b);
    const V velocity = normal_velocity + (pair.b.at[2] * arm_b - pair.a.at[2] * arm_a);
    const V old_impulse = lanes.load(point.normal_impulse);
    const V wanted = old_impulse - lanes.load(point.normal_mass) * (velocity + restitution * approach);
    const V impulse = select(hits, larger(wanted, zero), old_impulse);
    lanes.store(point.normal_impulse, impulse);
    if constexpr (has(features, contact_feature::friction)) {  // the next tick starts within the cone
      const V limit = lanes.load(batch.friction) * impulse;
      lanes.store(point.tangent_impulse, larger(zero - limit, smaller(limit, lanes.load(point.tangent_impulse))));
    }
    const V change = impulse - old_impulse;
    normal_velocity += inv_mass * change;
    pair.a.at[2] -= (pair.inv_inertia_a * arm_a) * change;
    pair.b.at[2] += (pair.inv_inertia_b * arm_b) * change;
    normal_sum += change;
  }
  if (!any_of(bounced)) return false;
  // In lanes without a bounce, velocities keep the signs of their zeros.
  const Pair<V> before = load_pair(lanes, work.bodies);
  add_impulses(pair, normal_sum, zero);
  for (int axis = 0; axis < 3; ++axis) {
    pair.a.at[axis] = select(bounced, pair.a.at[axis], before.a.at[axis]);
    pair.b.at[axis] = select(bounced, pair.b.at[axis], before.b.at[axis]);
  }
  store_pair(lanes, pair, work.bodies);
  return true;
}

template <unsigned features>
bool bounce(const ContactWork& work, Real threshold) {
  bool any = false;
  if constexpr (has(features, contact_feature::bounce))
    for_lane_ranges<RealxN>(
        work, [&](const auto& lanes, std::size_t i) __attribute__((always_inline)) {
          if (lanes.batch.bounces != 0) any |= bounce_lanes<features>(work, i, lanes, threshold);
        });
  return any;
}

/// The features of the compiled kernel. Every kernel has a second point or a radius; a kernel with surfaces has all
/// features.
constexpr unsigned compiled(unsigned features) {
  if (has(features, contact_feature::surface)) return contact_feature::all;
  return has(features, contact_feature::second_point) ? features : features | contact_feature::radius;
}

template <unsigned features>
constexpr ContactKernels kernels_with{prepare<compiled(features)>, warm_start<compiled(features)>,
                                      solve<compiled(features), Pass::solve>, solve<compiled(features), Pass::relax>,
                                      bounce<compiled(features)>};

constexpr ContactKernels table[] = {kernels_with<0>,  kernels_with<1>,  kernels_with<2>,  kernels_with<3>,
                                    kernels_with<4>,  kernels_with<5>,  kernels_with<6>,  kernels_with<7>,
                                    kernels_with<8>,  kernels_with<9>,  kernels_with<10>, kernels_with<11>,
                                    kernels_with<12>, kernels_with<13>, kernels_with<14>, kernels_with<15>};

}  // namespace

ContactKernels contact_kernels(unsigned features) {
  if (has(features, contact_feature::surface)) return kernels_with<contact_feature::all>;
  return table[features];
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
