// Responses of islands to impulses, by the factored system of their joints.
// SPDX-License-Identifier: MIT
#include "engine/impacts/island_response.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr double mobility_share = 1e-5;  // of the body alone: joints hold what moves less
/// Points of an island times its bodies. Ropes that lie flat have more: each link meets its own inertia there.
constexpr std::uint64_t response_max = 2048;

/// The island of a body; none: an impact meets the body alone.
std::uint32_t island_of(const DirectWorkspace& direct, std::uint32_t body, const ImpactIslands& islands) {
  const std::uint32_t component = direct.components.component_of(body);
  if (component == DirectComponents::none) return component;
  const std::uint64_t bodies = direct.components.components()[component].moving_count;
  return islands.point_counts[component] * bodies <= response_max ? component : DirectComponents::none;
}

/// Finds the places of a body and of its island. Requires: the body moves.
void find_place(const DirectWorkspace& direct, std::uint32_t body, std::uint32_t& place, ImpactBodies& part,
                ImpactIslands& out) {
  const auto add = [&out](std::uint32_t row) {
    out.places[row] = static_cast<std::uint32_t>(out.rows.size());
    out.rows.push_back(row);
  };
  part = {0, 1, island_of(direct, body, out)};
  if (part.component == DirectComponents::none) {
    if (out.places[body] == no_impact_place) add(body);
    place = part.first = out.places[body];
    return;
  }
  const DirectComponent& component = direct.components.components()[part.component];
  part.count = static_cast<std::uint32_t>(component.moving_count);
  if (out.places[body] == no_impact_place) {
    out.components.push_back(part.component);
    for (std::size_t i = 0; i < component.moving_count; ++i) add(component.bodies[i]);
  }
  part.first = out.places[component.bodies[0]];
  place = out.places[body];
}

}  // namespace

void clear_islands(const SolvedSet& solved, const DirectWorkspace& direct, ImpactIslands& out) {
  out.components.clear();
  out.rows.clear();
  out.responses.clear();
  out.point_counts.assign(direct.components.components().size(), 0);
  if (!out.point_counts.empty()) out.places.assign(solved.bodies.masses.size(), no_impact_place);
}

void count_points(const DirectWorkspace& direct, std::uint32_t body_a, std::uint32_t body_b, std::uint32_t count,
                  ImpactIslands& out) {
  for (const std::uint32_t body : {body_a, body_b})
    if (const std::uint32_t component = direct.components.component_of(body); component != DirectComponents::none)
      out.point_counts[component] += count;
}

bool meets_island(const DirectWorkspace& direct, std::uint32_t body, const ImpactIslands& islands) {
  return island_of(direct, body, islands) != DirectComponents::none;
}

ImpactEnds find_ends(const SolvedSet& solved, const DirectWorkspace& direct, std::uint32_t body_a, std::uint32_t body_b,
                     ImpactIslands& out) {
  const std::uint32_t sink = dummy_sink(solved.bodies);
  ImpactEnds ends;
  for (std::size_t side = 0; side < 2; ++side) {
    const std::uint32_t body = side == 0 ? body_a : body_b;
    if (solved.bodies.masses[body].write != sink) find_place(direct, body, ends.places[side], ends.parts[side], out);
  }
  if (ends.parts[1].component != DirectComponents::none && ends.parts[1].component == ends.parts[0].component)
    ends.parts[1].count = 0;
  return ends;
}

const Triple& response_at(const ImpactEnds& ends, const ImpactRow& row, std::size_t side,
                          const ImpactIslands& islands) {
  const ImpactBodies& first = ends.parts[0];
  const std::size_t start = row.response + (ends.parts[side].count == 0 || side == 0 ? 0 : first.count);
  return islands.responses[start + (ends.places[side] - ends.parts[side].first)];
}

void find_response(const SolvedSet& solved, DirectWorkspace& direct, const ImpactEnds& ends, ImpactRow& row,
                   ImpactIslands& out) {
  row.response = static_cast<std::uint32_t>(out.responses.size());
  double alone = 0;
  for (std::size_t side = 0; side < 2; ++side) {
    if (ends.places[side] == no_impact_place) continue;
    const BodyMass& mass = solved.bodies.masses[out.rows[ends.places[side]]];
    const double inv_mass = static_cast<double>(mass.inv_mass);
    const Triple& along = row.along[side];
    const Triple change = {inv_mass * along[0], inv_mass * along[1], static_cast<double>(mass.inv_inertia) * along[2]};
    alone += dot_product(change, along);
    const ImpactBodies& part = ends.parts[side];
    if (part.count == 0) continue;
    if (part.component == DirectComponents::none) {
      out.responses.push_back(change);
      continue;
    }
    DirectIsland& island = direct.islands[part.component].island;
    clear_body_impulses(island);
    for (std::size_t other = 0; other < 2; ++other)
      if (ends.places[other] != no_impact_place && ends.parts[other].component == part.component)
        add_body_impulse(island, ends.places[other] - part.first, row.along[other]);
    solve_body_impulses(island);
    for (std::uint32_t i = 0; i < part.count; ++i) out.responses.push_back(velocity_change(island, i));
  }
  row.mobility = 0;
  for (std::size_t side = 0; side < 2; ++side)
    if (ends.places[side] != no_impact_place)
      row.mobility += dot_product(row.along[side], response_at(ends, row, side, out));
  if (!(row.mobility > mobility_share * alone)) row.mobility = 0;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
