// Helpers for tests of the Box2D peer.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "engine/math/trig.h"
#include "tests/support/scenes.h"
#include "tool/box2d/box2d_peer.h"

namespace ticktrue::test {

/// A build without Box2D has no peer. Tests that need a peer are then skipped.
inline bool has_box2d() {
  return !tool::box2d_version().empty();
}

inline std::vector<Point> regular_polygon(int corner_count, double radius) {
  std::vector<Point> corners;
  for (int i = 0; i < corner_count; ++i) {
    const engine::SinCos turn = engine::sin_cos(2 * engine::pi * i / corner_count);
    corners.push_back({radius * turn.cos, radius * turn.sin});
  }
  return corners;
}

}  // namespace ticktrue::test
