// The number of substeps of an island, from error estimates of its supports.
// SPDX-License-Identifier: MIT
// Source: the deflection of soft constraints falls as substeps^-2. The error is force / (effective mass * omega^2),
// with omega proportional to the substep rate. Hence n = 4 sqrt(error at 4 substeps / allowed error).
#include <algorithm>

#include "base/limits.h"
#include "engine/integrators/forces.h"
#include "engine/islands/islands.h"
#include "engine/islands/pushes.h"
#include "engine/islands/substep_budget.h"
#include "engine/islands/supports.h"
#include "engine/math/trig.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

// Limit of the contacts solved for resting impacts in a tick without a budget. Beyond the limit, each substep gets one
// check. A pile that never settles then takes hundredths of a second.
constexpr std::uint64_t shock_work_max = 1u << 21;
constexpr std::uint32_t idle_tick_count = 60;  // ticks with a smaller need before the number falls
// Then the number falls by an eighth each time, and the sag grows by a third. A stack under a far heavier box hops if
// its sag grows fourfold at once.
constexpr std::uint32_t fall_tick_count = 4;
constexpr std::uint32_t fall_unit = 4;  // substeps: to multiples of these

/// The centripetal acceleration by joints of each rotating body: the sum of w^2 r of the arms towards the nearest
/// immovable body.
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

bool is_floating(const IslandWork& work, std::uint32_t row) {
  return !work.is_floating.empty() && work.is_floating[row] != 0;
}

/// The own load of a body, N: its weight, the force by which its joints hold it, and, where loads are measured, the
/// forces that are known before the tick.
Real own_load(const Model& model, const State& state, const IslandWork& work, std::uint32_t row) {
  const std::uint32_t source = state.bodies[row].source;
  const BodyModel& body = model.bodies[source];
  if (is_floating(work, row)) return work.joint_acceleration[row] * body.mass;
  const Real own =
      (absolute(body.gravity_scale) * length(state.world.gravity) + work.joint_acceleration[row]) * body.mass;
  return work.known_force.empty() ? own : own + work.known_force[row];
}

/// A force and its direction.
struct KnownForce {
  Real size;   // N
  Vec2 along;  // unit; 0 without a force
};

/// The force of a pointer on its body, if something holds the body back: that of the spring at its present length, at
/// most the largest force.
KnownForce pointer_force(const Model& model, const State& state, const PointerRow& pointer) {
  const PointerSettings& settings = *model.scene.pointer;
  const BodyRow& body = state.bodies[row_of(state, pointer.body)];
  const Real mass = model.bodies[body.source].mass;
  const Vec2 point = body.position + rotate(body.rotation, pointer.anchor);
  const Real rate = Real(2 * pi) * static_cast<Real>(settings.hertz);
  const Vec2 way = pointer.target - point;
  const Real distance = length(way);
  const Real wanted = (mass * rate * rate) * distance;
  const Real now = length(pointer.force);
  const Vec2 along = wanted > now ? (1 / distance) * way : now > 0 ? (1 / now) * pointer.force : Vec2{};
  return {smaller(larger(wanted, now), static_cast<Real>(settings.force_max_per_kg) * mass), along};
}

/// The force of dampings and drags on a body at its present velocity.
Real drag_force(const Model& model, const BodyRow& body) {
  const BodyModel& constants = model.bodies[body.source];
  const Real speed = length(body.velocity);
  const Real quadratic = model.body_forces.empty() ? Real(0) : model.body_forces[body.source].quadratic_drag;
  return constants.mass * (constants.linear_damping + quadratic * speed) * speed;
}

