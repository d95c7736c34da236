// What an impulse at a point does to whole islands of jointed bodies.
// SPDX-License-Identifier: MIT
//
// Impacts are those of rigid rows: springs, motors and limits act later.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/joints/direct/direct_set.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

inline constexpr std::uint32_t no_impact_place = 0xffffffff;

/// Neighbouring places of an ImpactIslands: that of a free body, or those of the moving bodies of an island.
struct ImpactBodies {
  std::uint32_t first = 0;
  std::uint32_t count = 0;  // 0: the body does not move
  std::uint32_t component = DirectComponents::none;
};

/// The two bodies at a point, and the islands that hold them.
struct ImpactEnds {
  std::array<std::uint32_t, 2> places = {no_impact_place, no_impact_place};  // if the body moves
  std::array<ImpactBodies, 2> parts{};  // the second is empty if both bodies are in one island
};

/// A row of a point: its normal or its tangent.
struct ImpactRow {
  std::array<Triple, 2> along{};  // [body] the gradient of the row's speed
  double impulse = 0;             // N s
  double mobility = -1;           // 1/kg; below 0: not computed yet
  std::uint32_t response = 0;     // in ImpactIslands::responses, of both parts one after the other
};

/// Islands with points, and the other bodies at these points.
struct ImpactIslands {
  std::vector<std::uint32_t> components;    // islands that are touched
  std::vector<std::uint32_t> point_counts;  // [component]
  std::vector<std::uint32_t> rows;          // [place] the body
  std::vector<std::uint32_t> places;        // [body]
  std::vector<Triple> responses;            // changes of velocities per impulse
  std::vector<std::uint8_t> is_factored;    // [component] for impacts located in time: its rigid rows are factored
};

template <typename Visit>
void list_fields(ImpactIslands& of, const Visit& visit) {
  auto& [components, point_counts, rows, places, responses, is_factored] = of;
  visit(components, point_counts, rows, places, responses, is_factored);
}

/// Removes all islands and points.
void clear_islands(const SolvedSet& solved, const DirectWorkspace& direct, ImpactIslands& out);
/// Counts points of a pair of bodies. All points are counted before the first call of the next functions.
void count_points(const DirectWorkspace& direct, std::uint32_t body_a, std::uint32_t body_b, std::uint32_t count,
                  ImpactIslands& out);
/// Whether an impact meets the island of the body. Otherwise no joint holds the body, or its island has too many
/// points, and the impact meets the body alone.
bool meets_island(const DirectWorkspace& direct, std::uint32_t body, const ImpactIslands& islands);
/// Finds the places of two bodies, and adds what is new. Requires: one of the bodies meets its island.
ImpactEnds find_ends(const SolvedSet& solved, const DirectWorkspace& direct, std::uint32_t body_a, std::uint32_t body_b,
                     ImpactIslands& out);
/// Computes how a row's impulse changes velocities. Its mobility is 0 where joints hold almost all of it. Requires: the
/// rigid rows of the islands are factored.
void find_response(const SolvedSet& solved, DirectWorkspace& direct, const ImpactEnds& ends, ImpactRow& row,
                   ImpactIslands& out);
/// The velocity change of a body, per impulse of the row. Requires: find_response.
const Triple& response_at(const ImpactEnds& ends, const ImpactRow& row, std::size_t side, const ImpactIslands& islands);

/// The speed that a body's velocity gives a row, or the velocity change that an impulse along it gives.
inline double dot_product(const Triple& a, const Triple& b) {
  return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
