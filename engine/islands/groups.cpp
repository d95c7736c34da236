// The one group of a world without islands.
// SPDX-License-Identifier: MIT
#include "engine/islands/groups.h"

#include <numeric>

#include "engine/integrators/flow.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void group_everything(const Model& model, const State& state, Scratch& scratch) {
  scratch.groups.clear();
  scratch.body_group.resize(state.bodies.size());
  scratch.group_rows.resize(state.bodies.size());
  std::uint32_t row_count = 0;
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
    const bool moves = scratch.masses[row].read == row;
    scratch.group_rows[row_count] = row;
    scratch.body_group[row] = moves ? 0 : no_group;
    row_count += moves ? 1 : 0;
  }
  scratch.group_rows.resize(row_count);
  scratch.group_contacts.resize(scratch.touching.size());
  std::iota(scratch.group_contacts.begin(), scratch.group_contacts.end(), std::uint32_t{0});
  if (model.scene.settings.locate_impacts)
    std::erase_if(scratch.group_contacts,
                  [&](std::uint32_t contact) { return is_left_to_impacts(model, state, scratch, contact); });
  SolveGroup group;
  group.substeps = model.scene.settings.substeps;
  group.row_end = static_cast<std::uint32_t>(scratch.group_rows.size());
  group.contact_end = static_cast<std::uint32_t>(scratch.group_contacts.size());
  scratch.groups.push_back(group);
}

void enter_group(const State& state, Scratch& scratch, SolveGroup& group, Real h) {
  group.h = h;
  scratch.group_index = static_cast<std::uint32_t>(&group - scratch.groups.data());
  scratch.moving_rows = {scratch.group_rows.data() + group.first_row, group.row_end - group.first_row};
  for (const std::uint32_t row : scratch.moving_rows) {
    if (scratch.masses[row].write == row) continue;
    const BodyRow& body = state.bodies[row];
    scratch.bodies[row] = {body.velocity, body.angular_velocity, {0, 0}, {1, 0}};
  }
}

bool find_tied(const Model& model, const State& state, Scratch& scratch) {
  constexpr std::size_t bodies_per_contact_least = 2;
  if (!model.is_composed || !bodies_step_alone(model) || model.has_pointer || !state.joints.empty() ||
      scratch.planted || state.bodies.size() < bodies_per_contact_least * scratch.touching.size())
    return false;
  scratch.is_tied.assign(state.bodies.size(), 0);
  const auto tie = [&](const auto& pairs) {
    for (const auto& pair : pairs) scratch.is_tied[pair.body_a] = scratch.is_tied[pair.body_b] = 1;
  };
  tie(scratch.touching);
  tie(scratch.impacts);
  return true;
}

void fly_loose(Scratch& scratch, const SolveGroup& group) {
  std::uint32_t* rows = scratch.group_rows.data() + group.first_row;
  const std::size_t count = scratch.moving_rows.size();
  std::size_t tied_count = 0;
  scratch.loose_rows.resize(count);
  std::size_t loose_count = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t row = rows[i];
    const std::size_t is_tied = scratch.is_tied[row];
    rows[tied_count] = row;
    scratch.loose_rows[loose_count] = row;
    tied_count += is_tied;
    loose_count += 1 - is_tied;
  }
  scratch.moving_rows = {scratch.loose_rows.data(), loose_count};
  fly(scratch, group.h, group.substeps);
  scratch.moving_rows = {rows, tied_count};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
