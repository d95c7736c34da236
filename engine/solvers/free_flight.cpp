// Bodies without constraints: the integrator alone.
// SPDX-License-Identifier: MIT
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"
#include "engine/islands/solver_sets.h"
#include "engine/model/bodies.h"
#include "engine/solvers/solver.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void solve_free_flight(const Model& model, State& state, TickLists& tick, SolverWork& work, Real dt) {
  const Integrator& scheme = integrator(model.scene.settings.integrator);
  const int substep_count = model.scene.settings.substeps;
  const Real h = dt / static_cast<Real>(substep_count);  // s
  prepare_bodies(model, state, tick, work.bodies);
  begin_motion(state, work.motion);
  put_all_into_one_set(model, state, work.bodies, tick);
  const SolvedSet solved = enter_solver_set(model, state, tick, work.bodies, 0, h);
  scheme.begin(solved, work.motion, h);
  if (bodies_step_alone(model))
    integrate_freely(solved, work.motion);
  else
    for (int substep = 0; substep < substep_count; ++substep) {
      scheme.predict(solved, work.motion, h);
      scheme.drift(solved, work.motion, h);
    }
  store_bodies(model, work.bodies, tick, state);
  store_motion(work.motion, state);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
