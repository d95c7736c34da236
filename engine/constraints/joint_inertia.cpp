// Inertia against joints that pull harder than substeps can follow: the sums over joints.
// SPDX-License-Identifier: MIT
// Source: as joint_inertia.h
#include "engine/constraints/joint_inertia.h"

#include "engine/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// h^2 F r in units of the inertia.
constexpr Real turning_limit = 2;

void raise_inertia(BodyMass& mass, Real least) {
  if (mass.inv_inertia * least > 1) mass.inv_inertia = 1 / least;
}

}  // namespace

void raise_inertias(const Model& model, const State& state, Scratch& scratch, Real h) {
  std::vector<Real>& torques = scratch.joint_torques;
  torques.assign(state.bodies.size(), 0);
  for (const JointPlace& place : scratch.joint_places) {
    const JointModel& joint = model.joints[place.joint];
    const Real force2 = length_squared(state.joints[place.row].linear_force);
    torques[place.body_b] += square_root(force2 * length_squared(joint.anchor_b));
    if (place.body_a != no_reference) torques[place.body_a] += square_root(force2 * length_squared(joint.anchor_a));
  }
  const Real per_torque = h * h / turning_limit;
  for (const JointPlace& place : scratch.joint_places) {
    raise_inertia(scratch.masses[place.body_b], per_torque * torques[place.body_b]);
    if (place.body_a != no_reference) raise_inertia(scratch.masses[place.body_a], per_torque * torques[place.body_a]);
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
