// Islands at rest are held: they keep their poses and forces, and are not solved until something disturbs them.
// SPDX-License-Identifier: MIT
//
// A tower at rest needs its many substeps, since fewer would let it sag and lean. Held, it needs none. Bodies that
// something moves slowly on purpose are never held: springs, motors, conveyors, strong damping.
#include "engine/islands/islands.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr Real calm_least = 1;  // s: an island is held once all its bodies have been calm for so long
// A calm body moves in one second by at most this share of its allowed error. Rounding alone shakes a tower of 40 in
// f32 by a fifth of that.
constexpr Real calm_share = Real(0.2);
constexpr Real calm_fall = Real(1e-3);  // share of its gravity that moves no calm body: what falls faster is not held
constexpr Real stalled_factor = 10;     // a motor that wants to be so much faster than calm bodies is stalled
constexpr Real damping_most = 10;       // 1/s: under more, a body that is pushed may be slow for long

/// The values that the limits of all calm bodies share.
struct CalmLimits {
  Real target_error;
  Real gravity;  // m/s^2
};

CalmLimits calm_limits_of(const Model& model, const State& state) {
  return {static_cast<Real>(model.scene.settings.auto_substeps->target_error), length(state.world.gravity)};
}

/// The largest speed of a calm body, m/s. Without gravity a calm body does not move at all.
Real calm_speed(const CalmLimits& limits, const BodyModel& body) {
  const Real allowed = limits.target_error * body.size;
  const Real gravity = absolute(body.gravity_scale) * limits.gravity;
  return smaller(calm_share * allowed / calm_least, calm_fall * gravity * calm_least);
}

bool is_calm(const Model& model, const CalmLimits& limits, const BodyRow& body) {
  const BodyModel& constants = model.bodies[body.source];
  if (!constants.can_sleep || constants.linear_damping > damping_most || constants.angular_damping > damping_most)
    return false;
  // An upper bound of the speed of all points of the body.
  const Real speed = length(body.velocity) + magnitude(body.angular_velocity) * constants.extent;
  return speed <= calm_speed(limits, constants);
}

/// Calls use(row) for each body of a joint.
template <typename Use>
void for_each_row(const Model& model, const State& state, const JointRow& joint, Use use) {
  for_each_body(model, model.joints[joint.joint], [&](std::uint32_t id) { use(row_of(state, id)); });
}

/// Whether a joint may move its bodies slowly. A motor of high speed whose bodies are calm has its largest force and
/// does not move them.
bool drives_slowly(const Model& model, const State& state, const IslandWork& work, const JointRow& joint) {
  const JointModel& constants = model.joints[joint.joint];
  if (joint.body_a == no_reference || constants.spring.exists || constants.linear_spring.exists) return true;
  if (joint.motor_speed == 0 || !(joint.motor_force_max > 0)) return false;
  bool is_slow = false;
  for_each_row(model, state, joint, [&](std::uint32_t row) {
    if (!is_dynamic(work, row)) return;
    const BodyModel& body = model.bodies[state.bodies[row].source];
    const Real reach = constants.kind == JointKind::prismatic ? Real(1) : body.extent;
    is_slow |= absolute(joint.motor_speed) * reach <= stalled_factor * calm_speed(calm_limits_of(model, state), body);
  });
  return is_slow;
}

bool is_conveyor(const Model& model, const TickLists& tick, const ContactPair& pair) {
  return model.shapes[tick.proxies[pair.proxy_a].shape].tangent_speed != 0 ||
         model.shapes[tick.proxies[pair.proxy_b].shape].tangent_speed != 0;
}

/// Resets the time of bodies that a pointer, a joint, a spring, a conveyor, or a moving or new immovable body may move.
void disturb(const Model& model, State& state, const TickLists& tick, const IslandWork& work) {
  const auto stir = [&](std::uint32_t row) { state.loads[row].calm = 0; };
  const auto is_moved_by = [&](std::uint32_t row) { return disturbs(state, tick, work, row); };
  for (const PointerRow& pointer : state.pointers) stir(row_of(state, pointer.body));
  for (const JointRow& joint : state.joints) {
    bool stirs = drives_slowly(model, state, work, joint);
    for_each_row(model, state, joint, [&](std::uint32_t row) { stirs |= is_moved_by(row); });
    if (stirs) for_each_row(model, state, joint, stir);
  }
  for (const SpringForce& spring : model.springs)
    for (const std::uint32_t id : {spring.body, spring.other})
      if (const std::size_t row = state.find_body(id); row < state.bodies.size()) state.loads[row].calm = 0;
  for (const ContactPair& pair : tick.contact_pairs) {
    if (!is_moved_by(pair.body_a) && !is_moved_by(pair.body_b) &&
        !(model.has_surfaces && is_conveyor(model, tick, pair)))
      continue;
    stir(pair.body_a);
    stir(pair.body_b);
  }
}

/// Finds the islands, at their first rows, that a body which is not dynamic carries.
void find_carried(const State& state, const TickLists& tick, IslandWork& work) {
  std::vector<std::uint8_t>& carried = work.island_carried;
  carried.assign(state.bodies.size(), 0);
  const auto meet = [&](std::uint32_t a, std::uint32_t b) {
    if (is_dynamic(work, a) != is_dynamic(work, b)) carried[tick.island[is_dynamic(work, a) ? a : b]] = 1;
  };
  for (std::size_t i = 0; i < tick.contact_pairs.size(); ++i) {
    const ContactRow& contact = state.contacts[i];
    if (contact.normal_force[0] > 0 || contact.normal_force[1] > 0)
      meet(tick.contact_pairs[i].body_a, tick.contact_pairs[i].body_b);
  }
  for (const JointRow& joint : state.joints)
    if (joint.body_a != no_reference) meet(row_of(state, joint.body_a), row_of(state, joint.body_b));
}

}  // namespace

bool holds_islands(const Model& model) {
  const Settings& settings = model.scene.settings;
  return settings.substep_loads == SubstepLoads::measured && settings.auto_substeps && !settings.sleep;
}

void hold_islands(const Model& model, State& state, TickLists& tick, IslandWork& work, Real dt) {
  const std::size_t count = state.bodies.size();
  const CalmLimits limits = calm_limits_of(model, state);
  for (std::uint32_t row = 0; row < count; ++row) {
    Real& calm = state.loads[row].calm;
    if (!is_dynamic(work, row) || !is_calm(model, limits, state.bodies[row]))
      calm = 0;
    else if (calm < calm_least)
      calm += dt;
  }
  disturb(model, state, tick, work);
  work.all_are_held = false;
  bool some_are_calm = false;
  for (std::uint32_t row = 0; row < count; ++row)
    some_are_calm |= is_dynamic(work, row) && !(state.loads[row].calm < calm_least);
  if (!some_are_calm) return;
  find_carried(state, tick, work);
  for (std::uint32_t row = 0; row < count; ++row) work.island_awake[row] = work.island_carried[row] != 0 ? 0 : 1;
  for (std::uint32_t row = 0; row < count; ++row)
    if (is_dynamic(work, row) && state.loads[row].calm < calm_least) work.island_awake[tick.island[row]] = 1;
  work.all_are_held = true;
  for (std::uint32_t row = 0; row < count; ++row) {
    if (!is_dynamic(work, row)) continue;
    if (work.island_awake[tick.island[row]] != 0) {
      work.all_are_held = false;
      continue;
    }
    state.bodies[row].velocity = {0, 0};
    state.bodies[row].angular_velocity = 0;
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
