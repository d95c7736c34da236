// Impacts located in time: fast bodies that would pass through others within a substep, and exact bounces.
// SPDX-License-Identifier: MIT
//
// Within a substep, bodies follow parabolas. The earliest impact gets its impulse, and the two bodies continue from
// there, until no impact is left. Impacts of one substep thus happen in order of time. The contact solver has resting
// and sliding contacts.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/impacts/impact_rows.h"
#include "engine/impacts/island_response.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct DriftVelocities;
struct Model;
struct SolvedSet;
struct State;
struct TickLists;

/// Whether the contact solver leaves a contact that bounces to the impacts, in a scene whose impacts are located. It
/// keeps contacts that carry a force, and contacts that touch and close too slowly to bounce. The solver would brake a
/// body that is about to bounce to the speed at which it just arrives in a substep. `contact`: in
/// TickLists::contact_pairs and State::contacts.
bool is_left_to_impacts(const Model& model, const State& state, const TickLists& tick, std::uint32_t contact);
/// ImpactPair::slow of a pair. `contact`: as for is_left_to_impacts, or the number of contacts if the pair has none.
Real slow_closing(const Model& model, const State& state, const TickLists& tick, const ImpactPair& pair,
                  std::uint32_t contact, Real dt);

struct ImpactWorkspace {
  std::vector<ImpactPath> paths;         // [body], for bodies of the pairs
  std::vector<std::uint32_t> hit_rows;   // in the present substep
  std::vector<std::uint32_t> active;     // pairs of the set that is being solved
  std::vector<ImpactEvent> events;       // a heap, earliest first
  std::vector<std::uint32_t> starts;     // [body] in `of_bodies`
  std::vector<std::uint32_t> of_bodies;  // active pairs of each dynamic body
  ImpactIslands islands;                 // of jointed bodies of active pairs
  std::vector<Triple> velocities;        // of an island
};

template <typename Visit>
void list_fields(ImpactWorkspace& of, const Visit& visit) {
  auto& [paths, hit_rows, active, events, starts, of_bodies, islands, velocities] = of;
  visit(paths, hit_rows, active, events, starts, of_bodies, islands, velocities);
}

/// Lists the pairs of the set that is being solved, and saves velocities before a substep. Call before the integrator
/// predicts. `impacts`: TickLists::impacts.
void begin_impacts(const SolvedSet& solved, const std::vector<ImpactPair>& impacts, const DirectWorkspace& direct,
                   ImpactWorkspace& work);
/// Finds and applies the impacts of the set in a substep. What hits a jointed body meets the whole island. Call after
/// the integrator's prediction.
void apply_impacts(const SolvedSet& solved, std::vector<ImpactPair>& impacts, DriftVelocities& drift,
                   DirectWorkspace& direct, ImpactWorkspace& work);
/// Brings the bodies that were hit to the ends of their paths, unless apply_impacts has done so. Call after the
/// integrator's drift.
void finish_impacts(const SolvedSet& solved, const ImpactWorkspace& work);
/// Ends the move by which joints carry a body beyond its path where it hits a wall: what is not dynamic. The next
/// substep finds the impact. Call after finish_impacts.
void stop_at_walls(const SolvedSet& solved, const std::vector<ImpactPair>& impacts, const DirectWorkspace& direct,
                   ImpactWorkspace& work);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
