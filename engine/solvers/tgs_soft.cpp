// Velocity solver with substeps, soft constraints, warm starting and a relax pass.
// SPDX-License-Identifier: MIT
// Source: Macklin et al., "Small Steps in Physics Simulation", 2019 (substeps); Catto, "Solver2D", 2024 (soft step,
// relax). Cost per tick: bodies 2 + 2n, contacts 2 + 3n, n = substep count.
#include "engine/contacts/contact_blocks.h"
#include "engine/impacts/landings.h"
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"
#include "engine/islands/groups.h"
#include "engine/joints/batched/weave.h"
#include "engine/model/bodies.h"
#include "engine/solvers/fault.h"
#include "engine/solvers/solver.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

namespace {

std::uint32_t sweeps_of(const Model& model, const State& state, const Scratch& scratch) {
  std::uint32_t most = 1;
  for (const Hub& hub : model.hubs) {
    const std::size_t row = state.find_body(hub.body);
    const bool is_in = row < state.bodies.size() && scratch.body_group[row] == scratch.group_index;
    if (is_in && hub.sweeps > most) most = hub.sweeps;
  }
  return most;
}

}  // namespace

void solve_tgs_soft(const Model& model, State& state, Scratch& scratch, Real dt) {
  prepare_bodies(model, state, scratch);
  if (!scratch.is_grouped) group_everything(model, state, scratch);
  clear_contacts(scratch);
  const Integrator& scheme = integrator(model.scene.settings.integrator);
  const bool poses_stay = bodies_step_alone(model) && !scratch.planted;  // from one drift to the next
  const bool some_are_loose = find_tied(model, state, scratch);
  for (SolveGroup& group : scratch.groups) {
    const Real h = dt / static_cast<Real>(group.substeps);  // s
    enter_group(state, scratch, group, h);
    group.joint_sweeps = sweeps_of(model, state, scratch);
    prepare_pulls(model, state, scratch, group);
    prepare_joints(model, state, scratch, group);
    group.stiffness = soft_contacts(h);
    color_contacts(scratch, group, !some_are_loose && allows_blocks(model, state, scratch, group));
    const bool in_blocks = scratch.kept.coloring.is_split;
    if (!in_blocks) prepare_contacts(model, state, scratch, group);
    scheme.begin(model, state, scratch, h);
    const bool flies = state.joints.empty() && bodies_step_alone(model) && is_left_to_joints(scratch, group);
    if (flies)
      fly(scratch, h, group.substeps);
    else if (some_are_loose)
      fly_loose(scratch, group);
    if (scratch.is_woven) solve_woven(state, scratch, group);
    if (in_blocks) solve_blocks(model, state, scratch, group);
    const int substeps_in_turn = flies || scratch.is_woven || in_blocks ? 0 : group.substeps;
    for (int substep = 0; substep < substeps_in_turn; ++substep) {
      note_joint_velocities(scratch);
      note_impact_velocities(state, scratch);
      scheme.predict(model, state, scratch, h);
      if (!scratch.impacts.empty()) apply_impacts(model, state, scratch, h);
      if (group.has_landings) begin_landings(scratch, group);
      warm_start_joints(scratch);
      warm_start_pulls(scratch);
      warm_start_contacts(scratch, group);
      for (std::uint32_t sweep = 0; sweep < group.joint_sweeps; ++sweep) solve_joints(scratch, h, Bias::on);
      solve_pulls(scratch);
      solve_contacts(scratch, group,
                     poses_stay && (substep > 0 || scratch.impacts.empty()) ? Poses::unmoved : Poses::moved);
      Real settled = group.has_landings ? settled_speed(state, scratch, group) : Real(0);
      if (settled > 0) pass_on_landings(model, state, scratch, group, settled);
      scheme.drift(model, state, scratch, h);
      if (!scratch.impacts.empty()) finish_impacts(scratch);
      solve_joints(scratch, h, Bias::off);
      relax_contacts(scratch, group);
      if (group.has_landings && !(settled > 0)) settled = settled_speed(state, scratch, group);
      if (settled > 0) {
        pass_on_landings(model, state, scratch, group, settled);
        limit_impulses(scratch, group);
      }
      after_substep(scratch, static_cast<std::size_t>(&group - scratch.groups.data()), substep);
    }
    store_contacts(scratch, group, state);  // forces, since the next tick may have another h
    store_pulls(scratch, state, h);
    store_joints(scratch, state, h);
  }
  store_bodies(scratch, state);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
