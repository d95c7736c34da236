// Bodies without constraints: the integrator alone.
// SPDX-License-Identifier: MIT
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"
#include "engine/islands/solver_sets.h"
#include "engine/model/bodies.h"
#include "engine/solvers/solver.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void solve_free_flight(const Model& model, State& state, Scratch& scratch, Real dt) {
  const Integrator& scheme = integrator(model.scene.settings.integrator);
  const int substep_count = model.scene.settings.substeps;
  const Real h = dt / static_cast<Real>(substep_count);  // s
  prepare_bodies(model, state, scratch);
  put_all_into_one_set(model, state, scratch);
  enter_solver_set(state, scratch, scratch.solver_sets[0], h);
  scheme.begin(model, state, scratch, h);
  if (bodies_step_alone(model))
    integrate_freely(scratch, h, substep_count);
  else
    for (int substep = 0; substep < substep_count; ++substep) {
      scheme.predict(model, state, scratch, h);
      scheme.drift(model, state, scratch, h);
    }
  store_bodies(scratch, state);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
