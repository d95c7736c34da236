// Islands of connected bodies, named by their first row, as stages use them.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>

#include "engine/joints/direct/direct_components.h"
#include "engine/math/union_find.h"
#include "engine/model/model.h"
#include "engine/model/poison.h"
#include "engine/model/stage.h"
#include "engine/model/state.h"
#include "engine/model/tick_lists.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The loads of bodies, and the resulting displacements at four substeps.
struct LoadEstimate {
  std::vector<Real> load;            // [body] N
  std::vector<Real> position_error;  // [body] m
  std::vector<Real> local_error;     // [body] at its nearest support alone, relative to the smaller body
};

template <typename Visit>
void list_fields(LoadEstimate& of, const Visit& visit) {
  auto& [load, position_error, local_error] = of;
  visit(load, position_error, local_error);
}

/// Known forces that have a direction, and what they press together.
struct DirectedForces {
  std::vector<Vec2> force;            // [body] N; empty unless loads are measured
  std::vector<std::uint8_t> is_done;  // [body] its force is in the estimate
  std::vector<Real> island_force;     // [body] N, at the island's first row: along the present direction
  std::vector<Real> island_mass;      // [body] kg, at the island's first row: of what is ahead
  std::vector<Real> error;            // [body] m, along the present direction
  std::vector<Real> resistance;       // [body] N, the most that it and what is ahead of it can push back with
};

template <typename Visit>
void list_fields(DirectedForces& of, const Visit& visit) {
  auto& [force, is_done, island_force, island_mass, error, resistance] = of;
  visit(force, is_done, island_force, island_mass, error, resistance);
}

/// What kinematic bodies do to an island by its contacts, W.
struct CrushPower {
  Real supplied;
  Real stored;  // in contacts that give way
};

/// The workspace of the search for islands in a tick.
struct IslandWork {
  std::vector<BodyType> body_types;           // [body]
  std::vector<std::uint32_t> set_keys;        // [body] the key of its solver set
  std::vector<std::uint8_t> island_awake;     // [body] at the island's first row
  std::vector<std::uint8_t> island_carried;   // [body] at the island's first row; empty unless islands are held
  std::size_t dynamic_count = 0;              // bodies
  bool all_are_held = false;                  // no island is solved in this tick
  std::vector<std::uint32_t> awake_rows;      // dynamic bodies of the islands that are solved
  std::vector<std::uint32_t> awake_contacts;  // of these bodies, in TickLists::contact_pairs
  std::vector<std::uint32_t> part_counts;     // [chunk]
  std::vector<Support> supports;
  std::vector<std::uint32_t> support_start;  // [body] its first in `supports`, and the end
  std::vector<std::uint32_t> support_depth;  // [body] steps from the ground or the heaviest floating body
  std::vector<std::uint32_t> support_order;  // bodies by depth
  std::vector<Real> joint_acceleration;      // [body] m/s^2, of its joints by rotation
  std::vector<Vec2> load_moment;             // [body] N m, the sum of supported loads times their positions
  std::vector<Real> load_passed_on;          // [body] N, the load from other bodies
  std::vector<TiltError> tilt_errors;        // [body] expected at four substeps
  LoadEstimate weights;                      // from weights and known forces
  LoadEstimate measured;
  LoadEstimate pushes;                   // by kinematic bodies, then by directed forces
  std::vector<Real> friction;            // [body] the largest of its contacts
  std::vector<std::uint32_t> pushed;     // bodies ahead of a kinematic one
  std::vector<std::uint32_t> pushed_by;  // [body] which of them pushes it
  DirectedForces directed;
  std::vector<std::uint8_t> is_floating;      // [body] no immovable body carries it; empty unless loads are measured
  std::vector<Real> known_force;              // [body] N, besides weights; empty unless loads are measured
  std::vector<Real> measured_force;           // [body] N, of its carriers
  std::vector<std::uint32_t> measured_level;  // [body] at the island's first row
  std::vector<std::uint32_t> measured_level_before;  // [body] at the island's first row, of the tick before
  std::vector<CrushPower> crush;                     // [body] at the island's first row; where something pushes
  std::vector<std::uint32_t> needed_level;           // [body] at the island's first row, of this tick
  std::vector<std::uint32_t> first_level;            // [body] at the island's first row, of unmeasured joints or 0
  std::vector<IslandError> island_errors;            // [body] at the island's first row
  std::vector<std::uint32_t> substeps_before;        // [body] at the island's first row
  std::vector<std::uint32_t> idle_ticks;             // [body] at the island's first row
  DirectMarks direct;                                // empty unless loads are measured and joints are direct
  std::vector<Real> sway;                            // [body] 1/s^2, of bodies on direct joints
  std::vector<Real> turn;                            // [body] 1/s, of bodies on direct joints and of their rods
  std::vector<Real> strike;                          // [body] 1/s, of what will hit it in this tick
  std::vector<std::uint8_t> has_direct;              // [body] at the island's first row: it has direct joints
  std::vector<std::uint64_t> island_work;            // [body] at the island's first row, of a substep
};

