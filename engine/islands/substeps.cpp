// The number of substeps of an island, from error estimates of its supports.
// SPDX-License-Identifier: MIT
// Source: the deflection of soft constraints falls as substeps^-2: error = force / (effective mass * omega^2) with
// omega proportional to the substep rate. Hence n = 4 sqrt(error at 4 substeps / allowed error).
#include "base/limits.h"
#include "engine/contacts/contact_stiffness.h"
#include "engine/islands/islands.h"
#include "engine/joints/joint.h"
#include "engine/model/margins.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr std::uint32_t idle_tick_count = 60;  // ticks that needed fewer substeps before the number falls
constexpr int reference_substeps = 4;
constexpr std::uint32_t not_carried = 0xffffffff;

/// 1 / (effective mass of a contact point along the normal).
Real inv_effective_mass(const Model& model, const State& state, const ContactPair& pair, const ManifoldPoint& point) {
  const BodyModel& a = model.bodies[state.bodies[pair.body_a].source];
  const BodyModel& b = model.bodies[state.bodies[pair.body_b].source];
  const Real arm_a = cross(point.anchor_a, pair.manifold.normal);
  const Real arm_b = cross(point.anchor_b, pair.manifold.normal);
  return ((a.inv_mass + b.inv_mass) + a.inv_inertia * arm_a * arm_a) + b.inv_inertia * arm_b * arm_b;
}

/// Compliance of a contact at the reference number of substeps, m/N.
Real contact_compliance(const Model& model, const State& state, const ContactPair& pair, Real h) {
  Real stiffness = 0;  // N/m
  for (int i = 0; i < pair.manifold.point_count; ++i) {
    const Real inv_mass = inv_effective_mass(model, state, pair, pair.manifold.points[i]);
    if (inv_mass > 0) stiffness += soft_contact_stiffness(h) / inv_mass;
  }
  const bool immovable = type_of(model, state, pair.body_a) != BodyType::dynamic_body ||
                         type_of(model, state, pair.body_b) != BodyType::dynamic_body;
  if (immovable) stiffness *= 4;  // twice the frequency
  return stiffness > 0 ? 1 / stiffness : Real(0);
}

/// Compliance of a joint at the reference number of substeps, m/N. Chains swing: they get twice the substeps that their
/// weight needs, and so four times the compliance.
Real joint_compliance(const Model& model, const State& state, std::uint32_t a, std::uint32_t b, Real h) {
  const Real inv_mass = model.bodies[state.bodies[a].source].inv_mass + model.bodies[state.bodies[b].source].inv_mass;
  return 4 * inv_mass / joint_stiffness(h);
}

/// Angular compliance of a rigid weld at the reference number of substeps, rad/(N m); 0 of other joints.
Real joint_angular_compliance(const Model& model, const State& state, const JointModel& joint, std::uint32_t a,
                              std::uint32_t b, Real h) {
  if (!joint.rigid_angle) return 0;
  const Real inv_inertia =
      model.bodies[state.bodies[a].source].inv_inertia + model.bodies[state.bodies[b].source].inv_inertia;
  return inv_inertia / joint_stiffness(h);
}

/// Whether the bodies rest on each other, or are about to. A speculative contact supports nothing.
bool carries(const ContactPair& pair) {
  Real least = pair.manifold.points[0].separation;
  if (pair.manifold.point_count == 2) least = smaller(least, pair.manifold.points[1].separation);
  return least <= resting_margin(pair.size);
}

