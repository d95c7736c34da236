// Velocity solver with substeps, soft constraints, warm starting and a relax pass.
// SPDX-License-Identifier: MIT
// Source: Macklin et al., "Small Steps in Physics Simulation", 2019 (substeps); Catto, "Solver2D", 2024 (soft step,
// relax). Cost per tick: bodies 2 + 2n, contacts 2 + 3n, n = substep count.
#include "engine/contacts/contact_blocks.h"
#include "engine/impacts/shock_propagation.h"
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"
#include "engine/islands/solver_sets.h"
#include "engine/joints/batched/wavefront.h"
#include "engine/model/bodies.h"
#include "engine/solvers/fault.h"
#include "engine/solvers/solver.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

namespace {

std::uint32_t iterations_of(const Model& model, const State& state, const Scratch& scratch) {
  std::uint32_t most = 1;
  for (const LightBody& light_body : model.light_bodies) {
    const std::size_t row = state.find_body(light_body.body);
    const bool is_in = row < state.bodies.size() && scratch.body_solver_set[row] == scratch.set_index;
    if (is_in && light_body.iterations > most) most = light_body.iterations;
  }
  return most;
}

}  // namespace

void solve_tgs_soft(const Model& model, State& state, Scratch& scratch, Real dt) {
  prepare_bodies(model, state, scratch);
  if (!scratch.has_solver_sets) put_all_into_one_set(model, state, scratch);
  clear_contacts(scratch);
  const Integrator& scheme = integrator(model.scene.settings.integrator);
  const bool poses_stay = bodies_step_alone(model) && !scratch.injected;  // between two drifts
  const bool some_are_free = find_constrained(model, state, scratch);
  for (SolverSet& set : scratch.solver_sets) {
    const Real h = dt / static_cast<Real>(set.substeps);  // s
    enter_solver_set(state, scratch, set, h);
    set.joint_iterations = iterations_of(model, state, scratch);
    prepare_mouse_joints(model, state, scratch, set);
    prepare_joints(model, state, scratch, set);
    set.stiffness = soft_contacts(h);
    color_contacts(scratch, set, !some_are_free && allows_blocks(model, state, scratch, set));
    const bool in_blocks = scratch.caches.colors.is_split();
    if (!in_blocks) prepare_contacts(model, state, scratch, set);
    scheme.begin(model, state, scratch, h);
    const bool all_are_free = state.joints.empty() && bodies_step_alone(model) && is_left_to_joints(scratch, set);
    if (all_are_free)
      integrate_freely(scratch, h, set.substeps);
    else if (some_are_free)
      integrate_free_bodies(scratch, set);
    if (scratch.uses_wavefront) solve_wavefront(state, scratch, set);
    if (in_blocks) solve_blocks(model, state, scratch, set);
    const int plain_substeps = all_are_free || scratch.uses_wavefront || in_blocks ? 0 : set.substeps;
    for (int substep = 0; substep < plain_substeps; ++substep) {
      save_joint_velocities(scratch);
      save_impact_velocities(state, scratch);
      scheme.predict(model, state, scratch, h);
      if (!scratch.impacts.empty()) apply_impacts(model, state, scratch, h);
      if (set.has_resting_impacts) begin_resting_impacts(scratch, set);
      warm_start_joints(scratch);
      warm_start_mouse_joints(scratch);
      warm_start_contacts(scratch, set);
      for (std::uint32_t iteration = 0; iteration < set.joint_iterations; ++iteration)
        solve_joints(scratch, h, Bias::on);
      solve_mouse_joints(scratch);
      solve_contacts(scratch, set,
                     poses_stay && (substep > 0 || scratch.impacts.empty()) ? Poses::unmoved : Poses::moved);
      Real settled = set.has_resting_impacts ? settled_speed(state, scratch, set) : Real(0);
      if (settled > 0) propagate_shock(model, state, scratch, set, settled);
      scheme.drift(model, state, scratch, h);
      if (!scratch.impacts.empty()) finish_impacts(scratch);
      solve_joints(scratch, h, Bias::off);
      relax_contacts(scratch, set);
      if (set.has_resting_impacts && !(settled > 0)) settled = settled_speed(state, scratch, set);
      if (settled > 0) {
        propagate_shock(model, state, scratch, set, settled);
        limit_impulses(scratch, set);
      }
      after_substep(scratch, static_cast<std::size_t>(&set - scratch.solver_sets.data()), substep);
    }
    store_contacts(scratch, set, state);  // forces, since the next tick may have another h
    store_mouse_joints(scratch, state, h);
    store_joints(scratch, state, h);
  }
  store_bodies(scratch, state);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
