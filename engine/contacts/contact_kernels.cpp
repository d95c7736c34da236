// The inner loops of the contact solver: contacts of a batch side by side, as many as a vector register holds.
// SPDX-License-Identifier: MIT
// Source: Catto, "Iterative Dynamics with Temporal Coherence", GDC 2005 (accumulated impulses); Catto, "Solver2D", 2024
// (soft contacts with relax). Each lane does the same operations in the same order at every vector width.
//
// A contact is solved in the frame of its normal n and tangent t: with u the relative velocity of the centres of mass
// along n or t, w the angular velocities, r the anchors and m the sum of the inverse masses,
//   velocity of the point = u + w_b (r_b x n) - w_a (r_a x n),     an impulse P adds m P to u, i (r x n) P to w.
// The bodies' velocities get the sum of a contact's impulses once, at its end. Normals first, then friction.
#include "engine/contacts/solver_kernels.h"
#include "engine/simd/twin.h"

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {
namespace {

/// Overlap is pushed out at most this fast, so that bodies created inside each other do not explode.
constexpr Real push_speed_max = 3;  // m/s

constexpr bool has(unsigned features, unsigned feature) {
  return (features & feature) != 0;
}
constexpr int points_of(unsigned features) {
  return has(features, contact_feature::second_point) ? 2 : 1;
}

/// So many contacts of a batch as V has lanes, starting at lane `first`.
template <typename V>
struct Group {
  ContactBatch& batch;
  int first;

  TICKTRUE_INLINE V load(const ContactLanes& lanes) const { return VectorOf<V>::load(lanes.at + first); }
  TICKTRUE_INLINE void store(ContactLanes& lanes, V value) const { VectorOf<V>::store(lanes.at + first, value); }
  TICKTRUE_INLINE const std::uint32_t* write_a() const {
    return (writes_elsewhere(batch) ? batch.write_a : batch.read_a) + first;
  }
  TICKTRUE_INLINE const std::uint32_t* write_b() const {
    return (writes_elsewhere(batch) ? batch.write_b : batch.read_b) + first;
  }
};

/// Runs `solve_group` over the contacts of all batches: as many as `Widest` has lanes at a time where there are so
/// many, and one by itself where they are to be solved in turn.
template <typename Widest, typename Solve>
TICKTRUE_INLINE void for_groups(const ContactWork& work, Solve solve_group) {
  for (std::size_t i = 0; i < work.batch_count; ++i) {
    ContactBatch& batch = work.batches[i];
    if (batch.in_turn != 0) {
      for (int lane = 0; lane < batch.count; ++lane) solve_group(Group<Real>{batch, lane}, i);
      continue;
    }
    for (int first = 0; first < batch.count; first += VectorOf<Widest>::count)
      if (first + wide_count < batch.count)
        solve_group(Group<Widest>{batch, first}, i);
      else
        solve_group(Group<Wide>{batch, first}, i);
  }
}

/// The bodies' numbers from one to the next of those that batches name.
constexpr int word_length = 8 / static_cast<int>(sizeof(Real));

/// Velocities of the two bodies, and what constants of a contact they meet.
template <typename V>
struct Pair {
  QuadsOf<V> a, b;  // x, y, angular, unused
  V nx, ny;
  V inv_mass_a, inv_mass_b, inv_inertia_a, inv_inertia_b;
};

template <typename V>
TICKTRUE_INLINE Pair<V> load_pair(const Group<V>& group, const Real* bodies) {
  return {gather_quads_of<V, word_length>(bodies, group.batch.read_a + group.first),
          gather_quads_of<V, word_length>(bodies, group.batch.read_b + group.first),
          group.load(group.batch.normal_x),
          group.load(group.batch.normal_y),
          group.load(group.batch.inv_mass_a),
          group.load(group.batch.inv_mass_b),
          group.load(group.batch.inv_inertia_a),
          group.load(group.batch.inv_inertia_b)};
}

/// Adds the contact's impulses to the velocities, but for the turn.
template <typename V>
TICKTRUE_INLINE void add_impulses(Pair<V>& pair, V along_normal, V along_tangent) {
  const V px = along_normal * pair.nx + along_tangent * pair.ny;
  const V py = along_normal * pair.ny - along_tangent * pair.nx;
  pair.a.at[0] -= pair.inv_mass_a * px;
  pair.a.at[1] -= pair.inv_mass_a * py;
  pair.b.at[0] += pair.inv_mass_b * px;
  pair.b.at[1] += pair.inv_mass_b * py;
}

/// Puts the velocities back.
template <typename V>
TICKTRUE_INLINE void store_pair(const Group<V>& group, Pair<V>& pair, Real* bodies) {
  pair.a.at[3] = pair.b.at[3] = V{};  // what it is, and no register has to hold
  scatter_quads_of<V, word_length>(bodies, group.write_a(), pair.a);
  scatter_quads_of<V, word_length>(bodies, group.write_b(), pair.b);
}

/// What the bodies have moved since the tick began, in the contact's frame.
template <typename V>
struct Slide {
  V along;               // of B against A, m
  V lost_a, lost_b;      // cosine of the turn, less 1
  V turned_a, turned_b;  // its sine
  V radius_a, radius_b;  // m; the pivots are a radius behind the anchors: the surface of a rolling disc stays
};

template <unsigned features, typename V>
TICKTRUE_INLINE Slide<V> load_slide(const Group<V>& group, const Pair<V>& pair, const Real* bodies) {
  const QuadsOf<V> a = gather_quads_of<V, word_length>(bodies + 4, group.batch.read_a + group.first);
  const QuadsOf<V> b = gather_quads_of<V, word_length>(bodies + 4, group.batch.read_b + group.first);
  const V one = VectorOf<V>::spread(1);
  Slide<V> slide{(b.at[0] - a.at[0]) * pair.nx + (b.at[1] - a.at[1]) * pair.ny,
                 a.at[2] - one,
                 b.at[2] - one,
                 a.at[3],
                 b.at[3],
                 {},
                 {}};
  if constexpr (has(features, contact_feature::radius)) {
    slide.radius_a = group.load(group.batch.radius_a);
    slide.radius_b = group.load(group.batch.radius_b);
  }
  return slide;
}

/// Present separation of a point: the normal stays, the pivots turn with the bodies.
template <unsigned features, typename V>
TICKTRUE_INLINE V separation_of(const Group<V>& group, const ContactPointLanes& point, const Slide<V>& slide, V arm_a,
                                V arm_b) {
  V back_a = group.load(point.tangent_arm_a);  // of the pivots, against the normal
  V back_b = group.load(point.tangent_arm_b);
  if constexpr (has(features, contact_feature::radius)) {
    back_a = back_a + slide.radius_a;
    back_b = back_b - slide.radius_b;
  }
  const V turned = slide.turned_b * arm_b - slide.turned_a * arm_a;
  const V lost = slide.lost_a * back_a - slide.lost_b * back_b;
  return group.load(point.separation) + (slide.along + (lost + turned));
}

template <typename V>
struct Target {
  V rate;  // m/s
  V mass_scale, impulse_scale;
};

/// Apart: may close the gap within the substep, no more. Overlapping: is not pushed.
template <typename V>
TICKTRUE_INLINE V gap_rate(V separation, V inv_h) {
  const V zero{};
  return choose(separation > zero, separation * inv_h, zero);
}

/// Apart: as above. Overlapping: pushed out softly.
template <typename V>
TICKTRUE_INLINE Target<V> target_of(V separation, V inv_h, const Softness& soft) {
  const auto spread = VectorOf<V>::spread;
  const V zero{};
  const auto apart = separation > zero;
  const V push = larger(spread(soft.bias_rate) * separation, spread(-push_speed_max));
  return {choose(apart, separation * inv_h, push), choose(apart, spread(1), spread(soft.mass_scale)),
          choose(apart, zero, spread(soft.impulse_scale))};
}

/// solve_again: no pose has changed since the last pass.
enum class Pass { solve, solve_again, relax };

template <unsigned features, Pass pass, typename V>
TICKTRUE_INLINE void solve_group(const ContactWork& work, std::size_t i, const Group<V>& group, Real inv_h) {
  ContactBatch& batch = group.batch;
  const V zero{};
  const Softness& soft = batch.immovable != 0 ? work.immovable : work.moving;
  Pair<V> pair = load_pair(group, work.bodies);
  Slide<V> slide;
  if constexpr (pass != Pass::solve_again) slide = load_slide<features>(group, pair, work.bodies);
  const V inv_mass = pair.inv_mass_a + pair.inv_mass_b;
  const V dx = pair.b.at[0] - pair.a.at[0];
  const V dy = pair.b.at[1] - pair.a.at[1];
  V& wa = pair.a.at[2];
  V& wb = pair.b.at[2];
  V speed = dx * pair.nx + dy * pair.ny;
  V pushed = zero;
  for (int p = 0; p < points_of(features); ++p) {
    ContactPointLanes& point = batch.points[p];
    const V arm_a = group.load(point.normal_arm_a);
    const V arm_b = group.load(point.normal_arm_b);
    V separation;
    if constexpr (pass == Pass::solve_again) {
      separation = group.load(point.present_separation);
    } else {
      separation = separation_of<features>(group, point, slide, arm_a, arm_b);
      group.store(point.present_separation, separation);
    }
    const V old_impulse = group.load(point.normal_impulse);
    V mass = group.load(point.normal_mass);
    V kept = old_impulse;
    if constexpr (pass == Pass::relax) {
      kept -= mass * gap_rate(separation, VectorOf<V>::spread(inv_h));
    } else {
      const Target<V> target = target_of(separation, VectorOf<V>::spread(inv_h), soft);
      mass = mass * target.mass_scale;
      kept = (old_impulse - target.impulse_scale * old_impulse) - mass * target.rate;
    }
    const V velocity = speed + (wb * arm_b - wa * arm_a);
    const V impulse = larger(kept - mass * velocity, zero);
    group.store(point.normal_impulse, impulse);
    if constexpr (has(features, contact_feature::bounce)) {
      ContactLanes& most = work.bounces[i].impulse_max[p];
      group.store(most, larger(group.load(most), impulse));
    }
    const V change = impulse - old_impulse;
    speed += inv_mass * change;
    wa -= (pair.inv_inertia_a * arm_a) * change;
    wb += (pair.inv_inertia_b * arm_b) * change;
    pushed += change;
  }
  V rubbed = zero;
  if constexpr (has(features, contact_feature::friction)) {
    V slip = dx * pair.ny - dy * pair.nx;
    if constexpr (has(features, contact_feature::surface)) slip += group.load(work.surfaces[i].tangent_speed);
    const V friction = group.load(batch.friction);
    for (int p = 0; p < points_of(features); ++p) {
      ContactPointLanes& point = batch.points[p];
      const V arm_a = group.load(point.tangent_arm_a);
      const V arm_b = group.load(point.tangent_arm_b);
      const V old_impulse = group.load(point.tangent_impulse);
      const V limit = friction * group.load(point.normal_impulse);
      const V velocity = slip + (wb * arm_b - wa * arm_a);
      const V wanted = old_impulse - group.load(point.tangent_mass) * velocity;
      const V impulse = larger(zero - limit, smaller(limit, wanted));
      group.store(point.tangent_impulse, impulse);
      const V change = impulse - old_impulse;
      slip += inv_mass * change;
      wa -= (pair.inv_inertia_a * arm_a) * change;
      wb += (pair.inv_inertia_b * arm_b) * change;
      rubbed += change;
    }
  }
  if constexpr (has(features, contact_feature::surface)) {
    // A torque against the relative turn, at most rolling resistance times normal force.
    SurfaceLanes& surface = work.surfaces[i];
    const V pressed = group.load(batch.points[0].normal_impulse) + group.load(batch.points[1].normal_impulse);
    const V limit = group.load(surface.rolling_resistance) * pressed;
    const V old_impulse = group.load(surface.rolling_impulse);
    const V wanted = old_impulse - group.load(surface.rolling_mass) * (wb - wa);
    const V impulse = larger(zero - limit, smaller(limit, wanted));
    group.store(surface.rolling_impulse, impulse);
    const V change = impulse - old_impulse;
    wa -= pair.inv_inertia_a * change;
    wb += pair.inv_inertia_b * change;
  }
  add_impulses(pair, pushed, rubbed);
  store_pair(group, pair, work.bodies);
}

template <unsigned features, Pass pass>
void solve(const ContactWork& work) {
  const Real inv_h = 1 / work.h;
  for_groups<Twin>(
      work, [&](const auto& group, std::size_t i)
                __attribute__((always_inline)) { solve_group<features, pass>(work, i, group, inv_h); });
}

template <unsigned features, typename V>
TICKTRUE_INLINE void warm_start_group(const ContactWork& work, const Group<V>& group) {
  ContactBatch& batch = group.batch;
  Pair<V> pair = load_pair(group, work.bodies);
  V pushed{}, rubbed{}, turn_a{}, turn_b{};
  for (int p = 0; p < points_of(features); ++p) {
    const ContactPointLanes& point = batch.points[p];
    const V impulse = group.load(point.normal_impulse);
    pushed += impulse;
    turn_a += group.load(point.normal_arm_a) * impulse;
    turn_b += group.load(point.normal_arm_b) * impulse;
    if constexpr (has(features, contact_feature::friction)) {
      const V rub = group.load(point.tangent_impulse);
      rubbed += rub;
      turn_a += group.load(point.tangent_arm_a) * rub;
      turn_b += group.load(point.tangent_arm_b) * rub;
    }
  }
  pair.a.at[2] -= pair.inv_inertia_a * turn_a;
  pair.b.at[2] += pair.inv_inertia_b * turn_b;
  add_impulses(pair, pushed, rubbed);
  store_pair(group, pair, work.bodies);
}

template <unsigned features>
void warm_start(const ContactWork& work) {
  if constexpr (has(features, contact_feature::surface))
    for (std::size_t i = 0; i < work.batch_count; ++i) work.surfaces[i].rolling_impulse = {};
  for_groups<Twin>(
      work, [&](const auto& group, std::size_t)
                __attribute__((always_inline)) { warm_start_group<features>(work, group); });
}

template <typename V>
TICKTRUE_INLINE V inverse_or_zero(V k) {
  const V zero{};
  const V one = VectorOf<V>::spread(1);
  const auto exists = k > zero;
  return choose(exists, one / choose(exists, k, one), zero);
}

template <unsigned features, typename V>
TICKTRUE_INLINE void prepare_group(const ContactWork& work, std::size_t i, const Group<V>& group) {
  ContactBatch& batch = group.batch;
  const V h = VectorOf<V>::spread(work.h);
  const Pair<V> pair = load_pair(group, work.bodies);
  const V inv_mass = pair.inv_mass_a + pair.inv_mass_b;
  const V speed = (pair.b.at[0] - pair.a.at[0]) * pair.nx + (pair.b.at[1] - pair.a.at[1]) * pair.ny;
  for (int p = 0; p < points_of(features); ++p) {
    ContactPointLanes& point = batch.points[p];
    const V ax = group.load(point.normal_arm_a), ay = group.load(point.normal_arm_b);
    const V bx = group.load(point.tangent_arm_a), by = group.load(point.tangent_arm_b);
    const auto effective_mass = [&](V arm_a, V arm_b) {
      return inverse_or_zero((inv_mass + pair.inv_inertia_a * arm_a * arm_a) + pair.inv_inertia_b * arm_b * arm_b);
    };
    const V arm_a = ax * pair.ny - ay * pair.nx;
    const V arm_b = bx * pair.ny - by * pair.nx;
    const V tangent_a = -(ax * pair.nx + ay * pair.ny);
    const V tangent_b = -(bx * pair.nx + by * pair.ny);
    const V exists = group.load(point.normal_mass);
    group.store(point.normal_arm_a, arm_a);
    group.store(point.normal_arm_b, arm_b);
    group.store(point.tangent_arm_a, tangent_a);
    group.store(point.tangent_arm_b, tangent_b);
    group.store(point.normal_mass, exists * effective_mass(arm_a, arm_b));
    group.store(point.normal_impulse, h * group.load(point.normal_impulse));
    if constexpr (has(features, contact_feature::friction)) {
      group.store(point.tangent_mass, exists * effective_mass(tangent_a, tangent_b));
      group.store(point.tangent_impulse, h * group.load(point.tangent_impulse));
    } else {
      group.store(point.tangent_impulse, V{});
    }
    if constexpr (has(features, contact_feature::bounce)) {
      const V approach = speed + (pair.b.at[2] * arm_b - pair.a.at[2] * arm_a);
      group.store(work.bounces[i].approach[p], approach);
    }
  }
}

template <unsigned features>
void prepare(const ContactWork& work) {
  for_groups<Twin>(
      work, [&](const auto& group, std::size_t i)
                __attribute__((always_inline)) { prepare_group<features>(work, i, group); });
}

// Conditions of a lane, and of as many as a Wide has.
bool any_of(bool lane) {
  return lane;
}
bool any_of(WideMask lanes) {
  bool any = false;
  for (int lane = 0; lane < wide_count; ++lane) any |= lanes[lane] != 0;
  return any;
}
bool both(bool a, bool b) {
  return a && b;
}
WideMask both(WideMask a, WideMask b) {
  return a & b;
}
bool either(bool a, bool b) {
  return a || b;
}
WideMask either(WideMask a, WideMask b) {
  return a | b;
}

template <unsigned features, typename V>
TICKTRUE_INLINE bool bounce_group(const ContactWork& work, std::size_t i, const Group<V>& group, Real threshold) {
  ContactBatch& batch = group.batch;
  BounceLanes& bounces = work.bounces[i];
  const V zero{};
  Pair<V> pair = load_pair(group, work.bodies);
  const V inv_mass = pair.inv_mass_a + pair.inv_mass_b;
  const V restitution = group.load(bounces.restitution);
  V speed = (pair.b.at[0] - pair.a.at[0]) * pair.nx + (pair.b.at[1] - pair.a.at[1]) * pair.ny;
  V pushed = zero;
  auto bounced = zero > zero;
  for (int p = 0; p < points_of(features); ++p) {
    // Newton's law of restitution: v_n after = -e v_n before, for points that approached and did push.
    ContactPointLanes& point = batch.points[p];
    const V approach = group.load(bounces.approach[p]);
    const auto hits = both(both(restitution > zero, VectorOf<V>::spread(-threshold) >= approach),
                           group.load(bounces.impulse_max[p]) > zero);
    if (!any_of(hits)) continue;
    bounced = either(bounced, hits);
    const V arm_a = group.load(point.normal_arm_a);
    const V arm_b = group.load(point.normal_arm_b);
    const V velocity = speed + (pair.b.at[2] * arm_b - pair.a.at[2] * arm_a);
    const V old_impulse = group.load(point.normal_impulse);
    const V wanted = old_impulse - group.load(point.normal_mass) * (velocity + restitution * approach);
    const V impulse = choose(hits, larger(wanted, zero), old_impulse);
    group.store(point.normal_impulse, impulse);
    const V change = impulse - old_impulse;
    speed += inv_mass * change;
    pair.a.at[2] -= (pair.inv_inertia_a * arm_a) * change;
    pair.b.at[2] += (pair.inv_inertia_b * arm_b) * change;
    pushed += change;
  }
  if (!any_of(bounced)) return false;
  // Velocities of what does not bounce keep the signs of their zeros, whoever is beside it.
  const Pair<V> before = load_pair(group, work.bodies);
  add_impulses(pair, pushed, zero);
  for (int axis = 0; axis < 3; ++axis) {
    pair.a.at[axis] = choose(bounced, pair.a.at[axis], before.a.at[axis]);
    pair.b.at[axis] = choose(bounced, pair.b.at[axis], before.b.at[axis]);
  }
  store_pair(group, pair, work.bodies);
  return true;
}

template <unsigned features>
bool bounce(const ContactWork& work, Real threshold) {
  bool any = false;
  if constexpr (has(features, contact_feature::bounce))
    for_groups<Wide>(
        work, [&](const auto& group, std::size_t i) __attribute__((always_inline)) {
          if (group.batch.bounces != 0) any |= bounce_group<features>(work, i, group, threshold);
        });
  return any;
}

/// The kernels that are compiled: a second point or a radius there always is, and surfaces come with everything.
constexpr unsigned compiled(unsigned features) {
  if (has(features, contact_feature::surface)) return contact_feature::all;
  return has(features, contact_feature::second_point) ? features : features | contact_feature::radius;
}

template <unsigned features>
constexpr ContactKernels kernels_with{prepare<compiled(features)>,
                                      warm_start<compiled(features)>,
                                      solve<compiled(features), Pass::solve>,
                                      solve<compiled(features), Pass::solve_again>,
                                      solve<compiled(features), Pass::relax>,
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
