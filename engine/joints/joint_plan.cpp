// The step from the order of joints to ranges and batches.
// SPDX-License-Identifier: MIT
#include "engine/joints/joint_plan.h"

#include "engine/joints/batched/wavefront.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// Whether the plan follows from the scene alone: all its joints exist, each body is in the row of its id, and there is
/// one set. Rows ascend by id, so one row equal to its id proves all rows before it.
bool follows_from_scene(const Model& model, const State& state) {
  if (model.finds_islands || state.joints.size() != model.joints.size()) return false;
  const std::uint32_t last = model.last_joined;
  return last < state.bodies.size() && state.bodies[last].id == last;
}

bool has_springs(const JointModel& joint) {
  return joint.spring.exists || joint.linear_spring.exists || traits_of(joint.kind).is_driven;
}

/// Adds the next place to the last batch. A new batch begins if the last batch is full, or at another level or a new
/// range.
void add_to_batches(std::vector<JointSpan>& spans, std::uint32_t place, std::uint32_t level, bool begins_run) {
  if (begins_run || spans.back().level != level || spans.back().count == lane_count) spans.push_back({place, 0, level});
  ++spans.back().count;
}

}  // namespace

void JointPlan::clear() {
  invalidate();
  order_ = {};
  by_level_ = false;
  ranges_.clear();
  revolutes_.clear();
  driven_revolutes_.clear();
  scalar_.clear();
  level_ranges_.clear();
}

void JointPlan::follow(const SolvedSet& solved, std::span<const std::uint8_t> left_out, JointOrderWork& work) {
  const JointPlanKey key{follows_from_scene(solved.model, solved.state)};
  const bool is_hit = valid_for(key);
  count_use(is_hit);
  if (!is_hit) rebuild(key, solved, left_out, work);
}

void JointPlan::rebuild(const JointPlanKey& key, const SolvedSet& solved, std::span<const std::uint8_t> left_out,
                        JointOrderWork& work) {
  follows_from_scene_ = key.follows_from_scene;
  order_joints(solved, key.follows_from_scene && allows_wavefront(solved.model), left_out, work, order_);
  // Several threads or a wavefront sweep need ranges that end with levels.
  by_level_ = order_.in_levels && (solved.parallel().runner != nullptr || order_.schedule.exists);
  make_ranges(solved.model, solved.parallel());
}

/// Divides the places into ranges, and places of batched paths into batches.
void JointPlan::make_ranges(const Model& model, const Parallel& parallel) {
  ranges_.clear();
  revolutes_.clear();
  driven_revolutes_.clear();
  scalar_.clear();
  level_ranges_.clear();
  const bool in_levels = order_.in_levels;
  const auto end_of = [this](JointPath path) {
    if (path == JointPath::scalar) return static_cast<std::uint32_t>(scalar_.size());
    return static_cast<std::uint32_t>((path == JointPath::revolute ? revolutes_ : driven_revolutes_).size());
  };
  for (std::uint32_t i = 0; i < order_.places.size(); ++i) {
    const JointPlace& place = order_.places[i];
    const JointPath path = in_levels || place.path == JointPath::revolute ? place.path : JointPath::scalar;
    const bool begins = ranges_.empty() || ranges_.back().kind != place.kind || ranges_.back().path != path ||
                        (by_level_ && ranges_.back().level != place.level);
    if (by_level_)
      while (level_ranges_.size() <= place.level) level_ranges_.push_back(static_cast<std::uint32_t>(ranges_.size()));
    if (begins) ranges_.push_back({place.kind, path, false, end_of(path), end_of(path), place.level});
    if (path == JointPath::scalar)
      scalar_.push_back(i);
    else
      add_to_batches(path == JointPath::revolute ? revolutes_ : driven_revolutes_, i, in_levels ? place.level : 0,
                     begins);
    ranges_.back().last = end_of(path);
    ranges_.back().springs |= path != JointPath::revolute && has_springs(model.joints[place.joint]);
  }
  level_ranges_.push_back(static_cast<std::uint32_t>(ranges_.size()));
  for (JointRange& range : ranges_) {
    const std::size_t count = range.last - range.first;
    const bool is_shared = range.path != JointPath::scalar && in_levels;
    range.chunk_size = is_shared ? parallel.chunk_size(count, joint_batches_per_chunk_least, 1) : count;
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
