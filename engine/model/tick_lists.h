// What the stages of one tick hand on to each other. Nothing of it outlives the tick.
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

/// The bodies against those of the tick before, as a broad phase that follows them knows them.
struct BodyChanges {
  bool is_known = false;              // else all of them may be others
  std::uint32_t body_generation = 0;  // another number in each tick that has other bodies than the one before
  // [body] its pose (where contacts are speculative: all of it) has the bits of the tick before
  std::span<const std::uint8_t> is_unchanged;
  bool many_are_unchanged = false;  // of those that are not static
  bool any_swept = false;           // some body may pass through something in this tick
  bool same_pairs = false;          // the pairs are those of the tick before
};

struct TickLists {
  Parallel parallel;                                                            // the engine's
  std::size_t pair_count_max = limits::pair_count_max(limits::body_count_max);  // of this tick

  // By the inputs.
  std::vector<Input> inputs;
  std::vector<Vec2> force;                 // [body] N, from this tick's inputs; empty if there are none
  std::vector<Real> torque;                // [body] N m
  std::vector<TouchRow> removed_touching;  // rows of bodies that were removed in this tick
  std::vector<TouchRow> removed_sensors;
  std::optional<InjectedFault> injected;  // for this tick

  // By the broad phase.
  std::span<const Proxy> proxies;
  std::span<const Pair> pairs;      // by (first, second)
  bool has_too_many_pairs = false;  // more than pair_count_max boxes overlap: none are listed, the tick cannot be done
  BodyChanges changes;

  // By the narrow phase.
  std::span<const ContactPair> contact_pairs;  // row by row those of State::contacts
  std::uint32_t contact_generation = 0;  // another number in each tick that has other contacts than the one before

  // By the search for impacts.
  std::vector<ImpactPair> impacts;  // that may come in this tick

  // By the islands.
  bool has_solver_sets = false;                // else everything will be one set
  std::vector<SolverSet> solver_sets;          // ascending by substeps; sleeping islands are in none
  std::vector<std::uint32_t> set_rows;         // bodies that move, of each set; kinematic ones are in all of them
  std::vector<std::uint32_t> set_contacts;     // in `contact_pairs`
  std::vector<std::uint32_t> body_solver_set;  // [body] index in `solver_sets`; no_solver_set: asleep or static
  std::vector<std::uint32_t> island_parent;    // [body] union-find
  std::vector<std::uint32_t> island_level;     // [body] at the island's first row: substeps
  std::vector<std::uint8_t> island_has_resting_impact;  // [body] at the island's first row
  std::vector<RestingImpact> resting_impacts;
  std::uint32_t shock_work_left = 0;  // contacts that may still be solved for resting impacts in this tick
  std::vector<Real> load;             // [body] N
  std::vector<Real> mass_factor;      // [body] how much heavier constraints see it; with automatic substeps
};

/// All but what the caller sets for a tick: `parallel`, `pair_count_max`, `inputs` and `injected`.
template <typename Visit>
void list_fields(TickLists& of, const Visit& visit) {
  auto& [parallel, pair_count_max, inputs, force, torque, removed_touching, removed_sensors, injected, proxies, pairs,
         has_too_many_pairs, changes, contact_pairs, contact_generation, impacts, has_solver_sets, solver_sets,
         set_rows, set_contacts, body_solver_set, island_parent, island_level, island_has_resting_impact,
         resting_impacts, shock_work_left, load, mass_factor] = of;
  visit(force, torque, removed_touching, removed_sensors, proxies, pairs, has_too_many_pairs, changes, contact_pairs,
        contact_generation, impacts, has_solver_sets, solver_sets, set_rows, set_contacts, body_solver_set,
        island_parent, island_level, island_has_resting_impact, resting_impacts, shock_work_left, load, mass_factor);
}

/// What a stage finds where the stages before it that would write it are left out.
void begin_tick(TickLists& tick);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
