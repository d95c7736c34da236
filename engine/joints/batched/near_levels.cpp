// Raising of levels.
// SPDX-License-Identifier: MIT
// Source: Bellman, "On a Routing Problem", 1958 (relaxation until nothing changes).
#include "engine/joints/batched/near_levels.h"

#include "engine/model/bodies.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

// Fewer joints stay in the nearest cache, and are done before another thread has begun.
constexpr std::size_t joint_count_least = 1024;
// With fewer levels between a pass and the next, few passes are in work at a time.
constexpr std::uint32_t distances_least = 8;
constexpr int iteration_count_max = 8;

/// Calls `use` with the bodies that a joint moves.
template <typename Use>
void for_movers(const Scratch& scratch, const JointPlace& place, Use use) {
  const std::uint32_t unread = unread_record(scratch);
  if (place.body_a != no_reference && scratch.masses[place.body_a].write != unread) use(place.body_a);
  if (scratch.masses[place.body_b].write != unread) use(place.body_b);
}

/// Whether a joint reads a body that moves without it.
bool joins_kinematic(const Scratch& scratch) {
  const std::uint32_t unread = unread_record(scratch);
  const auto is_kinematic = [&](std::uint32_t row) {
    return scratch.masses[row].write == unread && scratch.masses[row].read == row;
  };
  for (const JointPlace& place : scratch.caches.joints.places)
    if (is_kinematic(place.body_b) || (place.body_a != no_reference && is_kinematic(place.body_a))) return true;
  return false;
}

/// Notes the first and the last joint of each body. Returns the most joints that one has.
std::uint32_t find_ends(Scratch& scratch) {
  const std::vector<JointPlace>& places = scratch.caches.joints.places;
  std::uint32_t most = 0;
  scratch.joint_ends.assign(scratch.masses.size(), {});
  for (std::uint32_t i = 0; i < places.size(); ++i)
    for_movers(scratch, places[i], [&](std::uint32_t row) {
      JointEnds& ends = scratch.joint_ends[row];
      if (ends.count++ == 0) ends.first = i;
      ends.last = i;
      most = ends.count > most ? ends.count : most;
    });
  return most;
}

/// Each joint above those before it that move a body of its own, and not farther below a body's last one than
/// `distance` allows. True if nothing had to be raised.
bool raise_levels(Scratch& scratch, std::uint32_t distance) {
  JointPlan& plan = scratch.caches.joints;
  std::vector<std::uint32_t>& next = scratch.body_levels;
  next.assign(scratch.masses.size(), 0);
  bool is_near = true;
  for (std::uint32_t i = 0; i < plan.places.size(); ++i) {
    JointPlace& place = plan.places[i];
    std::uint32_t level = place.level;
    for_movers(scratch, place, [&](std::uint32_t row) {
      const JointEnds& ends = scratch.joint_ends[row];
      level = next[row] > level ? next[row] : level;
      if (ends.first != i) return;
      const std::uint32_t last = plan.places[ends.last].level;
      if (last >= level + distance) level = last - distance + 1;
    });
    is_near = is_near && level == place.level;
    place.level = level;
    for_movers(scratch, place, [&](std::uint32_t row) { next[row] = level + 1; });
    if (level >= plan.level_count) plan.level_count = level + 1;
  }
  return is_near;
}

void sort_bodies(Scratch& scratch) {
  JointPlan& plan = scratch.caches.joints;
  std::vector<std::uint32_t>& start = plan.level_bodies;
  start.assign(std::size_t{plan.level_count} + 2, 0);
  const auto first_level = [&](const JointEnds& ends) { return plan.places[ends.first].level; };
  for (const JointEnds& ends : scratch.joint_ends)
    if (ends.count > 0) ++start[first_level(ends) + 2];
  for (std::size_t i = 2; i < start.size(); ++i) start[i] += start[i - 1];
  plan.body_rows.resize(start.back());
  for (std::uint32_t row = 0; row < scratch.joint_ends.size(); ++row) {
    const JointEnds& ends = scratch.joint_ends[row];
    if (ends.count > 0) plan.body_rows[start[first_level(ends) + 1]++] = row;
  }
  start.pop_back();
}

}  // namespace

bool draw_near(Scratch& scratch) {
  JointPlan& plan = scratch.caches.joints;
  const bool is_forced = scratch.parallel.chunk_size_forced > 0;
  if ((plan.places.size() < joint_count_least && !is_forced) || joins_kinematic(scratch)) return false;
  const std::uint32_t level_count = plan.level_count;
  scratch.sorted_places = plan.places;
  const std::uint32_t least = find_ends(scratch);
  for (plan.distance = least; is_forced || plan.distance * distances_least <= level_count; plan.distance *= 2) {
    bool is_near = false;
    for (int sweep = 0; !is_near && sweep < iteration_count_max; ++sweep)
      is_near = raise_levels(scratch, plan.distance);
    if (is_near && (is_forced || plan.level_count <= level_count + level_count / 8)) {
      sort_bodies(scratch);
      return true;
    }
    plan.places = scratch.sorted_places;
    plan.level_count = level_count;
  }
  return false;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
