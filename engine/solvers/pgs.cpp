// Sequential impulses: iterations over all contacts, accumulated and warm started, overlap taken back by velocity.
// SPDX-License-Identifier: MIT
// Source: Catto, "Iterative Dynamics with Temporal Coherence", GDC 2005 (projected Gauss-Seidel on accumulated
// impulses); Baumgarte, "Stabilization of Constraints and Integrals of Motion", 1972. The velocity that takes overlap
// back stays: the price of having no relax pass. Cost per tick: bodies 4, contacts 2 + n, n = iterations.
#include "engine/integrators/integrator.h"
#include "engine/islands/solver_sets.h"
#include "engine/model/bodies.h"
#include "engine/solvers/solver.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void solve_pgs(const Model& model, State& state, Scratch& scratch, Real dt) {
  prepare_bodies(model, state, scratch);
  if (!scratch.has_solver_sets) put_all_into_one_set(model, state, scratch);
  clear_contacts(scratch);
  const Integrator& scheme = integrator(model.scene.settings.integrator);
  for (SolverSet& set : scratch.solver_sets) {
    enter_solver_set(state, scratch, set, dt);
    prepare_mouse_joints(model, state, scratch, set);
    prepare_joints(model, state, scratch, set);
    set.stiffness = baumgarte_contacts(dt);
    color_contacts(scratch, set, false);
    prepare_contacts(model, state, scratch, set);
    scheme.begin(model, state, scratch, dt);
    save_joint_velocities(scratch);
    save_impact_velocities(state, scratch);
    scheme.predict(model, state, scratch, dt);
    if (!scratch.impacts.empty()) apply_impacts(model, state, scratch, dt);
    warm_start_joints(scratch);
    warm_start_mouse_joints(scratch);
    warm_start_contacts(scratch, set);
    for (int iteration = 0; iteration < model.scene.settings.iterations; ++iteration) {
      solve_joints(scratch, dt, Bias::on);
      solve_mouse_joints(scratch);
      solve_contacts(scratch, set, iteration > 0 ? Poses::unmoved : Poses::moved);
    }
    scheme.drift(model, state, scratch, dt);
    if (!scratch.impacts.empty()) finish_impacts(scratch);
    store_contacts(scratch, set, state);
    store_mouse_joints(scratch, state, dt);
    store_joints(scratch, state, dt);
  }
  store_bodies(scratch, state);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
