// Hot body records in and out.
// SPDX-License-Identifier: MIT
#include "engine/constraints/bodies.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr MovingBody at_rest{{0, 0}, 0, {0, 0}, {1, 0}};

}  // namespace

void prepare_bodies(const Model& model, const State& state, Scratch& scratch) {
  scratch.kernels = &model.kernels;
  scratch.bodies.resize(state.bodies.size() + 2);
  scratch.masses.resize(state.bodies.size());
  const std::uint32_t resting = resting_record(scratch);
  const std::uint32_t unread = unread_record(scratch);
  const bool raises = model.scene.settings.auto_substeps.has_value();
  for (std::size_t row = 0; row < state.bodies.size(); ++row) {
    const BodyRow& body = state.bodies[row];
    const BodyModel& constants = model.bodies[body.source];
    const auto record = static_cast<std::uint32_t>(row);
    scratch.bodies[row] = {body.velocity, body.angular_velocity, {0, 0}, {1, 0}};
    scratch.masses[row] = {constants.inv_mass, constants.inv_inertia,
                           constants.type == BodyType::static_body ? resting : record,
                           constants.type == BodyType::dynamic_body ? record : unread};
    if (!raises) continue;
    const Real share = 1 / scratch.mass_factor[row];
    scratch.masses[row].inv_mass *= share;
    scratch.masses[row].inv_inertia *= share;
  }
  scratch.previous_accelerations.clear();
  for (const AccelerationRow& row : state.accelerations)
    scratch.previous_accelerations.push_back({row.linear, row.angular});
  scratch.unconverged = 0;
  scratch.bodies[state.bodies.size()] = at_rest;
  scratch.bodies[state.bodies.size() + 1] = at_rest;
}

void store_bodies(const Scratch& scratch, State& state) {
  for (std::size_t row = 0; row < state.bodies.size(); ++row) {
    if (scratch.body_group[row] == no_group) continue;
    BodyRow& body = state.bodies[row];
    const MovingBody& moving = scratch.bodies[row];
    body.position = body.position + moving.moved;
    body.rotation = normalized(moving.turned * body.rotation);
    body.velocity = moving.velocity;
    body.angular_velocity = moving.angular_velocity;
  }
  for (std::size_t row = 0; row < state.accelerations.size(); ++row)
    state.accelerations[row] = {scratch.previous_accelerations[row].linear,
                                scratch.previous_accelerations[row].angular};
  const std::uint32_t room = no_reference - state.integrator.unconverged;
  state.integrator.unconverged += scratch.unconverged < room ? scratch.unconverged : room;
}

void store_velocities(const Scratch& scratch, State& state) {
  for (std::size_t row = 0; row < state.bodies.size(); ++row) {
    if (scratch.body_group[row] == no_group) continue;
    state.bodies[row].velocity = scratch.bodies[row].velocity;
    state.bodies[row].angular_velocity = scratch.bodies[row].angular_velocity;
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