/// Adds the forces of central forces and springs at the present positions.
void add_position_forces(const Model& model, const State& state, std::vector<Vec2>& force) {
  const std::size_t count = state.bodies.size();
  for (const CentralForce& central : model.centrals) {
    const std::size_t first = central.every ? 0 : state.find_body(central.body);
    const std::size_t end = central.every ? count : std::min(first + 1, count);
    for (std::size_t row = first; row < end; ++row) {
      const Vec2 r = state.bodies[row].position - central.center;
      const Real distance = length(r);
      if (!(distance > 0)) continue;
      const Real mass = model.bodies[state.bodies[row].source].mass;
      force[row] = force[row] - (mass * central.strength * power(distance, central.exponent - 1)) * r;
    }
  }
  for (const SpringForce& spring : model.springs) {
    const std::size_t a = state.find_body(spring.body);
    const std::size_t b = spring.other == no_reference ? count : state.find_body(spring.other);
    if (a == count || (b == count && spring.other != no_reference)) continue;
    const auto point_of = [&](std::size_t row, Vec2 anchor) {
      return state.bodies[row].position + rotate(state.bodies[row].rotation, anchor);
    };
    const Vec2 line = (b == count ? spring.point : point_of(b, spring.point)) - point_of(a, spring.anchor);
    const Real distance = length(line);
    if (!(distance > 0)) continue;
    const Vec2 pull = (spring.stiffness * (distance - spring.rest_length) / distance) * line;
    force[a] = force[a] + pull;
    if (b != count) force[b] = force[b] - pull;
  }
}

/// Finds the forces on each body that are known before the tick: of elements, of inputs, of pointers, of dampings, and
/// of motors along an axis. A motor far from its speed has its largest force, another motor the force of the last tick.
void find_known_forces(const Model& model, const State& state, const TickLists& tick, IslandWork& work) {
  work.known_force.assign(state.bodies.size(), 0);
  work.directed.force.assign(state.bodies.size(), {0, 0});
  add_position_forces(model, state, work.directed.force);
  for (const std::uint32_t row : work.support_order) {
    const std::uint32_t source = state.bodies[row].source;
    Vec2& force = work.directed.force[row];
    if (!tick.force.empty()) force = force + tick.force[row];
    if (!model.body_forces.empty()) force = force + model.bodies[source].mass * model.body_forces[source].acceleration;
    work.known_force[row] = length(force) + drag_force(model, state.bodies[row]);
  }
  for (const PointerRow& pointer : state.pointers) {
    const std::uint32_t row = row_of(state, pointer.body);
    const KnownForce force = pointer_force(model, state, pointer);
    work.known_force[row] += force.size;
    work.directed.force[row] = work.directed.force[row] + force.size * force.along;
  }
  for (const JointRow& joint : state.joints) {
    if (!slides(joint)) continue;
    const std::uint32_t a = row_of(state, joint.body_a);
    const std::uint32_t b = row_of(state, joint.body_b);
    const Real speed = length(state.bodies[b].velocity - state.bodies[a].velocity);
    const bool is_slow = speed < Real(0.5) * absolute(joint.motor_speed);
    const Real force = is_slow ? joint.motor_force_max : absolute(joint.motor_force);
    work.known_force[a] += force;
    work.known_force[b] += force;
    if (joint.kind != static_cast<std::uint32_t>(JointKind::prismatic)) continue;  // the motor of a wheel turns it
    const Real along = is_slow && joint.motor_speed < 0 ? -force : is_slow ? force : joint.motor_force;
    const Vec2 push = along * rotate(state.bodies[a].rotation, model.joints[joint.joint].axis);
    work.directed.force[a] = work.directed.force[a] - push;
    work.directed.force[b] = work.directed.force[b] + push;
  }
}

// rad, of a body on direct joints, or of a rigid rod, in a substep: a whip loses energy beyond.
constexpr Real turn_max = Real(0.03);
constexpr Real sway_max = Real(0.6);         // rate times substep: light links between heavy bodies come apart beyond
constexpr Real whirl_sway_max = Real(0.15);  // where no weight loads the joints: a bent chain loses energy beyond
// Of what hits bodies on direct joints: sizes of the smaller shape in a substep.
constexpr Real strike_max = Real(0.05);
// What hits an immovable body turns about its joints only afterwards. Then its joints may open.
constexpr Real immovable_strike_share = Real(0.25);
constexpr std::uint32_t sway_substeps_max = 64;  // enough for 10,000 times the mass of a link at its end

