// Newton's law of restitution and Coulomb's law of friction, for bodies alone and for islands.
// SPDX-License-Identifier: MIT
#include "engine/impacts/impact_impulses.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

Impulses impulses_alone(const ImpactMobility& mobility, const ImpactSpeeds& speeds) {
  const auto inverse_or_zero = [](Real k) { return k > 0 ? 1 / k : Real(0); };
  const Real normal_mass = inverse_or_zero(mobility.normal);
  const Real tangent_mass = inverse_or_zero(mobility.tangent);
  const Real normal = speeds.closing > 0 ? (1 + speeds.restitution) * speeds.closing * normal_mass : Real(0);
  const Real limit = speeds.friction * normal;
  const auto friction_against = [&](Real speed) { return smaller(larger(-speed * tangent_mass, -limit), limit); };
  const Real tangent = friction_against(speeds.tangent);
  if (!(normal > 0) || !(tangent_mass > 0)) return {normal, tangent};
  // The normal impulse also rotates a body. Friction against the velocity before the impulse may make the impact gain
  // energy. In this case, friction acts against the velocity after the impulse, which never gains energy.
  const Real tangent_after = speeds.tangent + normal * mobility.coupling;
  const Real normal_work = normal * ((Real(0.5) / normal_mass) * normal - speeds.closing);
  const Real tangent_work = tangent * (tangent_after + (Real(0.5) / tangent_mass) * tangent);
  return {normal, normal_work + tangent_work > 0 ? friction_against(tangent_after) : tangent};
}

Impulses impulses_on_islands(const ImpactMobility& mobility, const ImpactSpeeds& speeds) {
  constexpr Real held_share = Real(1e-4);  // of the tangent's mobility: the normal then holds the tangent as well
  if (!(speeds.closing > 0)) return {};
  const Real per_normal = mobility.coupling / mobility.normal;
  Impulses stop = {speeds.closing / mobility.normal, 0};
  // Of a tangent impulse, while the normal impulse keeps the point stopped.
  const Real tangent_mobility = mobility.tangent - per_normal * mobility.coupling;
  if (tangent_mobility > held_share * mobility.tangent) {
    const Real slip = speeds.tangent + mobility.coupling * stop.normal;
    const Real stick = -slip / tangent_mobility;
    const Real normal = stop.normal - per_normal * stick;
    const Real friction = stick > 0 ? speeds.friction : -speeds.friction;
    const Real sliding_mobility = mobility.normal + friction * mobility.coupling;
    if (absolute(stick) <= speeds.friction * normal)
      stop = {normal, stick};
    else if (sliding_mobility > 0)
      stop = {speeds.closing / sliding_mobility, friction * (speeds.closing / sliding_mobility)};
  }
  return {(1 + speeds.restitution) * stop.normal, (1 + speeds.restitution) * stop.tangent};
}

bool find_islands(const SolvedSet& solved, const DirectWorkspace& direct, const ImpactPair& pair,
                  ImpactIslands& islands, ImpactEnds& ends) {
  if (islands.rows.empty()) return false;
  if (!meets_island(direct, pair.body_a, islands) && !meets_island(direct, pair.body_b, islands)) return false;
  ends = find_ends(solved, direct, pair.body_a, pair.body_b, islands);
  return true;
}

void find_responses(const SolvedSet& solved, DirectWorkspace& direct, Vec2 normal, Vec2 arm_a, Vec2 arm_b,
                    ImpactIslands& islands, IslandImpact& out) {
  const auto row_along = [&](Vec2 direction) {
    const auto gradient = [direction](Vec2 arm, Real sign) {
      return Triple{static_cast<double>(sign * direction.x), static_cast<double>(sign * direction.y),
                    static_cast<double>(sign * cross(arm, direction))};
    };
    ImpactRow row;
    row.along = {gradient(arm_a, -1), gradient(arm_b, 1)};
    return row;
  };
  out.normal = row_along(normal);
  out.tangent = row_along(right_turn(normal));
  islands.responses.clear();
  for (ImpactRow* row : {&out.normal, &out.tangent}) find_response(solved, direct, out.ends, *row, islands);
}

ImpactMobility mobility_of(const IslandImpact& impact, const ImpactIslands& islands) {
  double coupling = 0;
  for (std::size_t side = 0; side < 2; ++side)
    if (impact.ends.places[side] != no_impact_place)
      coupling += dot_product(impact.tangent.along[side], response_at(impact.ends, impact.normal, side, islands));
  return {static_cast<Real>(impact.normal.mobility), static_cast<Real>(impact.tangent.mobility),
          static_cast<Real>(coupling)};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
