// From the order of joints to ranges and batches.
// SPDX-License-Identifier: MIT
#include "engine/joints/joint_plan.h"

#include "engine/joints/batched/wavefront.h"
#include "engine/model/scratch.h"

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

/// Adds the next place to the last batch. A full batch, another level or a new range begins a new batch.
void add_to_batches(std::vector<JointSpan>& spans, std::uint32_t place, std::uint32_t level, bool begins_run) {
  if (begins_run || spans.back().level != level || spans.back().count == lane_count) spans.push_back({place, 0, level});
  ++spans.back().count;
}

/// Divides the places into ranges, and places of batched paths into batches.
void make_ranges(const Model& model, JointPlan& plan) {
  plan.ranges.clear();
  plan.revolutes.clear();
  plan.driven_revolutes.clear();
  plan.scalar.clear();
  plan.level_ranges.clear();
  const auto end_of = [&plan](JointPath path) {
    if (path == JointPath::scalar) return static_cast<std::uint32_t>(plan.scalar.size());
    return static_cast<std::uint32_t>((path == JointPath::revolute ? plan.revolutes : plan.driven_revolutes).size());
  };
  for (std::uint32_t i = 0; i < plan.places.size(); ++i) {
    const JointPlace& place = plan.places[i];
    const JointPath path = plan.in_levels || place.path == JointPath::revolute ? place.path : JointPath::scalar;
    const bool begins = plan.ranges.empty() || plan.ranges.back().kind != place.kind ||
                        plan.ranges.back().path != path || (plan.by_level && plan.ranges.back().level != place.level);
    if (plan.by_level)
      while (plan.level_ranges.size() <= place.level)
        plan.level_ranges.push_back(static_cast<std::uint32_t>(plan.ranges.size()));
    if (begins) plan.ranges.push_back({place.kind, path, false, end_of(path), end_of(path), place.level});
    if (path == JointPath::scalar)
      plan.scalar.push_back(i);
    else
      add_to_batches(path == JointPath::revolute ? plan.revolutes : plan.driven_revolutes, i,
                     plan.in_levels ? place.level : 0, begins);
    plan.ranges.back().last = end_of(path);
    plan.ranges.back().springs |= path != JointPath::revolute && has_springs(model.joints[place.joint]);
  }
  plan.level_ranges.push_back(static_cast<std::uint32_t>(plan.ranges.size()));
}

}  // namespace

void plan_joints(const Model& model, const State& state, Scratch& scratch) {
  JointPlan& plan = scratch.caches.joints;
  const bool is_of_scene = follows_from_scene(model, state);
  const bool is_hit = is_of_scene && plan.is_of_scene;
  plan.count(is_hit);
  if (is_hit) return;
  plan.is_of_scene = is_of_scene;
  order_joints(model, state, scratch, is_of_scene && allows_wavefront(model));
  // Several threads or a wavefront sweep need ranges that end with levels.
  plan.by_level = plan.in_levels && (scratch.parallel.runner != nullptr || plan.uses_wavefront);
  make_ranges(model, plan);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
