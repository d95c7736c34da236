// The changes of velocity by joints that enter the drift velocity of an integrator whole.
// SPDX-License-Identifier: MIT
// Source: Andersen, "Rattle: a velocity version of the Shake algorithm", Journal of Computational Physics 52, 1983: the
// impulse that keeps a joint together moves the bodies for the whole step.
#pragma once

#include <vector>

#include "engine/contacts/contact_batch.h"
#include "engine/integrators/flow.h"
#include "engine/joints/direct/direct_set.h"
#include "engine/joints/gears/gear_joints.h"
#include "engine/joints/joint_passes.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Makes room for the changes of velocity that enter the drift whole (DriftVelocities::joint_changes), if the
/// integrator has a drift velocity and the state has joints.
void prepare_joint_changes(const SolvedSet& solved, MotionWorkspace& motion);
/// The changes of velocity by the rigid rows and limits of joints and gears in this substep. Springs and motors act as
/// forces do, so they are left out. Bodies in `direct` components keep what they have. Call before the drift.
void find_joint_changes(const SolvedSet& solved, JointWorkspace& work, const std::vector<GearJoint>& gears,
                        const DirectWorkspace& direct, MotionWorkspace& motion);
/// Solves joints and gears `iterations` times for the drift velocities, since these move the bodies, then the contacts.
/// Without it the forces that the drift leaves out open joints, and joints drag bodies into each other: the drift takes
/// their impulses whole, and half of those of contacts. Requires: find_joint_changes.
void solve_drift_velocities(const SolvedSet& solved, std::uint32_t iterations, JointWorkspace& work,
                            std::vector<GearJoint>& gears, ContactBatches& contacts, MotionWorkspace& motion);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
