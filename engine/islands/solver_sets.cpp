// The one set of a world without islands, and bodies without constraints.
// SPDX-License-Identifier: MIT
#include "engine/islands/solver_sets.h"

#include <numeric>

#include "engine/integrators/flow.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void put_all_into_one_set(const Model& model, const State& state, Scratch& scratch) {
  scratch.solver_sets.clear();
  scratch.body_solver_set.resize(state.bodies.size());
  scratch.set_rows.resize(state.bodies.size());
  std::uint32_t row_count = 0;
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
    const bool moves = scratch.masses[row].read == row;
    scratch.set_rows[row_count] = row;
    scratch.body_solver_set[row] = moves ? 0 : no_solver_set;
    row_count += moves ? 1 : 0;
  }
  scratch.set_rows.resize(row_count);
  scratch.set_contacts.resize(scratch.contact_pairs.size());
  std::iota(scratch.set_contacts.begin(), scratch.set_contacts.end(), std::uint32_t{0});
  if (model.scene.settings.locate_impacts)
    std::erase_if(scratch.set_contacts,
                  [&](std::uint32_t contact) { return is_left_to_impacts(model, state, scratch, contact); });
  SolverSet set;
  set.substeps = model.scene.settings.substeps;
  set.row_end = static_cast<std::uint32_t>(scratch.set_rows.size());
  set.contact_end = static_cast<std::uint32_t>(scratch.set_contacts.size());
  scratch.solver_sets.push_back(set);
}

void enter_solver_set(const State& state, Scratch& scratch, SolverSet& set, Real h) {
  set.h = h;
  scratch.set_index = static_cast<std::uint32_t>(&set - scratch.solver_sets.data());
  scratch.moving_rows = {scratch.set_rows.data() + set.first_row, set.row_end - set.first_row};
  for (const std::uint32_t row : scratch.moving_rows) {
    if (scratch.masses[row].write == row) continue;
    const BodyRow& body = state.bodies[row];
    scratch.bodies[row] = {body.velocity, body.angular_velocity, {0, 0}, {1, 0}};
  }
}

bool find_constrained(const Model& model, const State& state, Scratch& scratch) {
  constexpr std::size_t bodies_per_contact_least = 2;
  if (!model.is_composed || !bodies_step_alone(model) || model.has_pointer || !state.joints.empty() ||
      scratch.injected || state.bodies.size() < bodies_per_contact_least * scratch.contact_pairs.size())
    return false;
  scratch.is_constrained.assign(state.bodies.size(), 0);
  const auto mark = [&](const auto& pairs) {
    for (const auto& pair : pairs) scratch.is_constrained[pair.body_a] = scratch.is_constrained[pair.body_b] = 1;
  };
  mark(scratch.contact_pairs);
  mark(scratch.impacts);
  return true;
}

void integrate_free_bodies(Scratch& scratch, const SolverSet& set) {
  std::uint32_t* rows = scratch.set_rows.data() + set.first_row;
  const std::size_t count = scratch.moving_rows.size();
  std::size_t constrained_count = 0;
  scratch.free_rows.resize(count);
  std::size_t free_count = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t row = rows[i];
    const std::size_t is_constrained = scratch.is_constrained[row];
    rows[constrained_count] = row;
    scratch.free_rows[free_count] = row;
    constrained_count += is_constrained;
    free_count += 1 - is_constrained;
  }
  scratch.moving_rows = {scratch.free_rows.data(), free_count};
  integrate_freely(scratch, set.h, set.substeps);
  scratch.moving_rows = {rows, constrained_count};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
