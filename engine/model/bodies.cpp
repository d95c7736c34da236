// Filling and storing of hot body records.
// SPDX-License-Identifier: MIT
#include "engine/model/bodies.h"

#include <algorithm>

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr MovingBody at_rest{{0, 0}, 0, {0, 0}, {1, 0}};

std::size_t chunk_of_bodies(const Scratch& scratch, std::size_t count) {
  return scratch.parallel.chunk_size(count, 256);
}

}  // namespace

void prepare_bodies(const Model& model, const State& state, Scratch& scratch) {
  scratch.kernels = &model.kernels;
  const std::size_t count = state.bodies.size();
  // The longest loop of the solver decides the number of sinks.
  const std::size_t longest = std::max({count, scratch.contact_pairs.size(), state.joints.size()});
  scratch.masses.resize(count);
  scratch.bodies.resize(dummy_sink(scratch, scratch.parallel.chunk_count_max(longest)));
  const std::uint32_t dummy = dummy_body(scratch);
  const std::uint32_t sink = dummy_sink(scratch);
  const bool raises = model.scene.settings.auto_substeps.has_value();
  scratch.parallel.for_chunks(count, chunk_of_bodies(scratch, count), [&](const Chunk& chunk) {
    for (std::size_t row = chunk.begin; row < chunk.end; ++row) {
      const BodyRow& body = state.bodies[row];
      const BodyModel& constants = model.bodies[body.source];
      const auto record = static_cast<std::uint32_t>(row);
      scratch.bodies[row] = {body.velocity, body.angular_velocity, {0, 0}, {1, 0}};
      scratch.masses[row] = {constants.inv_mass, constants.inv_inertia,
                             constants.type == BodyType::static_body ? dummy : record,
                             constants.type == BodyType::dynamic_body ? record : sink};
      if (!raises) continue;
      const Real share = 1 / scratch.mass_factor[row];
      scratch.masses[row].inv_mass *= share;
      scratch.masses[row].inv_inertia *= share;
    }
  });
  scratch.previous_accelerations.clear();
  for (const AccelerationRow& row : state.accelerations)
    scratch.previous_accelerations.push_back({row.linear, row.angular});
  scratch.unconverged = 0;
  for (std::size_t record = count; record < scratch.bodies.size(); ++record) scratch.bodies[record] = at_rest;
}

void store_bodies(const Scratch& scratch, State& state) {
  const std::size_t count = state.bodies.size();
  scratch.parallel.for_chunks(count, chunk_of_bodies(scratch, count), [&](const Chunk& chunk) {
    for (std::size_t row = chunk.begin; row < chunk.end; ++row) {
      if (scratch.body_solver_set[row] == no_solver_set) continue;
      BodyRow& body = state.bodies[row];
      const MovingBody& moving = scratch.bodies[row];
      body.position = stored(body.position + moving.delta_position);
      body.rotation = stored(normalized(moving.delta_rotation * body.rotation));
      body.velocity = stored(moving.velocity);
      body.angular_velocity = stored(moving.angular_velocity);
    }
  });
  for (std::size_t row = 0; row < state.accelerations.size(); ++row)
    state.accelerations[row] = {stored(scratch.previous_accelerations[row].linear),
                                stored(scratch.previous_accelerations[row].angular)};
  const std::uint32_t count_left = no_reference - state.integrator.unconverged;
  state.integrator.unconverged += scratch.unconverged < count_left ? scratch.unconverged : count_left;
}

void store_velocities(const Scratch& scratch, State& state) {
  for (std::size_t row = 0; row < state.bodies.size(); ++row) {
    if (scratch.body_solver_set[row] == no_solver_set) continue;
    state.bodies[row].velocity = stored(scratch.bodies[row].velocity);
    state.bodies[row].angular_velocity = stored(scratch.bodies[row].angular_velocity);
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