// A measured load counts if it exceeds the weights by this factor, since measured loads of bodies at rest vary.
constexpr Real excess_least = Real(1.25);

/// Passes loads down the shortest paths to the ground, in equal shares; compressions add up on the way back. If
/// `measured_force` is not empty, a body carries the measured force, N, if that is far larger.
void estimate_errors(const Model& model, const State& state, const IslandWork& work,
                     std::span<const Real> measured_force, LoadEstimate& out) {
  out.load.assign(state.bodies.size(), 0);
  out.position_error.assign(state.bodies.size(), 0);
  out.local_error.assign(state.bodies.size(), 0);
  const auto share_of = [&](std::uint32_t row) {
    int count = 0;
    for_each_carrier(work, row, [&](const Support&) { ++count; });
    return out.load[row] / static_cast<Real>(count);
  };
  for (std::size_t i = work.support_order.size(); i-- > 0;) {
    const std::uint32_t row = work.support_order[i];
    if (work.support_depth[row] == 0) continue;
    out.load[row] += own_load(model, state, work, row);
    if (!measured_force.empty() && measured_force[row] > excess_least * out.load[row])
      out.load[row] = measured_force[row];
    const Real share = share_of(row);
    for_each_carrier(work, row, [&](const Support& support) { out.load[support.other] += share; });
  }
  for (const std::uint32_t row : work.support_order) {
    if (work.support_depth[row] == 0) continue;
    const Real share = share_of(row);
    const Real size = model.bodies[state.bodies[row].source].size;
    for_each_carrier(work, row, [&](const Support& support) {
      const Real compression = share * support.compliance;
      out.position_error[row] = larger(out.position_error[row], out.position_error[support.other] + compression);
      const bool both_move = is_dynamic(work, support.other);
      const Real other_size = model.bodies[state.bodies[support.other].source].size;
      const Real least = both_move ? smaller(size, other_size) : size;
      if (least > 0) out.local_error[row] = larger(out.local_error[row], compression / least);
    });
  }
}

/// Estimates the tilt of bodies that one contact or weld alone carries. A load beside the middle of a contact tilts the
/// body, and everything that stands on it leans. A weld bends under the load that hangs from it.
void estimate_tilts(const State& state, IslandWork& work) {
  const std::vector<Real>& load = work.weights.load;
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
    moment = moment + (load[row] - load_passed_on[row]) * state.bodies[row].position;
    const int count = count_of(row);
    const Real share = load[row] / static_cast<Real>(count);
    // One support carries the load where its centre is; each of several carries its share where it touches.
    for_each_carrier(work, row, [&](const Support& support) {
      const Vec2 passed_on = count == 1 ? moment : share * (state.bodies[row].position + support.middle);
      load_passed_on[support.other] += share;
      work.load_moment[support.other] = work.load_moment[support.other] + passed_on;
    });
  }
  for (const std::uint32_t row : work.support_order) {
    if (work.support_depth[row] == 0 || count_of(row) != 1 || !(load[row] > 0) || is_floating(work, row)) continue;
    for_each_carrier(work, row, [&](const Support& support) {
      if (!(support.angular_compliance > 0)) return;
      const Vec2 position = state.bodies[row].position;
      const Vec2 middle = position + support.middle;
      const Vec2 center = (1 / load[row]) * work.load_moment[row];
      const Real lever = cross(center - middle, down);
      if (support.half_width2 > 0 && !(lever * lever < support.half_width2)) return;  // the body topples
      const Real torque = load[row] * lever;
      const TiltError& below = work.tilt_errors[support.other];
      TiltError& tilt = work.tilt_errors[row];
      tilt.angle = below.angle + torque * support.angular_compliance;
      const Vec2 under = middle - state.bodies[support.other].position;
      tilt.displacement = (below.displacement + cross(below.angle, under)) - cross(tilt.angle, support.middle);
    });
  }
}

