// The data that stages of one tick pass on to each other. None of it outlives the tick.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/limits.h"
#include "base/parallel/parallel.h"
#include "engine/impacts/impact_rows.h"
#include "engine/islands/island_rows.h"
#include "engine/model/body_rows.h"
#include "engine/model/contact_pairs.h"
#include "engine/model/proxies.h"
#include "engine/model/state.h"
#include "engine/scene/input.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The changes of bodies since the tick before, from a broad phase that follows bodies.
struct BodyChanges {
  bool is_known = false;              // false: any body may have changed
  std::uint32_t body_generation = 0;  // a different number whenever the set of bodies has changed
  // [body] its pose (where contacts are speculative: all of it) has the bits of the tick before
  std::span<const std::uint8_t> is_unchanged;
  bool many_are_unchanged = false;  // of the bodies that are not static
  bool any_swept = false;           // some body may pass through something in this tick
  bool same_pairs = false;          // the pairs are those of the tick before
};

struct TickLists {
  Parallel parallel;                                                            // the engine's
  std::size_t pair_count_max = limits::pair_count_max(limits::body_count_max);  // of this tick

  // Written by the inputs.
  std::vector<Input> inputs;
  std::uint32_t first_new_id = no_reference;  // ids from here on were given to bodies in this tick
  std::vector<std::uint32_t> moved_before;    // kinematic bodies whose velocity inputs have set, ascending ids
  std::vector<Vec2> force;                    // [body] N, from this tick's inputs; empty if there are none
  std::vector<Real> torque;                   // [body] N m
  std::vector<TouchRow> removed_touching;     // rows of bodies that were removed in this tick
  std::vector<TouchRow> removed_sensors;
  std::optional<InjectedFault> injected;  // for this tick

  // Written by the broad phase.
  std::span<const Proxy> proxies;
  std::span<const Pair> pairs;      // by (first, second)
  bool has_too_many_pairs = false;  // more than pair_count_max boxes overlap: no pair is listed and the tick fails
  BodyChanges changes;

  // Written by the narrow phase.
  std::span<const ContactPair> contact_pairs;  // parallel to State::contacts
  std::uint32_t contact_generation = 0;        // a different number whenever the contacts have changed

  // Written by the solver.
  std::vector<Real> travel;                // [body] m: the farthest way of a point in this tick; if the scene sleeps
  std::vector<std::uint32_t> deep_counts;  // [body] deep overlaps with moving bodies; empty without a crowd

  // Written by the search for impacts.
  std::vector<ImpactPair> impacts;  // pairs that may hit in this tick

  // Written by the islands.
  bool has_solver_sets = false;                // false: all bodies will be in one set
  std::vector<SolverSet> solver_sets;          // ascending by substeps; sleeping islands are in none
  std::vector<std::uint32_t> set_rows;         // moving bodies of each set; kinematic bodies are in all sets
  std::vector<std::uint32_t> set_contacts;     // in `contact_pairs`
  std::vector<std::uint32_t> body_solver_set;  // [body] index in `solver_sets`; no_solver_set: asleep or static
  std::vector<std::uint32_t> island;           // [body] the first row of its island
  std::vector<std::uint32_t> island_level;     // [body] at the island's first row: substeps
  std::vector<std::uint8_t> island_has_resting_impact;  // [body] at the island's first row
  std::vector<RestingImpact> resting_impacts;
  std::uint64_t shock_work_left = 0;  // contacts that may still be solved for resting impacts in this tick
  bool shock_is_cut = false;          // a shock was left before it had settled, by the scene's budget
  std::vector<Real> load;             // [body] N
  std::vector<Real> mass_factor;      // [body] factor of its mass for constraints; with automatic substeps
};

/// All fields except those that the caller sets for a tick: `parallel`, `pair_count_max`, `inputs` and `injected`.
template <typename Visit>
void list_fields(TickLists& of, const Visit& visit) {
  auto& [parallel, pair_count_max, inputs, first_new_id, moved_before, force, torque, removed_touching, removed_sensors,
         injected, proxies, pairs, has_too_many_pairs, changes, contact_pairs, contact_generation, travel, deep_counts,
         impacts, has_solver_sets, solver_sets, set_rows, set_contacts, body_solver_set, island, island_level,
         island_has_resting_impact, resting_impacts, shock_work_left, shock_is_cut, load, mass_factor] = of;
  visit(first_new_id, moved_before, force, torque, removed_touching, removed_sensors, proxies, pairs,
        has_too_many_pairs, changes, contact_pairs, contact_generation, travel, deep_counts, impacts, has_solver_sets,
        solver_sets, set_rows, set_contacts, body_solver_set, island, island_level, island_has_resting_impact,
        resting_impacts, shock_work_left, shock_is_cut, load, mass_factor);
}

/// Sets the lists as they are if the stages that write them are left out.
void begin_tick(TickLists& tick);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
