// Plain revolute joints in the layout of the kernels: eight that share no dynamic body, or some that are solved one at
// a time.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/simd/lanes.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct RevoluteBatch {
  std::uint32_t read_a[lane_count];  // in SolverBodies::records; static bodies and empty lanes read the dummy body
  std::uint32_t read_b[lane_count];
  std::uint32_t write_a[lane_count];  // non-dynamic bodies are written to a sink
  std::uint32_t write_b[lane_count];
  Lanes inv_mass_a, inv_mass_b, inv_inertia_a, inv_inertia_b;
  Lanes anchor_a_x, anchor_a_y;  // from the centres of mass at the start of the tick, world axes, m
  Lanes anchor_b_x, anchor_b_y;
  Lanes center_offset_x, center_offset_y;  // from A's centre of mass to B's at the start of the tick, m
  Lanes impulse_x, impulse_y;              // N s, accumulated in this substep
  std::uint32_t row[lane_count];           // in State::joints
  std::int32_t count;                      // all later lanes are empty
};

/// The point constraints of a batch at the present poses, computed once after each change of poses.
struct RevoluteArms {
  Lanes ax, ay, bx, by;  // from the centres of mass to the point of the impulse, m
  Lanes ex, ey;          // from A's anchor to B's, m
  Lanes k11, k12, k22, inv_determinant;
};

/// Consecutive batches, for one call of a kernel.
struct RevoluteWork {
  RevoluteBatch* batches;
  RevoluteArms* arms;  // [batch]
  std::size_t batch_count;
  Real* bodies;
  Real h;  // s, of a substep
  Softness soft;
};

struct RevoluteKernels {
  // Requires: before `solve`, a `warm_start` since the poses changed; before `warm_start_again`, a `relax` since then.
  void (*warm_start)(const RevoluteWork& work);
  void (*warm_start_again)(const RevoluteWork& work);
  void (*solve)(const RevoluteWork& work);
  void (*relax)(const RevoluteWork& work);
  // The serial path, for joints that share bodies. Requires: as for the functions above.
  void (*warm_start_serial)(const RevoluteWork& work);
  void (*solve_serial)(const RevoluteWork& work);
  void (*relax_serial)(const RevoluteWork& work);
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
