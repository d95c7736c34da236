// The plan of joints: in which order and in which batches they are solved.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/joints/batched/revolute_batch.h"
#include "engine/joints/joint.h"
#include "engine/model/caches.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Of the group that is being solved. Where there is one group of everything, it follows from the scene alone as long
/// as all joints of the scene are there, and is kept.
struct JointPlan final : TickCache {
  JointPlan() : TickCache(CacheKind::joint_plan) {}
  void invalidate() override { is_of_scene = false; }
  void count(bool was_hit) { count_use(was_hit); }

  bool is_of_scene = false;
  bool in_levels = false;                   // else in scene order
  bool by_level = false;                    // ranges end where levels do
  std::vector<JointPlace> places;           // in solving order
  std::vector<JointRange> ranges;           // of one kind and path
  std::vector<JointSpan> revolutes;         // [batch] of plain revolutes
  std::vector<JointSpan> driven_revolutes;  // [batch] of driven revolutes
  std::vector<std::uint32_t> scalar;        // in `places`: joints of the scalar path

  std::uint32_t level_count = 0;
  bool uses_wavefront = false;  // in ticks in which nothing else acts on the bodies (wavefront.h)

  // For the wavefront sweep.
  std::uint32_t distance = 0;               // two joints of one body are less than this many levels apart
  std::vector<std::uint32_t> level_ranges;  // [level] in `ranges`, and the end
  std::vector<std::uint32_t> body_rows;     // dynamic bodies of joints, by the level of their first joint
  std::vector<std::uint32_t> level_bodies;  // [level] in `body_rows`, and the end
};

/// The largest torques that a joint's force exerts on its bodies, N m.
struct JointTorques {
  Real a;
  Real b;
};

/// The first and the last joint that moves a body, in the plan's places before they are sorted.
struct BodyJoints {
  std::uint32_t first = 0;
  std::uint32_t last = 0;
  std::uint32_t count = 0;  // of its joints
};

/// Makes the plan for the set that is being solved, or uses the cached one. Requires: prepare_bodies, enter_solver_set.
void plan_joints(const Model& model, const State& state, Scratch& scratch);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
