// Filling and storing of hot body records.
// SPDX-License-Identifier: MIT
#include "engine/model/bodies.h"

#include <algorithm>

#include "engine/model/model.h"
#include "engine/model/state.h"
#include "engine/model/tick_lists.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr MovingBody at_rest{{0, 0}, 0, {0, 0}, {1, 0}};

std::size_t chunk_of_bodies(const TickLists& tick, std::size_t count) {
  return tick.parallel.chunk_size(count, 256);
}

/// Fills TickLists::travel. Bodies in no solver set do not move.
void find_travel(const Model& model, const State& state, const SolverBodies& bodies, TickLists& tick) {
  tick.travel.clear();
  if (state.sleep.empty()) return;
  tick.travel.resize(state.bodies.size());
  for (std::size_t row = 0; row < state.bodies.size(); ++row) {
    const MovingBody& moving = bodies.records[row];
    const Vec2 turn{moving.delta_rotation.c - 1, moving.delta_rotation.s};
    const Real extent = model.bodies[state.bodies[row].source].extent;
    tick.travel[row] = length(moving.delta_position) + length(turn) * extent;
  }
}

}  // namespace

void prepare_bodies(const Model& model, const State& state, const TickLists& tick, SolverBodies& bodies) {
  const std::size_t count = state.bodies.size();
  // The longest loop of the solver decides the number of sinks.
  const std::size_t longest = std::max({count, tick.contact_pairs.size(), state.joints.size()});
  bodies.masses.resize(count);
  bodies.records.resize(dummy_sink(bodies, tick.parallel.chunk_count_max(longest)));
  const std::uint32_t dummy = dummy_body(bodies);
  const std::uint32_t sink = dummy_sink(bodies);
  const bool raises = tick.has_solver_sets && model.scene.settings.auto_substeps;
  tick.parallel.for_chunks(count, chunk_of_bodies(tick, count), [&](const Chunk& chunk) {
    for (std::size_t row = chunk.begin; row < chunk.end; ++row) {
      const BodyRow& body = state.bodies[row];
      const BodyModel& constants = model.bodies[body.source];
      const auto record = static_cast<std::uint32_t>(row);
      bodies.records[row] = {body.velocity, body.angular_velocity, {0, 0}, {1, 0}};
      bodies.masses[row] = {constants.inv_mass, constants.inv_inertia,
                            constants.type == BodyType::static_body ? dummy : record,
                            constants.type == BodyType::dynamic_body ? record : sink};
      if (!raises || tick.mass_factor[row] == 1) continue;
      const Real share = 1 / tick.mass_factor[row];
      bodies.masses[row].inv_mass *= share;
      bodies.masses[row].inv_inertia *= share;
    }
  });
  for (std::size_t record = count; record < bodies.records.size(); ++record) bodies.records[record] = at_rest;
}

void store_bodies(const Model& model, const SolverBodies& bodies, TickLists& tick, State& state) {
  const std::size_t count = state.bodies.size();
  find_travel(model, state, bodies, tick);
  tick.parallel.for_chunks(count, chunk_of_bodies(tick, count), [&](const Chunk& chunk) {
    for (std::size_t row = chunk.begin; row < chunk.end; ++row) {
      if (tick.body_solver_set[row] == no_solver_set) continue;
      BodyRow& body = state.bodies[row];
      const MovingBody& moving = bodies.records[row];
      body.position = stored(body.position + moving.delta_position);
      body.rotation = stored(normalized(moving.delta_rotation * body.rotation));
      body.velocity = stored(moving.velocity);
      body.angular_velocity = stored(moving.angular_velocity);
    }
  });
}

void store_velocities(const SolverBodies& bodies, const TickLists& tick, State& state) {
  for (std::size_t row = 0; row < state.bodies.size(); ++row) {
    if (tick.body_solver_set[row] == no_solver_set) continue;
    state.bodies[row].velocity = stored(bodies.records[row].velocity);
    state.bodies[row].angular_velocity = stored(bodies.records[row].angular_velocity);
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
