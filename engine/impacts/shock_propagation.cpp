// Detection of impacts on bodies at rest. Rigid passes and steps of the active set, until the shock has propagated.
// SPDX-License-Identifier: MIT
// Source: Moreau, "Unilateral Contact and Dry Friction in Finite Freedom Dynamics", 1988 (an impact is solved for
// velocities alone, positions held).
#include "engine/impacts/shock_propagation.h"

#include <algorithm>

#include "engine/impacts/impulse_step.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr Real least_share = Real(0.05);    // of the allowed motion: less motion in a substep is no impact
constexpr Real settled_share = Real(1e-5);  // of the same, for a change of speed
constexpr int passes_per_check = 8;
// Limits of the work: in a large pile a body would wait long for neighbours far away.
constexpr std::uint32_t check_count_max = 2048;
constexpr std::uint32_t contacts_solved_max = 1u << 18;
// Limit in a tick; each check counts as the work of some contacts. Beyond it a substep gets one check. Even an impact
// that never converges then takes hundredths of a second.
constexpr std::uint32_t work_in_tick_max = 1u << 21;
constexpr std::uint32_t work_beside = 64;

/// The closing speed of a pair, m/s: that of its faster point.
template <typename Velocities>
Real closing_speed(const ContactPair& pair, const Velocities& a, const Velocities& b) {
  Real closing = 0;
  for (int i = 0; i < pair.manifold.point_count; ++i) {
    const ManifoldPoint& point = pair.manifold.points[i];
    const Vec2 velocity = (b.velocity + cross(b.angular_velocity, point.anchor_b)) -
                          (a.velocity + cross(a.angular_velocity, point.anchor_a));
    closing = larger(closing, -dot(velocity, pair.manifold.normal));
  }
  return closing;
}

Real closing_now(const Scratch& scratch, const RestingImpact& impact) {
  const ContactPair& pair = scratch.contact_pairs[impact.contact];
  return closing_speed(pair, scratch.bodies[pair.body_a], scratch.bodies[pair.body_b]);
}

bool is_in(const Scratch& scratch, const RestingImpact& impact) {
  return scratch.body_solver_set[scratch.contact_pairs[impact.contact].body_a] == scratch.set_index;
}

std::uint32_t island_of(const Scratch& scratch, std::uint32_t row) {
  while (scratch.island_parent[row] != row) row = scratch.island_parent[row];
  return row;
}

/// Joints would keep the impulses of an impact as forces, which throw the joined bodies. Islands with joints are left
/// to the passes of each substep.
void leave_out_joined(const State& state, Scratch& scratch) {
  for (const JointRow& joint : state.joints)
    if (joint.body_a != no_reference)
      for (const std::uint32_t id : {joint.body_a, joint.body_b})
        scratch.island_has_resting_impact[island_of(scratch, static_cast<std::uint32_t>(state.find_body(id)))] = 0;
}

}  // namespace

void find_resting_impacts(const Model& model, const State& state, Scratch& scratch, Real dt) {
  scratch.shock_work_left = work_in_tick_max;
  const Real target = static_cast<Real>(model.scene.settings.auto_substeps->target_error);
  for (std::uint32_t contact = 0; contact < scratch.contact_pairs.size(); ++contact) {
    const ContactPair& pair = scratch.contact_pairs[contact];
    const bool a_moves = model.bodies[state.bodies[pair.body_a].source].type == BodyType::dynamic_body;
    const bool b_moves = model.bodies[state.bodies[pair.body_b].source].type == BodyType::dynamic_body;
    if (!a_moves || !b_moves || !(scratch.load[pair.body_a] > 0 || scratch.load[pair.body_b] > 0)) continue;
    const std::uint32_t root = island_of(scratch, pair.body_a);
    const Real closing = closing_speed(pair, state.bodies[pair.body_a], state.bodies[pair.body_b]);
    const Real h = dt / static_cast<Real>(scratch.island_level[root]);
    const Real allowed = target * pair.size;
    if (!(closing * h > least_share * allowed)) continue;
    scratch.resting_impacts.push_back({contact, closing, allowed});
    scratch.island_has_resting_impact[root] = 1;
  }
  leave_out_joined(state, scratch);
}

void begin_resting_impacts(Scratch& scratch, const SolverSet& set) {
  for (RestingImpact& impact : scratch.resting_impacts)
    if (is_in(scratch, impact)) impact.closing = closing_now(scratch, impact);
  save_impulses(scratch, set);
}

Real settled_speed(const State& state, const Scratch& scratch, const SolverSet& set) {
  bool any = false;
  Real settled = 0;  // m/s
  const Real own = 4 * set.h * length(state.world.gravity);
  for (const RestingImpact& impact : scratch.resting_impacts) {
    if (!is_in(scratch, impact)) continue;
    const Real stopped = impact.closing - closing_now(scratch, impact);
    if (!(stopped > own) || !(stopped * set.h > least_share * impact.allowed)) continue;
    const Real small = settled_share * impact.allowed / set.h;
    settled = any ? smaller(settled, small) : small;
    any = true;
  }
  return settled;
}

void propagate_shock(const Model& model, const State& state, Scratch& scratch, const SolverSet& set, Real settled) {
  std::vector<Twist>& before = scratch.shock_velocities;
  before.resize(scratch.bodies.size());
  const std::uint32_t contact_count = set.contact_end - set.first_contact;
  const std::uint32_t bounded = 1 + contacts_solved_max / (passes_per_check * (contact_count + 1));
  const std::uint32_t work_of_check = passes_per_check * (contact_count + work_beside);
  const std::uint32_t check_count = std::min({bounded, check_count_max, 1 + scratch.shock_work_left / work_of_check});
  for (std::uint32_t check = 0; check < check_count; ++check) {
    scratch.shock_work_left -= std::min(scratch.shock_work_left, work_of_check);
    for (const std::uint32_t row : scratch.moving_rows)
      before[row] = {scratch.bodies[row].velocity, scratch.bodies[row].angular_velocity};
    for (int pass = 0; pass < passes_per_check; ++pass) relax_contacts(scratch, set);
    step_active_contacts(scratch, set);
    Real most = 0;
    for (const std::uint32_t row : scratch.moving_rows) {
      const MovingBody& body = scratch.bodies[row];
      const Real extent = model.bodies[state.bodies[row].source].extent;
      most = larger(most, length(body.velocity - before[row].linear) +
                              absolute(body.angular_velocity - before[row].angular) * extent);
    }
    if (!(most > settled)) break;
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
