// The one set of a world without islands.
// SPDX-License-Identifier: MIT
#include "engine/islands/solver_sets.h"

#include <numeric>

#include "engine/impacts/impacts.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void put_all_into_one_set(const Model& model, const State& state, const SolverBodies& bodies, TickLists& tick) {
  tick.solver_sets.clear();
  tick.body_solver_set.resize(state.bodies.size());
  tick.set_rows.resize(state.bodies.size());
  std::uint32_t row_count = 0;
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
    const bool moves = bodies.masses[row].read == row;
    tick.set_rows[row_count] = row;
    tick.body_solver_set[row] = moves ? 0 : no_solver_set;
    row_count += moves ? 1 : 0;
  }
  tick.set_rows.resize(row_count);
  tick.set_contacts.resize(tick.contact_pairs.size());
  std::iota(tick.set_contacts.begin(), tick.set_contacts.end(), std::uint32_t{0});
  if (model.scene.settings.locate_impacts)
    std::erase_if(tick.set_contacts,
                  [&](std::uint32_t contact) { return is_left_to_impacts(model, state, tick, contact); });
  SolverSet set;
  set.substeps = model.scene.settings.substeps;
  set.row_end = static_cast<std::uint32_t>(tick.set_rows.size());
  set.contact_end = static_cast<std::uint32_t>(tick.set_contacts.size());
  tick.solver_sets.push_back(set);
}

SolvedSet solver_set(const Model& model, const State& state, TickLists& tick, SolverBodies& bodies,
                     std::uint32_t index) {
  SolvedSet solved{model, state, tick, tick.solver_sets[index], index, bodies, {}};
  solved.rows = solved.all_rows();
  return solved;
}

SolvedSet enter_solver_set(const Model& model, const State& state, TickLists& tick, SolverBodies& bodies,
                           std::uint32_t index, Real h) {
  const SolvedSet solved = solver_set(model, state, tick, bodies, index);
  solved.set.h = h;
  for (const std::uint32_t row : solved.rows) {
    if (bodies.masses[row].write == row) continue;
    const BodyRow& body = state.bodies[row];
    bodies.records[row] = {body.velocity, body.angular_velocity, {0, 0}, {1, 0}};
  }
  return solved;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
