// How much energy the passes over a direct island may add.
// SPDX-License-Identifier: MIT
// Source: derived here. Rows of joints do no work: what they add beyond the speeds that they require comes from rows
// that contradict each other, or from positions that a pass has met by velocities which are too large.
#pragma once

#include "engine/joints/direct/direct_island.h"

namespace ticktrue::engine {

inline constexpr double push_speed_max = 3;         // m/s, of a row
inline constexpr double push_body_speed = 0.1;      // m/s: the push has at most the energy of all bodies at this speed
inline constexpr double resting_body_speed = 0.05;  // m/s: bodies at rest count with the energy of this speed
inline constexpr double own_energy_share = 4;       // of the kinetic energy, for changes by rows

/// Twice the kinetic energy, J.
inline double double_energy(const DirectBody& body, const Triple& v) {
  return body.mass * (v[0] * v[0] + v[1] * v[1]) + body.inertia * (v[2] * v[2]);
}

void save(const DirectIsland& island, SavedIsland& saved);
void restore(DirectIsland& island, const SavedIsland& saved);
/// Scales by `share` the changes of velocities and impulses since the island was saved.
void scale_changes(DirectIsland& island, const SavedIsland& since, double share);

/// Twice the energy of the changes since the island was saved, and twice the energy before the changes, J.
struct EnergyDemand {
  double asked = 0;
  double had = 0;
};
/// `speed`: the energy of each body counts with the energy of this speed added, m/s.
EnergyDemand energy_demand(const DirectIsland& island, const SavedIsland& since, double speed);

/// Twice the kinetic energy, J.
struct KineticEnergy {
  double at_start = 0;  // before the first pass of meet_positions
  double now = 0;
};
/// `speed`: at the start, the energy of each body counts with the energy of this speed added, m/s.
KineticEnergy kinetic_energy(const DirectIsland& island, double speed);

/// Rows only remove velocities, apart from the speeds that they require. Larger changes come from rows that contradict
/// each other: the function scales the changes, and a gap opens. Requires: the island was saved before the changes.
void bound_changes(DirectIsland& island, const SavedIsland& since);

/// Slows the bodies down if joints have added kinetic energy, which no joint without a drive can. Momentum and angular
/// momentum of free islands stay. Requires: meet_positions and project_velocities in this substep, and nothing else
/// acted on the bodies between.
void bound_gain(DirectIsland& island);

}  // namespace ticktrue::engine
