// The linear system of a direct island: what its rows couple, and its factorisation.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/joints/direct/direct_island.h"

namespace ticktrue::engine {

inline double magnitude(double x) {
  return x < 0 ? -x : x;
}

inline double arm_of(Place p) {
  return __builtin_sqrt(p.x * p.x + p.y * p.y);
}

inline bool is_moving(const DirectIsland& island, std::uint32_t body) {
  return body < island.moving_count;
}

inline double mobility(const DirectBody& body, const Block& gradient, std::size_t row, std::size_t other) {
  const double* g = gradient.data() + 3 * row;
  const double* q = gradient.data() + 3 * other;
  return (g[0] * q[0] + g[1] * q[1]) * body.inv_mass + g[2] * q[2] * body.inv_inertia;
}

/// The change of the speed of row `row` per impulse of row `other`.
inline double coupling(const DirectIsland& island, const DirectJoint& joint, std::size_t row, std::size_t other) {
  double sum = 0;
  if (is_moving(island, joint.body_a))
    sum += mobility(island.bodies[joint.body_a], joint.equations.gradient_a, row, other);
  if (is_moving(island, joint.body_b))
    sum += mobility(island.bodies[joint.body_b], joint.equations.gradient_b, row, other);
  return sum;
}
inline double mobility(const DirectIsland& island, const DirectJoint& joint, std::size_t row) {
  return coupling(island, joint, row, row);
}

/// Of a row after the rigid ones.
inline DirectDrive& drive_of(DirectIsland& island, const DirectJoint& joint, std::size_t row) {
  return island.drives[joint.first_drive + (row - joint.equations.rigid_count)];
}
inline const DirectDrive& drive_of(const DirectIsland& island, const DirectJoint& joint, std::size_t row) {
  return island.drives[joint.first_drive + (row - joint.equations.rigid_count)];
}

inline RowLaw law_of(const DirectIsland& island, const DirectJoint& joint, std::size_t row) {
  if (row < joint.equations.rigid_count) return {true, 0, 0, 0};
  return drive_of(island, joint, row).law;
}

/// Fills the system from equations and laws, and factors it.
void factor_laws(DirectIsland& island);

}  // namespace ticktrue::engine
