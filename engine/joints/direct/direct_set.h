// The direct joint solver in a solver set: islands of jointed bodies, filled from the state and the bodies' records.
// SPDX-License-Identifier: MIT
//
// Contacts and joints of bounded force alternate with the direct solve. An island of jointed bodies is independent of
// other islands and is computed in doubles. The number and order of threads therefore change no bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/integrators/motion_rows.h"
#include "engine/joints/direct/direct_components.h"
#include "engine/joints/joint_plan.h"
#include "engine/joints/mouse_joint.h"
#include "engine/model/poison.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine {

template <typename Visit>
void list_fields(BlockSystem& of, const Visit& visit) {
  auto& [diagonal, blocks, values, column, articulated] = of;
  visit(diagonal, blocks, values, column, articulated);
}

template <typename Visit>
void list_fields(SavedIsland& of, const Visit& visit) {
  auto& [velocities, impulses, drives] = of;
  visit(velocities, impulses, drives);
}

template <typename Visit>
void list_fields(DirectIsland& of, const Visit& visit) {
  auto& [bodies, moving_count, joints, shapes, drives, graph, system, push, push_impulses, push_share, worst_miss,
         has_drives, is_free, moved_poses, saved, start, angular_impulses] = of;
  visit(bodies, moving_count, joints, shapes, drives, system, push, push_impulses, push_share, worst_miss, has_drives,
        is_free, moved_poses, saved, start, angular_impulses);
}

}  // namespace ticktrue::engine

namespace ticktrue::engine::TICKTRUE_PRECISION {

inline Triple velocity_of(const MovingBody& body) {
  return {static_cast<double>(body.velocity.x), static_cast<double>(body.velocity.y),
          static_cast<double>(body.angular_velocity)};
}

/// The island of a component, and the velocity changes of its bodies by its joints in this substep.
struct DirectSetIsland {
  DirectIsland island;
  std::vector<Triple> loaded;   // [moving body] velocities as loaded
  std::vector<Triple> changes;  // [moving body] by all joints
  std::vector<Triple> forces;   // [moving body] by rows that act like forces
};

template <typename Visit>
void list_fields(DirectSetIsland& of, const Visit& visit) {
  auto& [island, loaded, changes, forces] = of;
  visit(island, loaded, changes, forces);
}

struct DirectWorkspace {
  DirectComponents components;
  std::vector<DirectPlace> places;
  std::vector<DirectSetIsland> islands;       // [component]
  std::vector<std::uint32_t> set_components;  // of the present set
  int turn_count = 1;                         // alternations of joints and contacts in the set
  bool solves_joints = false;                 // false: the islands serve impacts alone

  /// Whether the joints of this body are solved directly.
  bool holds_body(std::size_t row) const {
    return solves_joints && components.component_of(row) != DirectComponents::none;
  }
  /// [row of a joint] 1: it is solved directly; empty: none is.
  std::span<const std::uint8_t> solved_joints() const {
    return solves_joints ? components.direct_joints() : std::span<const std::uint8_t>{};
  }
};

template <typename Visit>
void list_fields(DirectWorkspace& of, const Visit& visit) {
  auto& [components, places, islands, set_components, turn_count, solves_joints] = of;
  visit(components, places, in_place(islands), set_components, turn_count, solves_joints);
}

/// Finds the islands of jointed bodies, and whether their joints are solved directly in this tick. Otherwise the
/// islands are found if there are contacts, for their impacts.
void find_direct_joints(const Model& model, const State& state, const TickLists& tick, DirectWorkspace& work);

/// Fills the islands of a set. `plan`: of the joints that are solved by iteration. Requires: prepare_joints,
/// prepare_mouse_joints.
void prepare_direct(const SolvedSet& solved, const JointPlan& plan, const std::vector<MouseJoint>& mouse_joints,
                    DirectWorkspace& work);
/// Lets springs, motors and limits act. Call before the integrator predicts.
void begin_direct_substep(const SolvedSet& solved, DirectWorkspace& work);
/// Applies the given impulses: those of motors at their bounds. Call after the integrator has predicted.
void start_direct(const SolvedSet& solved, MotionWorkspace& motion, DirectWorkspace& work);
/// Computes velocities that keep the joints, for passes that alternate with contacts.
void solve_direct(const SolvedSet& solved, MotionWorkspace& motion, DirectWorkspace& work);
/// Computes velocities with which the bodies' move meets the joints. Call last before the move.
void meet_direct(const SolvedSet& solved, MotionWorkspace& motion, DirectWorkspace& work);
/// Loads the new poses, and removes the push.
void end_direct_move(const SolvedSet& solved, DirectWorkspace& work);
/// Computes velocities that keep the joints at the present poses. Requires: end_direct_move.
void project_direct(const SolvedSet& solved, DirectWorkspace& work);
/// The same as project_direct for a set, after the solver has ended.
void project_direct_again(const SolvedSet& solved, DirectWorkspace& work);
/// Factors the rigid rows of an island alone, at its present poses. Requires, if its joints are solved in this tick: it
/// is factored.
void factor_for_impacts(const SolvedSet& solved, const DirectComponent& component, const DirectWorkspace& work,
                        DirectSetIsland& at);
/// Loads the present poses and brings the other rows back, if the joints are solved in this tick.
void end_impacts_of(const SolvedSet& solved, const DirectComponent& component, const DirectWorkspace& work,
                    DirectSetIsland& at);
/// Changes velocities so that they keep the rigid rows. `velocities`: [moving body]. Requires: factor_for_impacts, and
/// the joints are not solved in this tick.
void project_for_impacts(const SolvedSet& solved, const DirectComponent& component, DirectSetIsland& at,
                         std::span<Triple> velocities);
/// Stores the impulses in state.joints, as forces.
void store_direct(const SolvedSet& solved, const DirectWorkspace& work, State& state);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