/// The least multiple of `least` that is enough, at most `most`. What is enough stays enough for a larger number.
template <typename IsEnough>
std::uint32_t least_multiple(std::uint32_t least, std::uint32_t most, const IsEnough& is_enough) {
  if (is_enough(least)) return least;
  std::uint32_t too_few = 1;  // in multiples of `least`
  std::uint32_t enough = most / least + 1;
  while (enough - too_few > 1) {
    const std::uint32_t middle = (too_few + enough) / 2;
    if (is_enough(least * middle))
      enough = middle;
    else
      too_few = middle;
  }
  return std::min(least * enough, most);
}

/// The number of substeps for which the error of a body is allowed.
std::uint32_t wanted_substeps(Real error, Real allowed, std::uint32_t least, std::uint32_t most) {
  // error at n substeps = error * (4 / n)^2
  return least_multiple(least, most, [&](std::uint32_t count) {
    return !(error * static_cast<Real>(reference_substeps * reference_substeps) >
             allowed * static_cast<Real>(count) * static_cast<Real>(count));
  });
}

/// The least power of two times `least` that is at least `count`, at most `most`. The margin is for what the estimate
/// leaves out, such as landings. Rounding up commutes with the larger and the smaller of two numbers.
std::uint32_t with_margin(std::uint32_t count, std::uint32_t least, std::uint32_t most) {
  std::uint32_t rounded = least;
  while (rounded < count) rounded *= 2;
  return std::min(rounded, most);
}

// The largest mass that constraints may add on a path to the ground, relative to the supported mass.
constexpr Real added_share_max = Real(0.01);

/// Where even the most substeps leave a compression too large, finds factors for the masses of bodies that carry a far
/// heavier load. Constraints use the larger masses, and compressions fall by the factor.
void find_mass_factors(const Model& model, const State& state, TickLists& tick, IslandWork& work) {
  const LoadEstimate& loads = work.weights;
  const Settings& settings = model.scene.settings;
  const Real target = static_cast<Real>(settings.auto_substeps->target_error);
  const Real ratio = static_cast<Real>(reference_substeps) / static_cast<Real>(settings.auto_substeps->substeps_max);
  tick.mass_factor.assign(state.bodies.size(), 1);
  std::vector<IslandError>& islands = work.island_errors;
  islands.assign(state.bodies.size(), {0, 0});
  for (const std::uint32_t row : work.support_order) {
    if (work.support_depth[row] == 0 || is_floating(work, row)) continue;
    const Real size = model.bodies[state.bodies[row].source].size;
    const Real whole = size > 0 ? loads.position_error[row] / size : Real(0);
    IslandError& island = islands[tick.island[row]];
    island.error = larger(island.error, (ratio * ratio) * larger(whole, loads.local_error[row]) / target);
    island.depth = larger(island.depth, static_cast<Real>(work.support_depth[row]));
  }
  for (const std::uint32_t row : work.support_order) {
    if (work.support_depth[row] == 0 || is_floating(work, row)) continue;
    const IslandError& island = islands[tick.island[row]];
    const Real own = own_load(model, state, work, row);
    if (!(island.error > 1) || !(own > 0)) continue;
    const Real most = added_share_max * (loads.load[row] - own) / (own * island.depth);
    tick.mass_factor[row] = larger(1, smaller(island.error, most));
  }
}

/// Raises the level of each island to the need of its loads.
void raise_levels(const Model& model, const State& state, const TickLists& tick, const IslandWork& work,
                  const LoadEstimate& loads, std::vector<std::uint32_t>& level) {
  const Settings& settings = model.scene.settings;
  const auto least = static_cast<std::uint32_t>(settings.substeps);
  const auto most = static_cast<std::uint32_t>(settings.auto_substeps->substeps_max);
  const Real target = static_cast<Real>(settings.auto_substeps->target_error);
  for (const std::uint32_t row : work.support_order) {
    if (!is_dynamic(work, row)) continue;
    std::uint32_t& island = level[tick.island[row]];
    const BodyModel& body = model.bodies[state.bodies[row].source];
    // A sudden load swings twice as far.
    const Real error = larger(loads.position_error[row], 2 * length(work.tilt_errors[row].displacement));
    const std::uint32_t wanted = wanted_substeps(error, target * body.size, least, most);
    const std::uint32_t wanted_here = wanted_substeps(loads.local_error[row], target, least, most);
    island = island > wanted ? island : wanted;
    island = island > wanted_here ? island : wanted_here;
  }
}

