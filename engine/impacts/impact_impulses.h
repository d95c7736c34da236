// The impulses of an impact that is located in time.
// SPDX-License-Identifier: MIT
// Source: Newton's law of restitution and Coulomb's law of friction.
#pragma once

#include "engine/impacts/impact_rows.h"
#include "engine/impacts/island_response.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Impulses of an impact along its normal and its tangent, N s.
struct Impulses {
  Real normal = 0;
  Real tangent = 0;
};

/// The relative speeds at the point of an impact, m/s, and its coefficients.
struct ImpactSpeeds {
  Real closing;
  Real tangent;
  Real friction;
  Real restitution;
};

/// The speeds that impulses give to the point of an impact, 1/kg.
struct ImpactMobility {
  Real normal = 0;
  Real tangent = 0;
  Real coupling = 0;  // tangent speed per normal impulse, and the reverse
};

/// An impact that meets islands.
struct IslandImpact {
  ImpactEnds ends;
  ImpactRow normal;
  ImpactRow tangent;
};

/// The impulses on two bodies that nothing else holds.
Impulses impulses_alone(const ImpactMobility& mobility, const ImpactSpeeds& speeds);
/// The impulses on islands: those that stop the point, times 1 + restitution. Friction holds the tangent too, or slides
/// at Coulomb's bound. The normal speed follows Newton's law. The impact takes energy: the impulses p that stop the
/// point take at least p K p / 2 (K: `mobility`), and those of a bounce give back at most this much. Requires:
/// mobility.normal > 0.
Impulses impulses_on_islands(const ImpactMobility& mobility, const ImpactSpeeds& speeds);

/// Whether the impact of a pair meets an island. `ends`: its bodies.
bool find_islands(const SolvedSet& solved, const DirectWorkspace& direct, const ImpactPair& pair,
                  ImpactIslands& islands, ImpactEnds& ends);
/// Computes what impulses do to the islands: the rows of `out`. `arm_a`, `arm_b`: from the bodies' centres to the
/// point. Requires: find_islands has filled out.ends.
void find_responses(const SolvedSet& solved, DirectWorkspace& direct, Vec2 normal, Vec2 arm_a, Vec2 arm_b,
                    ImpactIslands& islands, IslandImpact& out);
/// Requires: find_responses.
ImpactMobility mobility_of(const IslandImpact& impact, const ImpactIslands& islands);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
