// Sequential impulses: iterations over all contacts, accumulated and warm started; velocities correct overlaps.
// SPDX-License-Identifier: MIT
// Source: Catto, "Iterative Dynamics with Temporal Coherence", GDC 2005 (projected Gauss-Seidel on accumulated
// impulses); Baumgarte, "Stabilization of Constraints and Integrals of Motion", 1972. The velocity that corrects
// overlap remains, since there is no relax pass. Cost per tick: bodies 4, contacts 2 + n, n = iterations.
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"
#include "engine/islands/solver_sets.h"
#include "engine/model/bodies.h"
#include "engine/solvers/joint_changes.h"
#include "engine/solvers/solver.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void solve_pgs(const Model& model, State& state, TickLists& tick, SolverWork& work, Real dt) {
  ContactBatches& contacts = work.contacts.batches;
  JointWorkspace& joints = work.joints;
  std::vector<GearJoint>& gears = work.gears;
  std::vector<MouseJoint>& mouse_joints = work.mouse_joints;
  prepare_bodies(model, state, tick, work.bodies);
  begin_motion(state, work.motion);
  if (!tick.has_solver_sets) put_all_into_one_set(model, state, work.bodies, tick);
  clear_contacts(contacts);
  const Integrator& scheme = integrator(model.scene.settings.integrator);
  for (std::uint32_t i = 0; i < tick.solver_sets.size(); ++i) {
    const SolvedSet solved = enter_solver_set(model, state, tick, work.bodies, i, dt);
    prepare_mouse_joints(solved, mouse_joints);
    plan_joints(solved, false, {}, joints);
    find_gear_torques(solved, joints.torques.of_gears);
    prepare_joints(solved, joints);
    prepare_gears(solved, gears);
    solved.set.stiffness = baumgarte_contacts(dt);
    prepare_joint_changes(solved, work.motion);
    color_contacts(solved, false, work.contacts);
    prepare_contacts(solved, work.contacts.colors, contacts);
    scheme.begin(solved, work.motion, dt);
    save_joint_velocities(solved, joints);
    begin_impacts(solved, tick.impacts, work.direct, work.impacts);
    scheme.predict(solved, work.motion, dt);
    apply_impacts(solved, tick.impacts, work.motion.drift, work.direct, work.impacts);
    warm_start_joints(solved, joints);
    warm_start_gears(solved, gears);
    warm_start_mouse_joints(mouse_joints, work.bodies);
    warm_start_contacts(solved, contacts);
    for (int iteration = 0; iteration < model.scene.settings.iterations; ++iteration) {
      solve_joints(solved, joints, Bias::on);
      solve_gears(solved, gears, Bias::on);
      solve_mouse_joints(mouse_joints, work.bodies);
      solve_contacts(solved, contacts);
    }
    find_joint_changes(solved, joints, gears, work.direct, work.motion);
    scheme.drift(solved, work.motion, dt);
    finish_impacts(solved, work.impacts);
    store_contacts(solved, contacts, state);
    store_mouse_joints(mouse_joints, state, dt);
    store_joints(solved, joints, state);
    store_gears(solved, gears, state);
  }
  store_bodies(model, work.bodies, tick, state);
  store_motion(work.motion, state);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
