// Larger inertias against joint forces that substeps cannot follow.
// SPDX-License-Identifier: MIT
// Source: Tournier, Nesme, Gilles, Faure, "Stable Constrained Dynamics", SIGGRAPH 2015, and Andrews, Teichmann, Kry,
// "Geometric Stiffness for Real-time Constrained Multibody Dynamics", Eurographics 2017: constraint forces have a
// stiffness of their own because bodies rotate under them.
//
// A force F at an arm r rotates with the body and acts as a spring of stiffness F r about the centre. Warm starting
// makes this spring explicit, which is stable up to h^2 F r = 4 I. Half of that is reserved for a neighbour that
// rotates the other way. Beyond the limit, constraints use the inertia that meets it. The body's own spin is
// unaffected.
#pragma once

#include <span>
#include <vector>

#include "engine/joints/joint_order.h"
#include "engine/math/real.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct SolvedSet;

/// The largest torques that a joint's force exerts on its bodies, N m.
struct JointTorques {
  Real a;
  Real b;
};

struct BodyTorque {
  std::uint32_t body;  // row
  Real torque;         // N m
};

struct JointTorqueWork {
  std::vector<JointTorques> of_joints;  // [place of the plan]
  std::vector<BodyTorque> of_gears;     // filled by find_gear_torques
  std::vector<Real> of_bodies;          // [body] sum of the torques of its joints and gears, N m
};

template <typename Visit>
void list_fields(JointTorqueWork& of, const Visit& visit) {
  auto& [of_joints, of_gears, of_bodies] = of;
  visit(of_joints, of_gears, of_bodies);
}

/// Raises inertias in SolverBodies::masses where the forces of joints and gears in the last substep require it.
void raise_inertias(const SolvedSet& solved, std::span<const JointPlace> places, JointTorqueWork& work);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