/// Adds the errors by forces between bodies of equal depth, as in a row of boxes that is pressed together.
void add_side_errors(const Model& model, const State& state, const IslandWork& work, LoadEstimate& out) {
  for (const std::uint32_t row : work.support_order) {
    if (!is_dynamic(work, row)) continue;
    for (const Support& support : supports_of(work, row)) {
      if (work.support_depth[support.other] != work.support_depth[row]) continue;
      const Real compression = support.force * support.compliance;
      const Real least =
          smaller(model.bodies[state.bodies[row].source].size, model.bodies[state.bodies[support.other].source].size);
      out.position_error[row] = larger(out.position_error[row], compression);
      if (least > 0) out.local_error[row] = larger(out.local_error[row], compression / least);
    }
  }
}

/// The squares of the rates, rad/s, at which bodies on direct joints sway: a joint that pulls with force F at distance
/// r from the centre of mass turns its body back with F r per rad, and rods pull point masses back to their line.
void find_sways(const Model& model, const State& state, IslandWork& work) {
  work.sway.assign(state.bodies.size(), 0);
  for (std::size_t i = 0; i < work.direct.is_direct.size(); ++i) {
    if (work.direct.is_direct[i] == 0) continue;
    const JointRow& joint = state.joints[i];
    const JointModel& constants = model.joints[joint.joint];
    const Real force = length(joint.linear_force);
    const bool is_rod = constants.kind == JointKind::distance && constants.length > 0;
    const auto add = [&](std::uint32_t id, Vec2 anchor) {
      if (id == no_reference) return;
      const std::uint32_t row = row_of(state, id);
      const BodyModel& body = model.bodies[state.bodies[row].source];
      work.sway[row] += force * length(anchor) * body.inv_inertia;
      if (is_rod) work.sway[row] += force / constants.length * body.inv_mass;
    };
    add(joint.body_a, constants.anchor_a);
    add(joint.body_b, constants.anchor_b);
  }
}

/// The rates at which bodies on direct joints turn, and the rods that hold them: a disc on rods may itself not turn.
void find_turns(const Model& model, const State& state, IslandWork& work) {
  work.turn.assign(state.bodies.size(), 0);
  for (std::size_t i = 0; i < work.direct.is_direct.size(); ++i) {
    if (work.direct.is_direct[i] == 0) continue;
    const JointModel& joint = model.joints[state.joints[i].joint];
    for_each_body(model, joint, [&](std::uint32_t id) {
      const std::uint32_t row = row_of(state, id);
      work.turn[row] = larger(work.turn[row], absolute(state.bodies[row].angular_velocity));
    });
    if (joint.kind != JointKind::distance || !joint.rigid || !(joint.length > 0)) continue;
    const std::uint32_t a = row_of(state, state.joints[i].body_a);
    const std::uint32_t b = row_of(state, state.joints[i].body_b);
    const BodyRow& body_a = state.bodies[a];
    const BodyRow& body_b = state.bodies[b];
    const Vec2 arm_a = rotate(body_a.rotation, joint.anchor_a);
    const Vec2 arm_b = rotate(body_b.rotation, joint.anchor_b);
    const Vec2 line = (body_b.position + arm_b) - (body_a.position + arm_a);
    const Vec2 velocity = (body_b.velocity + cross(body_b.angular_velocity, arm_b)) -
                          (body_a.velocity + cross(body_a.angular_velocity, arm_a));
    const Real rate = absolute(cross(line, velocity)) / (joint.length * joint.length);
    work.turn[a] = larger(work.turn[a], rate);
    work.turn[b] = larger(work.turn[b], rate);
  }
}

