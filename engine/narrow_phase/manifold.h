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

/// A contact: a pair that touches or will touch soon. Parallel to State::contacts where the pipeline has that table.
struct ContactPair {
  std::uint32_t body_a;  // row
  std::uint32_t body_b;
  Manifold manifold;
  std::uint32_t proxy_a;  // in Scratch::proxies; pairs ascend by both
  std::uint32_t proxy_b;
  Real friction;
  Real radius_a;  // m, of round shapes: pivots are at the core, not at the surface
  Real radius_b;
  Real size;  // of the smaller shape, m
  Real restitution;
};

/// The part of a list that a chunk has written.
struct ListPart {
  std::size_t first;     // its first place
  std::size_t in_place;  // number of elements there; the rest is in the spill
  std::size_t count;
  std::size_t place;  // in the list
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