template <typename Visit>
void list_fields(IslandWork& of, const Visit& visit) {
  auto& [body_types, set_keys, island_awake, island_carried, dynamic_count, all_are_held, awake_rows, awake_contacts,
         part_counts, supports, support_start, support_depth, support_order, joint_acceleration, load_moment,
         load_passed_on, tilt_errors, weights, measured, pushes, friction, pushed, pushed_by, directed, is_floating,
         known_force, measured_force, measured_level, measured_level_before, crush, needed_level, first_level,
         island_errors, substeps_before, idle_ticks, direct, sway, turn, strike, has_direct, island_work] = of;
  visit(body_types, set_keys, island_awake, island_carried, dynamic_count, all_are_held, awake_rows, awake_contacts,
        part_counts, supports, support_start, support_depth, support_order, joint_acceleration, load_moment,
        load_passed_on, tilt_errors, weights, measured, pushes, friction, pushed, pushed_by, directed, is_floating,
        known_force, measured_force, measured_level, measured_level_before, crush, needed_level, first_level,
        island_errors, substeps_before, idle_ticks, direct, sway, turn, strike, has_direct, island_work);
}

/// The stage that decides which bodies sleep, which bodies are solved together, and in how many substeps.
class IslandFinder final : public Stage {
 public:
  void run(const Model& model, State& state, TickLists& tick, Real dt) override;
  void poison() override { list_fields(work_, Poison{}); }

 private:
  IslandWork work_;
};

inline BodyType type_of(const Model& model, const State& state, std::uint32_t row) {
  return model.bodies[state.bodies[row].source].type;
}

/// Requires: work.body_types is of this tick.
inline bool is_dynamic(const IslandWork& work, std::uint32_t row) {
  return work.body_types[row] == BodyType::dynamic_body;
}

/// Whether a body is in an island that is solved in this tick. Requires: work.island_awake is of this tick.
inline bool is_awake(const TickLists& tick, const IslandWork& work, std::uint32_t row) {
  return is_dynamic(work, row) && work.island_awake[tick.island[row]] != 0;
}

/// Whether an immovable body may move what it touches: it moves, was made in this tick, or moved in the tick before.
/// Requires: work.body_types is of this tick.
inline bool disturbs(const State& state, const TickLists& tick, const IslandWork& work, std::uint32_t row) {
  const BodyRow& body = state.bodies[row];
  return !is_dynamic(work, row) && (is_moving(body) || body.id >= tick.first_new_id ||
                                    std::binary_search(tick.moved_before.begin(), tick.moved_before.end(), body.id));
}

inline std::uint32_t row_of(const State& state, std::uint32_t id) {
  return static_cast<std::uint32_t>(state.find_body(id));
}

/// Whether islands at rest are held: with measured loads, in scenes without sleep.
bool holds_islands(const Model& model);

/// Holds the islands at rest: work.island_awake is 0 at their first rows, and their velocities are zero. Measures how
/// long bodies have been calm, and sets work.all_are_held. Requires: holds_islands, islands are united.
void hold_islands(const Model& model, State& state, TickLists& tick, IslandWork& work, Real dt);

/// Chooses the substeps of each island: tick.island_level, state.substeps. Finds the islands with resting impacts.
/// Requires: islands are united.
void choose_substeps(const Model& model, State& state, TickLists& tick, IslandWork& work, Real dt);

/// Finds the contacts that will hit bodies at rest in this tick, and their islands. Requires: tick.load has the
/// supported loads, and tick.island_level is of this tick.
void find_resting_impacts(const Model& model, const State& state, TickLists& tick, const IslandWork& work, Real dt);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