/// The greatest speed, in sizes of the smaller shape per second, at which each body will hit or be hit in this tick.
void find_strikes(const State& state, const TickLists& tick, Real dt, IslandWork& work) {
  work.strike.assign(state.bodies.size(), 0);
  for (const std::uint32_t contact : work.awake_contacts) {
    const ContactPair& pair = tick.contact_pairs[contact];
    const bool both_move = is_dynamic(work, pair.body_a) && is_dynamic(work, pair.body_b);
    const Real share = both_move ? Real(1) : immovable_strike_share;
    const BodyRow& a = state.bodies[pair.body_a];
    const BodyRow& b = state.bodies[pair.body_b];
    for (int i = 0; i < pair.manifold.point_count; ++i) {
      const ManifoldPoint& point = pair.manifold.points[i];
      const Vec2 velocity = (b.velocity + cross(b.angular_velocity, point.anchor_b)) -
                            (a.velocity + cross(a.angular_velocity, point.anchor_a));
      const Real closing = -dot(velocity, pair.manifold.normal);
      if (!(closing * dt > point.separation)) continue;
      for (const std::uint32_t row : {pair.body_a, pair.body_b})
        work.strike[row] = larger(work.strike[row], share * closing / pair.size);
    }
  }
}

/// Raises the levels of islands with bodies on direct joints until rate_of(row) times a substep is at most `most_turn`,
/// up to `most`.
template <typename RateOf>
void raise_by_rates(const Model& model, const State& state, TickLists& tick, const IslandWork& work, Real dt,
                    Real most_turn, std::uint32_t most, const RateOf& rate_of, std::vector<std::uint32_t>& level) {
  const auto least = static_cast<std::uint32_t>(model.scene.settings.substeps);
  for (std::size_t i = 0; i < work.direct.is_direct.size(); ++i) {
    if (work.direct.is_direct[i] == 0) continue;
    for_each_body(model, model.joints[state.joints[i].joint], [&](std::uint32_t id) {
      const std::uint32_t row = row_of(state, id);
      if (!is_dynamic(work, row)) return;
      const Real turn = rate_of(row) * dt;
      const std::uint32_t count = least_multiple(
          least, most, [&](std::uint32_t some) { return !(turn > most_turn * static_cast<Real>(some)); });
      std::uint32_t& at = level[tick.island[row]];
      if (count > at) at = count;
    });
  }
}

/// Whether a body turns about others on joints that no weight loads.
bool whirls(const State& state, const IslandWork& work, std::uint32_t row) {
  const bool has_weight = length(state.world.gravity) > 0 && !is_floating(work, row);
  return !has_weight && work.joint_acceleration[row] > 0;
}

/// Islands with direct joints that no tick has measured: they start with the most substeps that a sway may ask for. A
/// moving island keeps them until it is idle, another one for this tick.
void expect_sways(const Model& model, const State& state, const TickLists& tick, IslandWork& work,
                  std::vector<std::uint32_t>& level) {
  work.first_level.assign(state.bodies.size(), 0);
  const auto most = static_cast<std::uint32_t>(model.scene.settings.auto_substeps->substeps_max);
  for (std::size_t i = 0; i < work.direct.is_direct.size(); ++i) {
    if (work.direct.is_direct[i] == 0) continue;
    for_each_body(model, model.joints[state.joints[i].joint], [&](std::uint32_t id) {
      const std::uint32_t row = row_of(state, id);
      if (!is_dynamic(work, row) || state.loads[row].wanted > 0) return;
      const std::uint32_t count = whirls(state, work, row) ? most : std::min(most, sway_substeps_max);
      const std::uint32_t root = tick.island[row];
      work.first_level[root] = std::max(work.first_level[root], count);
      if (is_moving(state.bodies[row])) level[root] = std::max(level[root], count);
    });
  }
}

