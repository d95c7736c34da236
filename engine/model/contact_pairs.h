// Manifolds and contacts.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine/math/vec2.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct ManifoldPoint {
  Vec2 anchor_a;    // from A's centre of mass, world axes, m
  Vec2 anchor_b;    // from B's centre of mass, m
  Real separation;  // m, < 0 overlaps
  std::uint32_t feature;
};

struct Manifold {
  Vec2 normal;  // from A to B
  int point_count = 0;
  ManifoldPoint points[2];
};

/// A contact: a pair that touches or will touch soon. Parallel to State::contacts if the pipeline has this table.
struct ContactPair {
  std::uint32_t body_a;  // row
  std::uint32_t body_b;
  Manifold manifold;
  std::uint32_t proxy_a;  // in TickLists::proxies; pairs ascend by both
  std::uint32_t proxy_b;
  Real friction;
  Real radius_a;  // m, of round shapes: pivots are at the core, not at the surface
  Real radius_b;
  Real size;  // of the smaller shape, m
  Real restitution;
};

/// Whether a point overlaps by more than this share of the smaller shape's size.
inline bool overlaps_by(const ContactPair& pair, Real share) {
  const ManifoldPoint(&points)[2] = pair.manifold.points;
  const Real limit = -share * pair.size;
  return points[0].separation < limit || (pair.manifold.point_count == 2 && points[1].separation < limit);
}

/// The closing speed of a pair, m/s: that of its faster point.
template <typename Velocities>
Real closing_speed(const ContactPair& pair, const Velocities& a, const Velocities& b) {
  Real closing = 0;
  for (int i = 0; i < pair.manifold.point_count; ++i) {
    const ManifoldPoint& point = pair.manifold.points[i];
    const Vec2 velocity = (b.velocity + cross(b.angular_velocity, point.anchor_b)) -
                          (a.velocity + cross(a.angular_velocity, point.anchor_a));
    closing = larger(closing, -dot(velocity, pair.manifold.normal));
  }
  return closing;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
