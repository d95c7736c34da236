// Where pairs touch.
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

/// A pair that touches, or will soon. Parallel to State::contacts where the pipeline has that table.
struct ContactPair {
  std::uint32_t body_a;  // row
  std::uint32_t body_b;
  Manifold manifold;
  std::uint32_t proxy_a;  // in Scratch::proxies; pairs ascend by both
  std::uint32_t proxy_b;
  Real friction;
  Real radius_a;  // of round shapes, m: what turns with the body is the middle, not the surface
  Real radius_b;
  Real size;  // of the smaller shape, m
  Real restitution;
};

/// What a chunk has added to a list.
struct ListPart {
  std::size_t first;     // where it wrote
  std::size_t in_place;  // so many of them there; the rest is elsewhere
  std::size_t count;
  std::size_t place;  // in the list
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
