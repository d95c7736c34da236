// Islands as stages see them: connected bodies, named by their first row.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/islands/union_find.h"
#include "engine/model/model.h"
#include "engine/model/poison.h"
#include "engine/model/stage.h"
#include "engine/model/state.h"
#include "engine/model/tick_lists.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// What bodies carry, and how far that moves them at four substeps.
struct LoadEstimate {
  std::vector<Real> load;            // [body] N
  std::vector<Real> position_error;  // [body] m
  std::vector<Real> local_error;     // [body] against what carries it alone, relative to the size of the smaller
};

template <typename Visit>
void list_fields(LoadEstimate& of, const Visit& visit) {
  auto& [load, position_error, local_error] = of;
  visit(load, position_error, local_error);
}

/// What the search for islands works in during a tick.
struct IslandWork {
  std::vector<BodyType> body_types;        // [body]
  std::vector<std::uint32_t> set_keys;     // [body] what decides its solver set
  std::vector<std::uint8_t> island_awake;  // [body] at the island's first row
  std::vector<std::uint32_t> part_counts;  // [chunk]
  std::vector<Support> supports;
  std::vector<std::uint32_t> support_start;  // [body] in `supports`
  std::vector<std::uint32_t> support_depth;  // [body] steps from what carries it
  std::vector<std::uint32_t> support_order;  // bodies by depth
  std::vector<Real> joint_acceleration;      // [body] m/s^2, of the joints that it whirls at
  std::vector<Vec2> load_moment;             // [body] N m, load times where it is
  std::vector<Real> load_passed_on;          // [body] N, of what others have put on it
  std::vector<TiltError> tilt_errors;        // [body] expected at four substeps
  LoadEstimate weights;                      // as weights and known forces tell
  LoadEstimate measured;
  std::vector<std::uint8_t> is_floating;      // [body] nothing immovable carries it; empty unless loads are measured
  std::vector<Real> known_force;              // [body] N, besides weights; empty unless loads are measured
  std::vector<Real> measured_force;           // [body] N, of what carries it
  std::vector<std::uint32_t> measured_level;  // likewise
  std::vector<std::uint32_t> measured_level_before;  // likewise, of the tick before
  std::vector<IslandError> island_errors;            // [body] at the island's first row
  std::vector<std::uint32_t> substeps_before;        // [body] at the island's first row
  std::vector<std::uint32_t> idle_ticks;             // likewise
};

template <typename Visit>
void list_fields(IslandWork& of, const Visit& visit) {
  auto& [body_types, set_keys, island_awake, part_counts, supports, support_start, support_depth, support_order,
         joint_acceleration, load_moment, load_passed_on, tilt_errors, weights, measured, is_floating, known_force,
         measured_force, measured_level, measured_level_before, island_errors, substeps_before, idle_ticks] = of;
  visit(body_types, set_keys, island_awake, part_counts, supports, support_start, support_depth, support_order,
        joint_acceleration, load_moment, load_passed_on, tilt_errors, weights, measured, is_floating, known_force,
        measured_force, measured_level, measured_level_before, island_errors, substeps_before, idle_ticks);
}

/// The stage that decides which bodies sleep, which are solved together, and in how many substeps.
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

inline std::uint32_t row_of(const State& state, std::uint32_t id) {
  return static_cast<std::uint32_t>(state.find_body(id));
}

/// How many substeps each island gets: tick.island_level, state.substeps; and which of them something lands on.
/// Requires: islands are united.
void choose_substeps(const Model& model, State& state, TickLists& tick, IslandWork& work, Real dt);

/// Finds the contacts that will hit bodies at rest in this tick, and their islands. Requires: tick.load tells what is
/// carried, and tick.island_level is that of the tick.
void find_resting_impacts(const Model& model, const State& state, TickLists& tick, Real dt);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
