// Detection of impacts on bodies at rest.
// SPDX-License-Identifier: MIT
#include "engine/islands/islands.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

// Limit of the contacts solved for resting impacts in a tick. Beyond the limit, each substep gets one check. A pile
// that never settles then takes hundredths of a second.
constexpr std::uint32_t work_in_tick_max = 1u << 21;

std::uint32_t island_of(const TickLists& tick, std::uint32_t row) {
  while (tick.island_parent[row] != row) row = tick.island_parent[row];
  return row;
}

/// Excludes islands with joints from shock propagation: the passes of each substep solve them. Joints would keep the
/// impulses of an impact as forces, which would throw the joined bodies.
void leave_out_joined(const State& state, TickLists& tick) {
  for (const JointRow& joint : state.joints)
    if (joint.body_a != no_reference)
      for (const std::uint32_t id : {joint.body_a, joint.body_b})
        tick.island_has_resting_impact[island_of(tick, static_cast<std::uint32_t>(state.find_body(id)))] = 0;
}

}  // namespace

void find_resting_impacts(const Model& model, const State& state, TickLists& tick, Real dt) {
  tick.shock_work_left = work_in_tick_max;
  const Real target = static_cast<Real>(model.scene.settings.auto_substeps->target_error);
  for (std::uint32_t contact = 0; contact < tick.contact_pairs.size(); ++contact) {
    const ContactPair& pair = tick.contact_pairs[contact];
    const bool a_moves = model.bodies[state.bodies[pair.body_a].source].type == BodyType::dynamic_body;
    const bool b_moves = model.bodies[state.bodies[pair.body_b].source].type == BodyType::dynamic_body;
    if (!a_moves || !b_moves || !(tick.load[pair.body_a] > 0 || tick.load[pair.body_b] > 0)) continue;
    const std::uint32_t root = island_of(tick, pair.body_a);
    const Real closing = closing_speed(pair, state.bodies[pair.body_a], state.bodies[pair.body_b]);
    const Real h = dt / static_cast<Real>(tick.island_level[root]);
    const Real allowed = target * pair.size;
    if (!(closing * h > resting_impact_share * allowed)) continue;
    tick.resting_impacts.push_back({contact, closing, allowed});
    tick.island_has_resting_impact[root] = 1;
  }
  leave_out_joined(state, tick);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