/// Raises the levels of islands whose constraints held more than the weights, both in this tick's forces and in those
/// of the tick before. One impact therefore does not count.
void raise_by_measured_loads(const Model& model, State& state, TickLists& tick, IslandWork& work, Real dt,
                             std::vector<std::uint32_t>& level) {
  work.measured_force.assign(state.bodies.size(), 0);
  for (const std::uint32_t row : work.support_order)
    for_each_carrier(work, row, [&](const Support& support) { work.measured_force[row] += support.force; });
  estimate_errors(model, state, work, work.measured_force, work.measured);
  add_side_errors(model, state, work, work.measured);
  std::vector<std::uint32_t>& now = work.measured_level;
  now.assign(state.bodies.size(), static_cast<std::uint32_t>(model.scene.settings.substeps));
  raise_levels(model, state, tick, work, work.measured, now);
  forget_crushed(model, state, tick, work, now);
  find_sways(model, state, work);
  const auto sway_of = [&](std::uint32_t row) { return square_root(work.sway[row]); };
  const auto least = static_cast<std::uint32_t>(model.scene.settings.substeps);
  const auto most = static_cast<std::uint32_t>(model.scene.settings.auto_substeps->substeps_max);
  raise_by_rates(model, state, tick, work, dt, sway_max, std::min(most, sway_substeps_max), sway_of, now);
  std::vector<std::uint32_t>& before = work.measured_level_before;
  before.assign(state.bodies.size(), 0);
  for (const std::uint32_t row : work.awake_rows) {
    const std::uint32_t root = tick.island[row];
    if (state.loads[row].wanted > before[root]) before[root] = state.loads[row].wanted;
  }
  for (const std::uint32_t row : work.awake_rows) {
    const std::uint32_t root = tick.island[row];
    state.loads[row].wanted = with_margin(now[root], least, most);
    const std::uint32_t both = now[root] < before[root] ? now[root] : before[root];
    if (both > level[root]) level[root] = both;
  }
  const auto whirl_of = [&](std::uint32_t row) { return whirls(state, work, row) ? sway_of(row) : Real(0); };
  raise_by_rates(model, state, tick, work, dt, whirl_sway_max, most, whirl_of, level);
}

/// The needs of islands in which nothing carries anything.
void need_nothing(const Model& model, State& state, TickLists& tick, const IslandWork& work) {
  const Settings& settings = model.scene.settings;
  tick.load.assign(state.bodies.size(), 0);
  tick.mass_factor.assign(state.bodies.size(), 1);
  if (settings.substep_loads != SubstepLoads::measured) return;
  for (const std::uint32_t row : work.awake_rows)
    state.loads[row].wanted = static_cast<std::uint32_t>(settings.substeps);
}

/// Finds the needs of all islands, without margin: tick.island_level, tick.load, tick.mass_factor.
void estimate_needs(const Model& model, State& state, TickLists& tick, IslandWork& work, Real dt) {
  const Settings& settings = model.scene.settings;
  const bool is_measured = settings.substep_loads == SubstepLoads::measured;
  work.direct.is_direct.clear();
  if (is_measured && settings.joints == JointSolverKind::direct && !state.joints.empty())
    mark_direct_joints(model, state, work.direct);
  list_supports(model, state, tick, work, dt / static_cast<Real>(reference_substeps));
  if (work.supports.empty() && state.joints.empty()) return need_nothing(model, state, tick, work);
  find_depths(model, state, work);
  find_joint_accelerations(state, work);
  if (is_measured) find_known_forces(model, state, tick, work);
  estimate_errors(model, state, work, {}, work.weights);
  estimate_tilts(state, work);
  std::vector<std::uint32_t>& level = tick.island_level;
  raise_levels(model, state, tick, work, work.weights, level);
  if (is_measured) {
    expect_sways(model, state, tick, work, level);
    raise_by_measured_loads(model, state, tick, work, dt, level);
  }
  if (is_measured && estimate_pushes(model, state, tick, work, dt))
    raise_levels(model, state, tick, work, work.pushes, level);
  if (is_measured && estimate_directed_loads(model, state, tick, work))
    raise_levels(model, state, tick, work, work.pushes, level);
  const auto most = static_cast<std::uint32_t>(settings.auto_substeps->substeps_max);
  find_turns(model, state, work);
  const auto turn_of = [&](std::uint32_t row) { return work.turn[row]; };
  raise_by_rates(model, state, tick, work, dt, turn_max, most, turn_of, level);
  if (!work.direct.is_direct.empty()) {
    find_strikes(state, tick, dt, work);
    const auto strike_of = [&](std::uint32_t row) { return work.strike[row]; };
    raise_by_rates(model, state, tick, work, dt, strike_max, most, strike_of, level);
  }
  find_mass_factors(model, state, tick, work);
  tick.load = work.weights.load;
}

