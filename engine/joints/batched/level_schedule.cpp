// The level schedule of a wavefront sweep.
// SPDX-License-Identifier: MIT
// Source: Bellman, "On a Routing Problem", 1958 (relaxation until nothing changes).
#include "engine/joints/batched/level_schedule.h"

#include "engine/joints/joint_order.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

// Fewer joints stay in the nearest cache, and one thread finishes before a second thread has started.
constexpr std::size_t joint_count_least = 1024;
// With fewer levels per distance, too few passes run at the same time.
constexpr std::uint32_t distances_least = 8;
constexpr int iteration_count_max = 8;

/// Calls `use` with each dynamic body of a joint.
template <typename Use>
void for_dynamic_bodies(const SolverBodies& bodies, const JointPlace& place, Use use) {
  const std::uint32_t sink = dummy_sink(bodies);
  if (place.body_a != no_reference && bodies.masses[place.body_a].write != sink) use(place.body_a);
  if (bodies.masses[place.body_b].write != sink) use(place.body_b);
}

/// Whether a joint is attached to a kinematic body.
bool joins_kinematic(const SolverBodies& bodies, const JointOrder& order) {
  const std::uint32_t sink = dummy_sink(bodies);
  const auto is_kinematic = [&](std::uint32_t row) {
    return bodies.masses[row].write == sink && bodies.masses[row].read == row;
  };
  for (const JointPlace& place : order.places)
    if (is_kinematic(place.body_b) || (place.body_a != no_reference && is_kinematic(place.body_a))) return true;
  return false;
}

/// Finds the first and the last joint of each body. Returns the largest number of joints of one body.
std::uint32_t find_body_joints(const SolverBodies& bodies, const JointOrder& order, JointOrderWork& work) {
  const std::vector<JointPlace>& places = order.places;
  std::uint32_t most = 0;
  work.body_joints.assign(bodies.masses.size(), {});
  for (std::uint32_t i = 0; i < places.size(); ++i)
    for_dynamic_bodies(bodies, places[i], [&](std::uint32_t row) {
      BodyJoints& joints = work.body_joints[row];
      if (joints.count++ == 0) joints.first = i;
      joints.last = i;
      most = joints.count > most ? joints.count : most;
    });
  return most;
}

/// Raises each joint above the earlier joints that share a dynamic body with it. A first joint of a body is also raised
/// to less than `distance` below the last one. True if no level changed.
bool raise_levels(const SolverBodies& bodies, std::uint32_t distance, JointOrderWork& work, JointOrder& order) {
  std::vector<std::uint32_t>& next = work.body_levels;
  next.assign(bodies.masses.size(), 0);
  bool fits = true;
  for (std::uint32_t i = 0; i < order.places.size(); ++i) {
    JointPlace& place = order.places[i];
    std::uint32_t level = place.level;
    for_dynamic_bodies(bodies, place, [&](std::uint32_t row) {
      const BodyJoints& joints = work.body_joints[row];
      level = next[row] > level ? next[row] : level;
      if (joints.first != i) return;
      const std::uint32_t last = order.places[joints.last].level;
      if (last >= level + distance) level = last - distance + 1;
    });
    fits = fits && level == place.level;
    place.level = level;
    for_dynamic_bodies(bodies, place, [&](std::uint32_t row) { next[row] = level + 1; });
    if (level >= order.level_count) order.level_count = level + 1;
  }
  return fits;
}

void sort_bodies(const JointOrderWork& work, JointOrder& order) {
  LevelSchedule& schedule = order.schedule;
  std::vector<std::uint32_t>& start = schedule.level_bodies;
  start.assign(std::size_t{order.level_count} + 2, 0);
  const auto first_level = [&](const BodyJoints& joints) { return order.places[joints.first].level; };
  for (const BodyJoints& joints : work.body_joints)
    if (joints.count > 0) ++start[first_level(joints) + 2];
  for (std::size_t i = 2; i < start.size(); ++i) start[i] += start[i - 1];
  schedule.body_rows.resize(start.back());
  for (std::uint32_t row = 0; row < work.body_joints.size(); ++row) {
    const BodyJoints& joints = work.body_joints[row];
    if (joints.count > 0) schedule.body_rows[start[first_level(joints) + 1]++] = row;
  }
  start.pop_back();
}

}  // namespace

bool schedule_levels(const SolvedSet& solved, JointOrderWork& work, JointOrder& order) {
  const SolverBodies& bodies = solved.bodies;
  std::uint32_t& distance = order.schedule.distance;
  const bool is_forced = solved.parallel().chunk_size_forced > 0;
  if ((order.places.size() < joint_count_least && !is_forced) || joins_kinematic(bodies, order)) return false;
  const std::uint32_t level_count = order.level_count;
  work.sorted_places = order.places;
  const std::uint32_t least = find_body_joints(bodies, order, work);
  for (distance = least; is_forced || distance * distances_least <= level_count; distance *= 2) {
    bool fits = false;
    for (int iteration = 0; !fits && iteration < iteration_count_max; ++iteration)
      fits = raise_levels(bodies, distance, work, order);
    if (fits && (is_forced || order.level_count <= level_count + level_count / 8)) {
      sort_bodies(work, order);
      return true;
    }
    order.places = work.sorted_places;
    order.level_count = level_count;
  }
  return false;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
