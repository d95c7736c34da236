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

std::uint32_t iterations_of(const SolvedSet& solved) {
  std::uint32_t most = 1;
  for (const LightBody& light_body : solved.model.light_bodies) {
    const std::size_t row = solved.state.find_body(light_body.body);
    const bool is_in = row < solved.state.bodies.size() && solved.has_body(row);
    if (is_in && light_body.iterations > most) most = light_body.iterations;
  }
  return most;
}

}  // namespace

void solve_tgs_soft(const Model& model, State& state, TickLists& tick, SolverWork& work, Real dt) {
  MotionWorkspace& motion = work.motion;
  ContactBatches& contacts = work.contacts.batches;
  JointWorkspace& joints = work.joints;
  std::vector<MouseJoint>& mouse_joints = work.mouse_joints;
  prepare_bodies(model, state, tick, work.bodies);
  begin_motion(state, motion);
  if (!tick.has_solver_sets) put_all_into_one_set(model, state, work.bodies, tick);
  clear_contacts(contacts);
  const Integrator& scheme = integrator(model.scene.settings.integrator);
  const bool poses_stay = bodies_step_alone(model) && !tick.injected;  // between two drifts
  const bool some_are_free = find_constrained(model, state, tick, work.free_bodies);
  for (std::uint32_t i = 0; i < tick.solver_sets.size(); ++i) {
    const Real h = dt / static_cast<Real>(tick.solver_sets[i].substeps);  // s
    SolvedSet solved = enter_solver_set(model, state, tick, work.bodies, i, h);
    SolverSet& set = solved.set;
    set.joint_iterations = iterations_of(solved);
    prepare_mouse_joints(solved, mouse_joints);
    prepare_joints(solved, is_left_to_joints(solved, mouse_joints), joints);
    set.stiffness = soft_contacts(h);
    color_contacts(solved, !some_are_free && allows_blocks(solved), work.contacts);
    const bool in_blocks = work.contacts.colors.is_split();
    if (!in_blocks) prepare_contacts(solved, work.contacts.colors, contacts);
    scheme.begin(solved, motion, h);
    const bool all_are_free =
        state.joints.empty() && bodies_step_alone(model) && is_left_to_joints(solved, mouse_joints);
    if (all_are_free)
      integrate_freely(solved, motion);
    else if (some_are_free)
      integrate_free_bodies(solved, tick.set_rows, work.free_bodies, motion);
    if (joints.uses_wavefront) solve_wavefront(solved, joints, motion, state);
    if (in_blocks) solve_blocks(solved, work.contacts, motion, state);
    const int plain_substeps = all_are_free || joints.uses_wavefront || in_blocks ? 0 : set.substeps;
    for (int substep = 0; substep < plain_substeps; ++substep) {
      save_joint_velocities(solved, joints);
      save_impact_velocities(solved, work.impacts);
      scheme.predict(solved, motion, h);
      if (!tick.impacts.empty()) apply_impacts(solved, tick.impacts, motion.drift, work.impacts);
      if (set.has_resting_impacts) begin_resting_impacts(solved, tick.resting_impacts, contacts);
      warm_start_joints(solved, joints);
      warm_start_mouse_joints(mouse_joints, work.bodies);
      warm_start_contacts(solved, contacts);
      for (std::uint32_t iteration = 0; iteration < set.joint_iterations; ++iteration)
        solve_joints(solved, joints, Bias::on);
      solve_mouse_joints(mouse_joints, work.bodies);
      solve_contacts(solved, contacts,
                     poses_stay && (substep > 0 || tick.impacts.empty()) ? Poses::unmoved : Poses::moved);
      Real settled = set.has_resting_impacts ? settled_speed(solved) : Real(0);
      if (settled > 0) propagate_shock(solved, settled, tick.shock_work_left, contacts, work.shock);
      scheme.drift(solved, motion, h);
      if (!tick.impacts.empty()) finish_impacts(solved, work.impacts);
      solve_joints(solved, joints, Bias::off);
      relax_contacts(solved, contacts);
      if (set.has_resting_impacts && !(settled > 0)) settled = settled_speed(solved);
      if (settled > 0) {
        propagate_shock(solved, settled, tick.shock_work_left, contacts, work.shock);
        limit_impulses(set, contacts);
      }
      after_substep(solved, substep);
    }
    store_contacts(solved, contacts, state);  // forces, since the next tick may have another h
    store_mouse_joints(mouse_joints, state, h);
    store_joints(solved, joints, state);
  }
  store_bodies(work.bodies, tick, state);
  store_motion(motion, state);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
