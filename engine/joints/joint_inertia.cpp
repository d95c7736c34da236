// Larger inertias against joint forces: the sums over joints.
// SPDX-License-Identifier: MIT
// Source: as joint_inertia.h
#include "engine/joints/joint_inertia.h"

#include "engine/joints/batched/revolute_batch.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// The limit of h^2 F r, relative to the inertia.
constexpr Real turning_limit = 2;

void raise_inertia(BodyMass& mass, Real least) {
  if (mass.inv_inertia * least > 1) mass.inv_inertia = 1 / least;
}

}  // namespace

void raise_inertias(const SolvedSet& solved, std::span<const JointPlace> places, JointTorqueWork& work) {
  const State& state = solved.state;
  const Parallel& parallel = solved.parallel();
  const Real h = solved.set.h;
  std::vector<JointTorques>& of_joints = work.of_joints;
  of_joints.resize(places.size());
  parallel.for_chunks(places.size(), parallel.chunk_size(places.size(), 256), [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      prefetch_joint(state, places, i);
      const Real force2 = length_squared(state.joints[places[i].row].linear_force);
      of_joints[i] = {square_root(force2 * length_squared(places[i].anchor_a)),
                      square_root(force2 * length_squared(places[i].anchor_b))};
    }
  });
  std::vector<Real>& torques = work.of_bodies;
  torques.assign(state.bodies.size(), 0);
  for (std::size_t i = 0; i < places.size(); ++i) {
    torques[places[i].body_b] += of_joints[i].b;
    if (places[i].body_a != no_reference) torques[places[i].body_a] += of_joints[i].a;
  }
  for (const BodyTorque& gear : work.of_gears) torques[gear.body] += gear.torque;
  const Real per_torque = h * h / turning_limit;
  parallel.for_chunks(torques.size(), parallel.chunk_size(torques.size(), 512), [&](const Chunk& chunk) {
    for (std::size_t row = chunk.begin; row < chunk.end; ++row)
      raise_inertia(solved.bodies.masses[row], per_torque * torques[row]);
  });
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