/// Lists, for each body, what it touches or is joined to.
void list_supports(const Model& model, const State& state, TickLists& tick, IslandWork& work, Real h) {
  std::vector<std::uint32_t>& start = work.support_start;
  start.assign(state.bodies.size() + 2, 0);
  for (const ContactPair& pair : tick.contact_pairs) {
    if (!carries(pair)) continue;
    ++start[pair.body_a + 2];
    ++start[pair.body_b + 2];
  }
  for (const JointRow& joint : state.joints) {
    if (joint.body_a == no_reference) continue;
    ++start[row_of(state, joint.body_a) + 2];
    ++start[row_of(state, joint.body_b) + 2];
  }
  for (std::size_t i = 2; i < start.size(); ++i) start[i] += start[i - 1];
  work.supports.resize(start.back());
  for (const ContactPair& pair : tick.contact_pairs) {
    if (!carries(pair)) continue;
    const Real compliance = contact_compliance(model, state, pair, h);
    const ManifoldPoint& p = pair.manifold.points[0];
    const ManifoldPoint& q = pair.manifold.points[pair.manifold.point_count - 1];
    const Real half_width2 = length_squared(Real(0.5) * (q.anchor_a - p.anchor_a));
    const Real angular_compliance = half_width2 > 0 ? compliance / half_width2 : Real(0);
    work.supports[start[pair.body_a + 1]++] = {
        pair.body_b, compliance, 0, 0, Real(0.5) * (p.anchor_a + q.anchor_a), half_width2, angular_compliance};
    work.supports[start[pair.body_b + 1]++] = {
        pair.body_a, compliance, 0, 0, Real(0.5) * (p.anchor_b + q.anchor_b), half_width2, angular_compliance};
  }
  for (const JointRow& joint : state.joints) {
    if (joint.body_a == no_reference) continue;
    const std::uint32_t a = row_of(state, joint.body_a);
    const std::uint32_t b = row_of(state, joint.body_b);
    const Real compliance = joint_compliance(model, state, a, b, h);
    const JointModel& constants = model.joints[joint.joint];
    const Real arm_a = length(constants.anchor_a);
    const Real arm_b = length(constants.anchor_b);
    const Vec2 anchor_a = rotate(state.bodies[a].rotation, constants.anchor_a);
    const Vec2 anchor_b = rotate(state.bodies[b].rotation, constants.anchor_b);
    const Real angular_compliance = joint_angular_compliance(model, state, constants, a, b, h);
    work.supports[start[a + 1]++] = {b, compliance, arm_a, arm_b, anchor_a, 0, angular_compliance};
    work.supports[start[b + 1]++] = {a, compliance, arm_b, arm_a, anchor_b, 0, angular_compliance};
  }
}

std::span<const Support> supports_of(const IslandWork& work, std::uint32_t row) {
  return {work.supports.data() + work.support_start[row], work.support_start[row + 1] - work.support_start[row]};
}

/// Steps from the nearest immovable body, breadth first; support_order lists what is carried, nearest first.
void find_depths(const Model& model, const State& state, IslandWork& work) {
  work.support_depth.assign(state.bodies.size(), not_carried);
  work.support_order.clear();
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row)
    if (type_of(model, state, row) != BodyType::dynamic_body) {
      work.support_depth[row] = 0;
      work.support_order.push_back(row);
    }
  for (std::size_t next = 0; next < work.support_order.size(); ++next) {
    const std::uint32_t row = work.support_order[next];
    for (const Support& support : supports_of(work, row)) {
      if (work.support_depth[support.other] != not_carried) continue;
      work.support_depth[support.other] = work.support_depth[row] + 1;
      work.support_order.push_back(support.other);
    }
  }
}

/// Calls `use` with each support of a body that is one step nearer to the ground.
template <typename Use>
void for_each_carrier(const IslandWork& work, std::uint32_t row, Use use) {
  for (const Support& support : supports_of(work, row))
    if (work.support_depth[support.other] + 1 == work.support_depth[row]) use(support);
}

/// How hard joints hold each body that whirls: w^2 r of every arm on the way to what cannot move.
void find_joint_accelerations(const State& state, IslandWork& work) {
  work.joint_acceleration.assign(state.bodies.size(), 0);
  const auto spin2 = [&](std::uint32_t row) {
    return state.bodies[row].angular_velocity * state.bodies[row].angular_velocity;
  };
  for (const std::uint32_t row : work.support_order)
    for_each_carrier(work, row, [&](const Support& support) {
      const Real here = spin2(support.other) * support.other_arm + spin2(row) * support.arm;
      work.joint_acceleration[row] =
          larger(work.joint_acceleration[row], work.joint_acceleration[support.other] + here);
    });
}

/// What a body adds to the load, N: its weight, and what its joints hold it by.
Real own_load(const Model& model, const State& state, const IslandWork& work, std::uint32_t row) {
  const BodyModel& body = model.bodies[state.bodies[row].source];
  return (absolute(body.gravity_scale) * length(state.world.gravity) + work.joint_acceleration[row]) * body.mass;
}

