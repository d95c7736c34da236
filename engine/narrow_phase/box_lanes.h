// Pairs of shapes with four sharp corners as kernels see them: eight at a time.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/constraints/lanes.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Points of contact of eight pairs, anchors from the bodies' centres of mass in world axes, m.
struct BoxContactLanes {
  Lanes normal_x, normal_y;  // from A to B
  struct Point {
    Lanes anchor_a_x, anchor_a_y, anchor_b_x, anchor_b_y;
    Lanes separation;
    Lanes feature;  // as ManifoldPoint's; -1: there is no such point
  };
  Point points[2];
};

/// Eight pairs; lanes beyond the last pair repeat one.
struct BoxPairs {
  const Real* poses;  // of the bodies, `pose_length` numbers from one to the next: position x, y, rotation c, s
  const Real* quads;  // 16 numbers each: x, y, normal x, normal y of the four corners
  std::uint32_t body_a[lane_count], body_b[lane_count];
  std::uint32_t quad_a[lane_count], quad_b[lane_count];
  Lanes margin;      // m
  Lanes preference;  // of A's axes, m
};

struct BoxKernels {
  void (*collide)(const BoxPairs& pairs, BoxContactLanes& out);
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
