// Detection of impacts on bodies at rest. Rigid passes and steps of the active set, until the shock has propagated.
// SPDX-License-Identifier: MIT
// Source: Moreau, "Unilateral Contact and Dry Friction in Finite Freedom Dynamics", 1988 (an impact is solved for
// velocities alone, positions held).
#include "engine/impacts/shock_propagation.h"

#include <algorithm>

#include "engine/impacts/impulse_step.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr Real settled_share = Real(1e-5);  // relative to the allowed motion: smaller changes of speed do not count
// Likewise with a budget, relative to the allowed motion per tick.
constexpr Real settled_share_of_budget = Real(1e-2);
constexpr int passes_per_check = 8;
// Limits of the work. In a large pile, the propagation to far neighbours would take long.
constexpr std::uint32_t check_count_max = 2048;
constexpr std::uint32_t contacts_solved_max = 1u << 18;
// A check costs as much as solving this many more contacts.
constexpr std::uint32_t work_beside = 64;
constexpr std::uint64_t work_beside_pass = 64;  // likewise, of a pass within a budget

Real closing_now(const SolvedSet& solved, const RestingImpact& impact) {
  const ContactPair& pair = solved.tick.contact_pairs[impact.contact];
  return closing_speed(pair, solved.bodies.records[pair.body_a], solved.bodies.records[pair.body_b]);
}

bool is_in(const SolvedSet& solved, const RestingImpact& impact) {
  return solved.has_body(impact.body);
}

}  // namespace

void begin_resting_impacts(const SolvedSet& solved, std::vector<RestingImpact>& impacts, ContactBatches& contacts) {
  if (!solved.set.has_resting_impacts) return;
  for (RestingImpact& impact : impacts)
    if (is_in(solved, impact)) impact.closing = closing_now(solved, impact);
  save_impulses(solved.set, contacts);
}

Real settled_speed_of_impacts(const SolvedSet& solved) {
  const Real h = solved.set.h;
  bool any = false;
  Real settled = 0;  // m/s
  const Real own = 4 * h * length(solved.state.world.gravity);
  for (const RestingImpact& impact : solved.tick.resting_impacts) {
    if (!is_in(solved, impact)) continue;
    const Real stopped = impact.closing - closing_now(solved, impact);
    if (!(stopped > own) || !(stopped * h > resting_impact_share * impact.allowed)) continue;
    const Real small = has_budget(solved.model)
                           ? settled_share_of_budget * impact.allowed / (h * static_cast<Real>(solved.set.substeps))
                           : settled_share * impact.allowed / h;
    settled = any ? smaller(settled, small) : small;
    any = true;
  }
  return settled;
}

namespace {

void save_velocities(const SolvedSet& solved, std::vector<Twist>& before) {
  before.resize(solved.bodies.records.size());
  for (const std::uint32_t row : solved.rows)
    before[row] = {solved.bodies.records[row].velocity, solved.bodies.records[row].angular_velocity};
}

/// The largest change of speed of a point of a body.
Real largest_change(const SolvedSet& solved, const std::vector<Twist>& before) {
  Real most = 0;
  for (const std::uint32_t row : solved.rows) {
    const MovingBody& body = solved.bodies.records[row];
    const Real extent = solved.model.bodies[solved.state.bodies[row].source].extent;
    most = larger(most, length(body.velocity - before[row].linear) +
                            absolute(body.angular_velocity - before[row].angular) * extent);
  }
  return most;
}

void propagate_without_budget(const SolvedSet& solved, Real settled, std::uint64_t& work_left, ContactBatches& contacts,
                              ShockWorkspace& work) {
  const auto contact_count = static_cast<std::uint32_t>(solved.contacts().size());
  const std::uint64_t bounded = 1 + contacts_solved_max / (passes_per_check * (contact_count + 1));
  const std::uint64_t work_of_check = passes_per_check * (contact_count + work_beside);
  const std::uint64_t check_count = std::min({bounded, std::uint64_t{check_count_max}, 1 + work_left / work_of_check});
  for (std::uint64_t check = 0; check < check_count; ++check) {
    work_left -= std::min(work_left, work_of_check);
    save_velocities(solved, work.velocities);
    for (int pass = 0; pass < passes_per_check; ++pass) relax_contacts(solved, contacts);
    step_active_contacts(solved, contacts, no_step_limit, work.step);
    if (!(largest_change(solved, work.velocities) > settled)) break;
  }
}

/// Passes, and steps that take no more work than the passes before them. False: the budget ended before the shock had
/// settled.
bool propagate_within_budget(const SolvedSet& solved, Real settled, std::uint64_t& work_left, ContactBatches& contacts,
                             ShockWorkspace& work) {
  const std::uint64_t work_of_check = passes_per_check * (solved.contacts().size() + work_beside_pass);
  std::uint64_t since_step = 0;
  std::uint64_t needed = 0;  // for a step, as far as known
  for (;;) {
    if (work_left < work_of_check) return false;
    work_left -= work_of_check;
    since_step += work_of_check;
    save_velocities(solved, work.velocities);
    for (int pass = 0; pass < passes_per_check; ++pass) relax_contacts(solved, contacts);
    if (since_step >= needed) {
      const StepWork step = step_active_contacts(solved, contacts, std::min(since_step, work_left), work.step);
      work_left -= std::min(work_left, step.done);
      needed = step.needed;
      if (step.is_done) since_step = 0;
    }
    if (!(largest_change(solved, work.velocities) > settled)) return true;
  }
}

}  // namespace

void propagate_shock(const SolvedSet& solved, Real settled, TickLists& tick, ContactBatches& contacts,
                     ShockWorkspace& work) {
  if (!(settled > 0)) return;
  if (!has_budget(solved.model)) {
    propagate_without_budget(solved, settled, tick.shock_work_left, contacts, work);
  } else if (!propagate_within_budget(solved, settled, tick.shock_work_left, contacts, work)) {
    tick.shock_is_cut = true;
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
