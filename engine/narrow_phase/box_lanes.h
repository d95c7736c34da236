// Pairs of quadrilaterals in the layout of kernels: eight at a time.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/simd/lanes.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The features of each point, as in ManifoldPoint; -1: the point does not exist.
struct BoxFeatures {
  Lanes at[2];
};

/// Points of contact of eight pairs, anchors from the bodies' centres of mass in world axes, m.
struct BoxContacts {
  Real normals[lane_count][4];     // from A to B: x, y; separations of the two points
  Real anchors[2][lane_count][4];  // of each point: A's x, y, B's x, y
  BoxFeatures features;
};

/// Eight pairs; lanes beyond the last pair repeat a pair.
struct BoxPairs {
  std::uint32_t body_a[lane_count], body_b[lane_count];
  std::uint32_t quad_a[lane_count], quad_b[lane_count];
  Lanes margin;      // m
  Lanes preference;  // of A's axes, m
  bool same_a;       // all pairs have the same shape A
  bool same_b;
};

struct BoxKernels {
  /// `poses`: of the bodies, in rows of `pose_length` numbers: position x, y, rotation c, s. `quads`: 16 numbers each:
  /// x, y, normal x, normal y of the four corners.
  void (*collide)(const BoxPairs& pairs, const Real* poses, const Real* quads, BoxContacts& out);
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