/// Weights and pulls go down the shortest ways to the ground, shared among equal ones; sags add up on the way back.
void estimate_errors(const Model& model, const State& state, TickLists& tick, IslandWork& work) {
  tick.load.assign(state.bodies.size(), 0);
  work.position_error.assign(state.bodies.size(), 0);
  work.local_error.assign(state.bodies.size(), 0);
  find_joint_accelerations(state, work);
  const auto share_of = [&](std::uint32_t row) {
    int count = 0;
    for_each_carrier(work, row, [&](const Support&) { ++count; });
    return tick.load[row] / static_cast<Real>(count);
  };
  for (std::size_t i = work.support_order.size(); i-- > 0;) {
    const std::uint32_t row = work.support_order[i];
    if (work.support_depth[row] == 0) continue;
    tick.load[row] += own_load(model, state, work, row);
    const Real share = share_of(row);
    for_each_carrier(work, row, [&](const Support& support) { tick.load[support.other] += share; });
  }
  for (const std::uint32_t row : work.support_order) {
    if (work.support_depth[row] == 0) continue;
    const Real share = share_of(row);
    const Real size = model.bodies[state.bodies[row].source].size;
    for_each_carrier(work, row, [&](const Support& support) {
      const Real compression = share * support.compliance;
      work.position_error[row] = larger(work.position_error[row], work.position_error[support.other] + compression);
      const bool both_move = work.support_depth[support.other] != 0;
      const Real other_size = model.bodies[state.bodies[support.other].source].size;
      const Real least = both_move ? smaller(size, other_size) : size;
      if (least > 0) work.local_error[row] = larger(work.local_error[row], compression / least);
    });
  }
}

/// A load beside the middle of a contact tilts what lies on it, and all that stands there leans; a weld bends under
/// what hangs from it. Of bodies that one contact or weld alone carries.
void estimate_tilts(const State& state, TickLists& tick, IslandWork& work) {
  work.load_moment.assign(state.bodies.size(), {0, 0});
  work.tilt_errors.assign(state.bodies.size(), {{0, 0}, 0});
  const Vec2 gravity = state.world.gravity;
  if (!(length(gravity) > 0)) return;
  const Vec2 down = (1 / length(gravity)) * gravity;
  const auto count_of = [&](std::uint32_t row) {
    int count = 0;
    for_each_carrier(work, row, [&](const Support&) { ++count; });
    return count;
  };
  std::vector<Real>& load_passed_on = work.load_passed_on;
  load_passed_on.assign(state.bodies.size(), 0);
  for (std::size_t i = work.support_order.size(); i-- > 0;) {
    const std::uint32_t row = work.support_order[i];
    if (work.support_depth[row] == 0) continue;
    Vec2& moment = work.load_moment[row];
    moment = moment + (tick.load[row] - load_passed_on[row]) * state.bodies[row].position;
    const Real share = 1 / static_cast<Real>(count_of(row));
    for_each_carrier(work, row, [&](const Support& support) {
      load_passed_on[support.other] += share * tick.load[row];
      work.load_moment[support.other] = work.load_moment[support.other] + share * moment;
    });
  }
  for (const std::uint32_t row : work.support_order) {
    if (work.support_depth[row] == 0 || count_of(row) != 1 || !(tick.load[row] > 0)) continue;
    for_each_carrier(work, row, [&](const Support& support) {
      if (!(support.angular_compliance > 0)) return;
      const Vec2 position = state.bodies[row].position;
      const Vec2 middle = position + support.middle;
      const Vec2 center = (1 / tick.load[row]) * work.load_moment[row];
      const Real lever = cross(center - middle, down);
      if (support.half_width2 > 0 && !(lever * lever < support.half_width2)) return;  // it topples
      const Real torque = tick.load[row] * lever;
      const TiltError& below = work.tilt_errors[support.other];
      TiltError& tilt = work.tilt_errors[row];
      tilt.angle = below.angle + torque * support.angular_compliance;
      const Vec2 under = middle - state.bodies[support.other].position;
      tilt.displacement = (below.displacement + cross(below.angle, under)) - cross(tilt.angle, support.middle);
    });
  }
}

/// The power of two from `least` to `most` with which the error of a body is allowed.
std::uint32_t wanted_substeps(Real error, Real allowed, std::uint32_t least, std::uint32_t most) {
  std::uint32_t count = least;
  // error at n substeps = error * (4 / n)^2
  while (count < most && error * static_cast<Real>(reference_substeps * reference_substeps) >
                             allowed * static_cast<Real>(count) * static_cast<Real>(count))
    count *= 2;
  return count < most ? count : most;
}

// The largest mass that constraints may add on a path to the ground, relative to the supported mass.
constexpr Real added_share_max = Real(0.01);

