// The plan of joints: the order and the batches in which they are solved.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "base/parallel/parallel.h"
#include "engine/joints/batched/revolute_batch.h"
#include "engine/joints/joint.h"
#include "engine/joints/joint_order.h"
#include "engine/model/caches.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The inputs of a plan. The scene is the only input while all its joints and their bodies exist and there is one set.
struct JointPlanKey {
  bool follows_from_scene;
};

/// The order and batches of the joints of a set. Key: JointPlanKey.
class JointPlan final : public TickCache {
 public:
  JointPlan() : TickCache(CacheKind::joint_plan) {}

  bool valid_for(const JointPlanKey& key) const { return key.follows_from_scene && follows_from_scene_; }
  /// Makes the plan for the present set, unless the plan is valid. `left_out`: as for order_joints; it must follow from
  /// the scene alone whenever the plan does. Requires: prepare_bodies, enter_solver_set.
  void follow(const SolvedSet& solved, std::span<const std::uint8_t> left_out, JointOrderWork& work);
  void invalidate() override { follows_from_scene_ = false; }
  /// Removes all joints from the plan.
  void clear();

  std::span<const JointPlace> places() const { return order_.places; }               // in solving order
  std::span<const JointRange> ranges() const { return ranges_; }                     // of one kind and path
  std::span<const JointSpan> revolutes() const { return revolutes_; }                // [batch] of plain revolutes
  std::span<const JointSpan> driven_revolutes() const { return driven_revolutes_; }  // [batch]
  std::span<const std::uint32_t> scalar() const { return scalar_; }                  // in places(): the scalar path
  bool in_levels() const { return order_.in_levels; }                                // otherwise in scene order
  std::uint32_t level_count() const { return order_.level_count; }
  /// For the wavefront sweep, in ticks in which only joints act on the bodies (wavefront.h).
  const LevelSchedule& schedule() const { return order_.schedule; }
  std::span<const JointRange> ranges_of_level(std::uint32_t level) const {
    return std::span(ranges_).subspan(level_ranges_[level], level_ranges_[level + 1] - level_ranges_[level]);
  }

 private:
  void rebuild(const JointPlanKey& key, const SolvedSet& solved, std::span<const std::uint8_t> left_out,
               JointOrderWork& work);
  void make_ranges(const Model& model, const Parallel& parallel);

  bool follows_from_scene_ = false;  // key
  JointOrder order_;
  bool by_level_ = false;  // ranges end where levels end
  std::vector<JointRange> ranges_;
  std::vector<JointSpan> revolutes_;
  std::vector<JointSpan> driven_revolutes_;
  std::vector<std::uint32_t> scalar_;
  std::vector<std::uint32_t> level_ranges_;  // [level] in ranges_, and the end
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
