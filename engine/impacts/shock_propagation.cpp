// Detection of impacts on bodies at rest. Rigid passes and steps of the active set, until the shock has propagated.
// SPDX-License-Identifier: MIT
// Source: Moreau, "Unilateral Contact and Dry Friction in Finite Freedom Dynamics", 1988 (an impact is solved for
// velocities alone, positions held).
#include "engine/impacts/shock_propagation.h"

#include <algorithm>

#include "engine/impacts/impulse_step.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr Real settled_share = Real(1e-5);  // of the allowed way: a smaller change of speed is none
constexpr int passes_per_check = 8;
// Limits of the work: in a large pile a body would wait long for neighbours far away.
constexpr std::uint32_t check_count_max = 2048;
constexpr std::uint32_t contacts_solved_max = 1u << 18;
// A check takes as much as so many contacts beside those that it solves.
constexpr std::uint32_t work_beside = 64;

Real closing_now(const Scratch& scratch, const RestingImpact& impact) {
  const ContactPair& pair = scratch.contact_pairs[impact.contact];
  return closing_speed(pair, scratch.bodies[pair.body_a], scratch.bodies[pair.body_b]);
}

bool is_in(const Scratch& scratch, const RestingImpact& impact) {
  return scratch.body_solver_set[scratch.contact_pairs[impact.contact].body_a] == scratch.set_index;
}

}  // namespace

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
    if (!(stopped > own) || !(stopped * set.h > resting_impact_share * impact.allowed)) continue;
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