/// Where not even the most substeps keep a sag within its allowance: how much heavier constraints shall see what
/// carries the load, which is far heavier. Sags fall by as much.
void find_mass_factors(const Model& model, const State& state, TickLists& tick, IslandWork& work) {
  const Settings& settings = model.scene.settings;
  const Real target = static_cast<Real>(settings.auto_substeps->target_error);
  const Real ratio = static_cast<Real>(reference_substeps) / static_cast<Real>(settings.auto_substeps->substeps_max);
  tick.mass_factor.assign(state.bodies.size(), 1);
  std::vector<IslandError>& islands = work.island_errors;
  islands.assign(state.bodies.size(), {0, 0});
  for (const std::uint32_t row : work.support_order) {
    if (work.support_depth[row] == 0) continue;
    const Real size = model.bodies[state.bodies[row].source].size;
    const Real whole = size > 0 ? work.position_error[row] / size : Real(0);
    IslandError& island = islands[find_root(tick.island_parent, row)];
    island.error = larger(island.error, (ratio * ratio) * larger(whole, work.local_error[row]) / target);
    island.depth = larger(island.depth, static_cast<Real>(work.support_depth[row]));
  }
  for (const std::uint32_t row : work.support_order) {
    if (work.support_depth[row] == 0) continue;
    const IslandError& island = islands[find_root(tick.island_parent, row)];
    const Real own = own_load(model, state, work, row);
    if (!(island.error > 1) || !(own > 0)) continue;
    const Real most = added_share_max * (tick.load[row] - own) / (own * island.depth);
    tick.mass_factor[row] = larger(1, smaller(island.error, most));
  }
}

}  // namespace

void choose_substeps(const Model& model, State& state, TickLists& tick, IslandWork& work, Real dt) {
  const Settings& settings = model.scene.settings;
  const auto least = static_cast<std::uint32_t>(settings.substeps);
  tick.island_level.assign(state.bodies.size(), least);
  tick.resting_impacts.clear();
  tick.island_has_resting_impact.assign(state.bodies.size(), 0);
  if (!settings.auto_substeps) return;
  list_supports(model, state, tick, work, dt / static_cast<Real>(reference_substeps));
  find_depths(model, state, work);
  estimate_errors(model, state, tick, work);
  estimate_tilts(state, tick, work);
  find_mass_factors(model, state, tick, work);
  const auto most = static_cast<std::uint32_t>(settings.auto_substeps->substeps_max);
  const Real target = static_cast<Real>(settings.auto_substeps->target_error);
  std::vector<std::uint32_t>& level = tick.island_level;
  // What the island needs now.
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
    if (type_of(model, state, row) != BodyType::dynamic_body) continue;
    std::uint32_t& island = level[find_root(tick.island_parent, row)];
    const BodyModel& body = model.bodies[state.bodies[row].source];
    // What comes suddenly swings out twice as far.
    const Real error = larger(work.position_error[row], 2 * length(work.tilt_errors[row].displacement));
    const std::uint32_t wanted = wanted_substeps(error, target * body.size, least, most);
    const std::uint32_t wanted_here = wanted_substeps(work.local_error[row], target, least, most);
    island = island > wanted ? island : wanted;
    island = island > wanted_here ? island : wanted_here;
  }
  // What it has had: rises at once, falls after calm ticks.
  std::vector<std::uint32_t>& had = work.substeps_before;
  had.assign(state.bodies.size(), 0);
  std::vector<std::uint32_t>& idle = work.idle_ticks;
  idle.assign(state.bodies.size(), idle_tick_count);
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
    const std::uint32_t root = find_root(tick.island_parent, row);
    const SubstepRow& now = state.substeps[row];
    if (now.count > had[root]) {
      had[root] = now.count;
      idle[root] = now.idle_ticks;
    } else if (now.count == had[root] && now.idle_ticks < idle[root]) {
      idle[root] = now.idle_ticks;
    }
  }
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
    if (type_of(model, state, row) != BodyType::dynamic_body) continue;
    const std::uint32_t root = find_root(tick.island_parent, row);
    const bool keeps = had[root] > level[root] && idle[root] + 1 < idle_tick_count;
    SubstepRow& now = state.substeps[row];
    now.count = keeps ? had[root] : level[root];
    now.idle_ticks = keeps ? idle[root] + 1 : 0;
  }
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row)
    if (type_of(model, state, row) == BodyType::dynamic_body)
      level[find_root(tick.island_parent, row)] = state.substeps[row].count;
  find_resting_impacts(model, state, tick, dt);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
