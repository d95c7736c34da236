// Detection of impacts on bodies at rest.
// SPDX-License-Identifier: MIT
#include "engine/islands/islands.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// Excludes islands with joints from shock propagation: the passes of each substep solve them. Joints would keep the
/// impulses of an impact as forces, which would throw the joined bodies.
void leave_out_joined(const State& state, TickLists& tick) {
  for (const JointRow& joint : state.joints)
    if (joint.body_a != no_reference)
      for (const std::uint32_t id : {joint.body_a, joint.body_b})
        tick.island_has_resting_impact[tick.island[row_of(state, id)]] = 0;
}

/// Whether a body moves by less than `allowed` in a substep of length `h`.
bool is_slow(const Model& model, const BodyRow& body, Real h, Real allowed) {
  const Real speed = length(body.velocity) + absolute(body.angular_velocity) * model.bodies[body.source].extent;
  return speed * h <= allowed;
}

/// Whether a body of the pair is supported and slow.
bool hits_resting_body(const Model& model, const State& state, const TickLists& tick, const ContactPair& pair, Real h,
                       Real allowed) {
  for (const std::uint32_t row : {pair.body_a, pair.body_b})
    if (tick.load[row] > 0 && is_slow(model, state.bodies[row], h, allowed)) return true;
  return false;
}

/// Whether a body may hit others: a dynamic body, or a kinematic one that moves.
bool may_hit(const State& state, const IslandWork& work, std::uint32_t row) {
  return is_dynamic(work, row) || (work.body_types[row] == BodyType::kinematic_body && is_moving(state.bodies[row]));
}

}  // namespace

void find_resting_impacts(const Model& model, const State& state, TickLists& tick, const IslandWork& work, Real dt) {
  const Real target = static_cast<Real>(model.scene.settings.auto_substeps->target_error);
  for (const std::uint32_t contact : work.awake_contacts) {
    const ContactPair& pair = tick.contact_pairs[contact];
    if (!(tick.load[pair.body_a] > 0 || tick.load[pair.body_b] > 0)) continue;
    if (!may_hit(state, work, pair.body_a) || !may_hit(state, work, pair.body_b)) continue;
    const std::uint32_t body = is_dynamic(work, pair.body_a) ? pair.body_a : pair.body_b;
    const bool both_move = is_dynamic(work, pair.body_a) && is_dynamic(work, pair.body_b);
    const std::uint32_t root = tick.island[body];
    const Real closing = closing_speed(pair, state.bodies[pair.body_a], state.bodies[pair.body_b]);
    const Real h = dt / static_cast<Real>(tick.island_level[root]);
    // Nothing slows down a kinematic body. What it hits goes on to be pushed for the whole tick.
    const Real parts = both_move ? Real(1) : static_cast<Real>(tick.island_level[root]);
    const Real allowed = target * pair.size / parts;
    const Real least = resting_impact_share * allowed;
    if (!(closing * h > least)) continue;
    const bool must_rest = has_budget(model) || !both_move;
    if (must_rest && !hits_resting_body(model, state, tick, pair, h, least)) continue;
    tick.resting_impacts.push_back({contact, body, closing, allowed});
    tick.island_has_resting_impact[root] = 1;
  }
  leave_out_joined(state, tick);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
