// Levels of joints, and the decision whether batches pay.
// SPDX-License-Identifier: MIT
#include "engine/joints/joint_order.h"

#include "engine/joints/batched/level_schedule.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// A batch costs about as much as one joint of the scalar path, so two joints per level already pay.
constexpr std::size_t joints_per_level_least = 2;

/// Batches have no way to leave out springs and motors, as integrators with a drift velocity want it (joint_changes.h
/// in solvers/).
JointPath path_of(const JointModel& joint, bool has_drift) {
  if (joint.is_plain_revolute) return JointPath::revolute;
  return joint.is_driven_revolute && !has_drift ? JointPath::driven_revolute : JointPath::scalar;
}

/// Sorts the places by level and path, stable.
void sort_by_level(JointOrderWork& work, JointOrder& order) {
  std::vector<JointPlace>& places = order.places;
  std::vector<std::uint32_t>& start = work.level_starts;
  start.assign(joint_path_count * static_cast<std::size_t>(order.level_count) + 1, 0);
  const auto key_of = [](const JointPlace& place) {
    return joint_path_count * place.level + static_cast<std::uint32_t>(place.path);
  };
  for (const JointPlace& place : places) ++start[key_of(place) + 1];
  for (std::size_t i = 1; i < start.size(); ++i) start[i] += start[i - 1];
  work.sorted_places.resize(places.size());
  for (const JointPlace& place : places) work.sorted_places[start[key_of(place)]++] = place;
  places.swap(work.sorted_places);
}

}  // namespace

std::uint32_t row_of_body(const State& state, std::uint32_t id) {
  const bool is_row = id < state.bodies.size() && state.bodies[id].id == id;
  return is_row ? id : static_cast<std::uint32_t>(state.find_body(id));
}

void order_joints(const SolvedSet& solved, bool may_use_wavefront, std::span<const std::uint8_t> left_out,
                  JointOrderWork& work, JointOrder& out) {
  const Model& model = solved.model;
  const State& state = solved.state;
  const std::vector<BodyMass>& masses = solved.bodies.masses;
  const std::uint32_t sink = dummy_sink(solved.bodies);
  // Of the integrators that carry joints, this one alone moves bodies with the end velocity.
  const bool has_drift = model.scene.settings.integrator != IntegratorKind::semi_implicit_euler;
  out.places.clear();
  out.level_count = 0;
  out.schedule.exists = false;
  work.body_levels.assign(state.bodies.size(), 0);
  std::size_t in_batches = 0;
  for (std::uint32_t i = 0; i < state.joints.size(); ++i) {
    if (!left_out.empty() && left_out[i] != 0) continue;
    const JointModel& joint = model.joints[state.joints[i].joint];
    if (joint.gear != no_gear) continue;  // solved after all other joints
    const std::uint32_t b = row_of_body(state, state.joints[i].body_b);
    const std::uint32_t a = joint.body_a == no_reference ? no_reference : row_of_body(state, joint.body_a);
    const bool b_moves = masses[b].write != sink;
    const bool a_moves = a != no_reference && masses[a].write != sink;
    if (!a_moves && !b_moves) continue;
    if (!solved.has_body(b_moves ? b : a)) continue;
    std::uint32_t level = 0;
    if (a_moves) level = work.body_levels[a];
    if (b_moves && work.body_levels[b] > level) level = work.body_levels[b];
    if (a_moves) work.body_levels[a] = level + 1;
    if (b_moves) work.body_levels[b] = level + 1;
    if (level >= out.level_count) out.level_count = level + 1;
    const JointPath path = path_of(joint, has_drift);
    in_batches += path == JointPath::scalar ? 0u : 1u;
    out.places.push_back({i, state.joints[i].joint, a, b, level, joint.kind, path, joint.anchor_a, joint.anchor_b});
  }
  out.in_levels = in_batches > 0 && in_batches >= joints_per_level_least * out.level_count;
  if (!out.in_levels) return;
  out.schedule.exists = may_use_wavefront && schedule_levels(solved, work, out);
  sort_by_level(work, out);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
