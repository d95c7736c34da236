// The choice of a strategy for the substeps of a set, and the strategies besides the plain one.
// SPDX-License-Identifier: MIT
#include "engine/solvers/substep_strategies.h"

#include "engine/contacts/contact_blocks.h"
#include "engine/integrators/flow.h"
#include "engine/joints/batched/wavefront.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// Nothing acts between the bodies: each takes its steps independently.
void integrate_alone(SolvedSet& solved, TickLists&, SolverWork& work, State&) {
  integrate_freely(solved, work.motion);
}

/// Bodies without contacts take their steps independently; solve_in_turn handles the others.
void solve_beside_free(SolvedSet& solved, TickLists& tick, SolverWork& work, State& state) {
  integrate_free_bodies(solved, tick.set_rows, work.free_bodies, work.motion);
  solve_in_turn(solved, tick, work, state);
}

/// Only joints act: passes follow each other through the levels of joints.
void solve_by_wavefront(SolvedSet& solved, TickLists&, SolverWork& work, State& state) {
  solve_wavefront(solved, work.joints, work.motion, state);
}

/// Only contacts act, in many islands: a few islands at a time.
void solve_by_blocks(SolvedSet& solved, TickLists&, SolverWork& work, State& state) {
  solve_blocks(solved, work.contacts, work.motion, state);
}

std::uint32_t joint_iterations_of(const SolvedSet& solved) {
  std::uint32_t most = 1;
  for (const LightBody& light_body : solved.model.light_bodies) {
    const std::size_t row = solved.state.find_body(light_body.body);
    const bool is_in = row < solved.state.bodies.size() && solved.has_body(row);
    if (is_in && light_body.iterations > most) most = light_body.iterations;
  }
  return most;
}

}  // namespace

SubstepStrategy plan_substeps(const SolvedSet& solved, bool some_are_free, SolverWork& work) {
  const bool only_joints = is_left_to_joints(solved, work.mouse_joints) && solved.state.gears.empty();
  solved.set.joint_iterations = joint_iterations_of(solved);
  plan_joints(solved, only_joints, work.direct.solved_joints(), work.joints);
  color_contacts(solved, !some_are_free && solved.tick.deep_counts.empty() && allows_blocks(solved), work.contacts);
  if (only_joints && solved.state.joints.empty() && bodies_step_alone(solved.model)) return integrate_alone;
  if (work.joints.uses_wavefront) return solve_by_wavefront;
  if (work.contacts.colors.is_split()) return solve_by_blocks;
  return some_are_free ? solve_beside_free : solve_in_turn;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