/// The next smaller number of substeps of an island, at least `level`.
std::uint32_t lowered(std::uint32_t count, std::uint32_t level) {
  return std::max(count * 7 / 8 / fall_unit * fall_unit, level);
}

/// Raises the number of substeps of an island at once, and lowers it step by step after enough idle ticks. An island
/// that is not solved keeps what it had.
void change_levels(State& state, const TickLists& tick, IslandWork& work) {
  const std::vector<std::uint32_t>& level = tick.island_level;
  std::vector<std::uint32_t>& had = work.substeps_before;
  had.assign(state.bodies.size(), 0);
  std::vector<std::uint32_t>& idle = work.idle_ticks;
  idle.assign(state.bodies.size(), idle_tick_count);
  for (const std::uint32_t row : work.awake_rows) {
    const std::uint32_t root = tick.island[row];
    const SubstepRow& now = state.substeps[row];
    if (now.count > had[root]) {
      had[root] = now.count;
      idle[root] = now.idle_ticks;
    } else if (now.count == had[root] && now.idle_ticks < idle[root]) {
      idle[root] = now.idle_ticks;
    }
  }
  for (const std::uint32_t row : work.awake_rows) {
    const std::uint32_t root = tick.island[row];
    SubstepRow& now = state.substeps[row];
    if (had[root] <= level[root]) {
      now.count = level[root];
      now.idle_ticks = 0;
    } else if (idle[root] + 1 < idle_tick_count) {
      now.count = had[root];
      now.idle_ticks = idle[root] + 1;
    } else {
      now.count = lowered(had[root], level[root]);
      now.idle_ticks = idle_tick_count - fall_tick_count;
    }
  }
}

}  // namespace

void choose_substeps(const Model& model, State& state, TickLists& tick, IslandWork& work, Real dt) {
  const Settings& settings = model.scene.settings;
  const std::size_t count = state.bodies.size();
  tick.island_level.assign(count, static_cast<std::uint32_t>(settings.substeps));
  tick.resting_impacts.clear();
  work.first_level.clear();
  tick.shock_is_cut = false;
  tick.island_has_resting_impact.assign(count, 0);
  if (!settings.auto_substeps) return;
  if (work.all_are_held) {  // the needs stay as they are
    tick.load.assign(count, 0);
    tick.mass_factor.assign(count, 1);
    work.needed_level = tick.island_level;
  } else {
    estimate_needs(model, state, tick, work, dt);
    work.needed_level = tick.island_level;
    const auto least = static_cast<std::uint32_t>(settings.substeps);
    const auto most = static_cast<std::uint32_t>(settings.auto_substeps->substeps_max);
    for (std::uint32_t& level : tick.island_level) level = with_margin(level, least, most);
    change_levels(state, tick, work);
  }
  for (const std::uint32_t row : work.awake_rows) {
    const std::uint32_t root = tick.island[row];
    const std::uint32_t first = work.first_level.empty() ? 0 : work.first_level[root];
    work.needed_level[root] = std::max(work.needed_level[root], first);
    tick.island_level[root] = std::max(state.substeps[row].count, first);
  }
  tick.shock_work_left = shock_work_max;
  if (has_budget(model)) apply_budget(model, state, tick, work);
  find_resting_impacts(model, state, tick, work, dt);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
