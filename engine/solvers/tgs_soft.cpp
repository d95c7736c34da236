// Velocity solver with substeps, soft constraints, warm starting and a relax pass.
// SPDX-License-Identifier: MIT
// Source: Macklin et al., "Small Steps in Physics Simulation", 2019 (substeps); Catto, "Solver2D", 2024 (soft step,
// relax). Cost per tick: bodies 2 + 2n, contacts 2 + 3n, n = substep count.
#include "engine/constraints/bodies.h"
#include "engine/integrators/integrator.h"
#include "engine/solvers/solver.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void solve_tgs_soft(const Model& model, State& state, Scratch& scratch, Real dt) {
  const Integrator& scheme = integrator(model.scene.settings.integrator);
  const int substep_count = model.scene.settings.substeps;
  const Real h = dt / static_cast<Real>(substep_count);  // s
  prepare_bodies(state, scratch);
  prepare_pulls(model, state, scratch, h);
  prepare_contacts(model, state, scratch, h);
  scheme.begin(model, state, scratch, h);
  for (int substep = 0; substep < substep_count; ++substep) {
    scheme.predict(model, state, scratch, h);
    warm_start_pulls(scratch);
    warm_start_contacts(scratch);
    solve_pulls(scratch);
    solve_contacts(scratch, h, Bias::on);
    scheme.drift(model, state, scratch, h);
    solve_contacts(scratch, h, Bias::off);  // relax: takes out the velocity that the bias put in
  }
  store_bodies(model, scratch, state);
  store_contacts(scratch, state, h);  // forces, since the next tick may have another h
  store_pulls(scratch, state, h);
  scratch.substep = h;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
