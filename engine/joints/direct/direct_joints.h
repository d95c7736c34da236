// Joints of a component of the direct solver: from the state into an island, and back.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/joints/direct/direct_components.h"
#include "engine/model/body_rows.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The present pose of a body of the state that has moved since the tick began.
Pose pose_of(const BodyRow& at_start, const MovingBody& moved);

/// Fills the joints with impulses and drives of a substep; fill_springs adds the coefficients of springs.
void fill_joints(const SolvedSet& solved, const DirectComponent& component, DirectIsland& island);
/// Fills the coefficients of springs. Requires: factor_island.
void fill_springs(const SolvedSet& solved, const DirectComponent& component, DirectIsland& island);
/// If no joint has an impulse yet: finds the impulses under gravity. Requires: factor_island, the velocities of the
/// tick's start.
void find_first_impulses(const SolvedSet& solved, const DirectComponent& component, DirectIsland& island);

void store_joint_forces(const SolvedSet& solved, const DirectComponent& component, const DirectIsland& island,
                        State& state);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
