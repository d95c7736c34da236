// Velocity solver with substeps, soft constraints, warm starting and a relax pass.
// SPDX-License-Identifier: MIT
// Source: Macklin et al., "Small Steps in Physics Simulation", 2019 (substeps); Catto, "Solver2D", 2024 (soft step,
// relax). Cost per tick: bodies 2 + 2n, contacts 2 + 3n, n = substep count.
#include "engine/contacts/crowds.h"
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"
#include "engine/islands/solver_sets.h"
#include "engine/islands/substep_budget.h"
#include "engine/solvers/fault.h"
#include "engine/solvers/joint_changes.h"
#include "engine/solvers/solver.h"
#include "engine/solvers/substep_strategies.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// The rigid passes of a shock take back what pushes overlaps apart. Where something overlaps by more than this share
/// of the smaller shape, contacts push once more before the move.
constexpr Real pushed_overlap_share = Real(0.02);

bool has_deep_overlap(const SolvedSet& solved) {
  for (const std::uint32_t contact : solved.contacts())
    if (overlaps_by(solved.tick.contact_pairs[contact], pushed_overlap_share)) return true;
  return false;
}

/// Iterative joints and gears take part in the last turns alone: more passes throw bodies on gears with limits.
constexpr int joint_turn_max = 2;

bool takes_joints(const DirectWorkspace& direct, int turn) {
  return turn + joint_turn_max >= direct.turn_count;
}

}  // namespace

void solve_in_turn(SolvedSet& solved, TickLists& tick, SolverWork& work, State& state) {
  auto& [bodies, motion, free_bodies, contact_work, joints, direct, gears, mouse_joints, impacts, shock,
         jointed_impacts] = work;
  const Integrator& scheme = integrator(solved.model.scene.settings.integrator);
  const SolverSet& set = solved.set;
  ContactBatches& contacts = contact_work.batches;
  prepare_contacts(solved, contact_work.colors, contacts);
  prepare_jointed_contacts(solved, direct, contacts, jointed_impacts);
  find_jointed_contacts(solved, find_jointed_bodies(solved, joints), contacts);
  const bool has_impacts = !tick.impacts.empty();
  const bool has_joint_changes = !motion.drift.joint_changes.empty();
  for (int substep = 0; substep < set.substeps; ++substep) {
    stop_jointed_contacts(solved, direct, contacts, jointed_impacts);
    save_joint_velocities(solved, joints);
    begin_direct_substep(solved, direct);
    if (has_impacts) begin_impacts(solved, tick.impacts, direct, impacts);
    scheme.predict(solved, motion, set.h);  // v += h a
    if (has_impacts) apply_impacts(solved, tick.impacts, motion.drift, direct, impacts);
    begin_resting_impacts(solved, tick.resting_impacts, contacts);
    warm_start_joints(solved, joints);
    start_direct(solved, motion, direct);
    warm_start_gears(solved, gears);
    warm_start_mouse_joints(mouse_joints, bodies);
    warm_start_contacts(solved, contacts);
    save_before_push(contacts);
    for (int turn = 0; turn < direct.turn_count; ++turn) {  // one, unless something acts on bodies of direct joints
      if (direct.turn_count > 1) solve_direct(solved, motion, direct);
      const std::uint32_t iterations = takes_joints(direct, turn) ? set.joint_iterations : 0;
      for (std::uint32_t i = 0; i < iterations; ++i) {
        solve_joints(solved, joints, Bias::on);
        solve_gears(solved, gears, Bias::on);
      }
      solve_mouse_joints(mouse_joints, bodies);
      solve_contacts(solved, contacts);
    }
    limit_push_friction(solved, contacts);
    Real settled = settled_speed(solved);  // 0 unless an impact has hit bodies at rest
    propagate_shock(solved, settled, tick, contacts, shock);
    if (settled > 0 && has_deep_overlap(solved)) solve_contacts(solved, contacts);
    if (has_joint_changes) find_joint_changes(solved, joints, gears, direct, motion);
    for (int turn = 0; turn < direct.turn_count && has_joint_changes; ++turn) {
      if (turn > 0) solve_direct(solved, motion, direct);
      const std::uint32_t iterations = takes_joints(direct, turn) ? set.joint_iterations : 0;
      solve_drift_velocities(solved, iterations, joints, gears, contacts, motion);
    }
    meet_direct(solved, motion, direct);
    scheme.drift(solved, motion, set.h);  // x += h v
    if (has_impacts) {
      finish_impacts(solved, impacts);
      stop_at_walls(solved, tick.impacts, direct, impacts);
    }
    end_direct_move(solved, direct);
    take_back_pushes(solved, contacts);
    for (int turn = 0; turn < direct.turn_count; ++turn) {
      if (turn > 0) project_direct(solved, direct);
      if (takes_joints(direct, turn)) {
        solve_joints(solved, joints, Bias::off);
        solve_gears(solved, gears, Bias::off);
      }
      relax_contacts(solved, contacts);
    }
    if (!(settled > 0)) settled = settled_speed(solved);
    propagate_shock(solved, settled, tick, contacts, shock);
    if (settled > 0) limit_impulses(set, contacts);
    project_direct(solved, direct);
    relax_jointed_contacts(solved, direct, contacts, jointed_impacts);
    after_substep(solved, substep);
  }
  store_contacts(solved, contacts, state);
}

void solve_tgs_soft(const Model& model, State& state, TickLists& tick, SolverWork& work, Real dt) {
  prepare_bodies(model, state, tick, work.bodies);
  begin_motion(state, work.motion);
  if (!tick.has_solver_sets) put_all_into_one_set(model, state, work.bodies, tick);
  find_crowds(model, state, tick);
  clear_contacts(work.contacts.batches);
  find_direct_joints(model, state, tick, work.direct);
  const bool some_are_free = find_constrained(model, state, tick, work.free_bodies);
  for (std::uint32_t i = 0; i < tick.solver_sets.size(); ++i) {
    const Real h = dt / static_cast<Real>(tick.solver_sets[i].substeps);  // s
    SolvedSet solved = enter_solver_set(model, state, tick, work.bodies, i, h);
    solved.set.stiffness = soft_contacts(h);
    prepare_mouse_joints(solved, work.mouse_joints);
    const SubstepStrategy solve_substeps = plan_substeps(solved, some_are_free, work);
    find_gear_torques(solved, work.joints.torques.of_gears);
    prepare_joints(solved, work.joints);
    prepare_gears(solved, work.gears);
    prepare_joint_changes(solved, work.motion);
    prepare_direct(solved, work.joints.plan, work.mouse_joints, work.direct);
    integrator(model.scene.settings.integrator).begin(solved, work.motion, h);
    solve_substeps(solved, tick, work, state);
    store_mouse_joints(work.mouse_joints, state, h);  // forces, since the next tick may have another h
    store_joints(solved, work.joints, state);
    store_gears(solved, work.gears, state);
    store_direct(solved, work.direct, state);
  }
  if (has_budget(model)) store_budget(tick, state);
  store_bodies(model, work.bodies, tick, state);
  store_motion(work.motion, state);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
