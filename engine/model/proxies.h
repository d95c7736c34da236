// Proxies and pairs: what broad phases make of bodies.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "engine/math/real.h"
#include "engine/scene/scene.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// One convex shape of one body in the world. In (body row, child) order, so that comparing indices compares shape ids.
/// Shapes that can meet nothing in their scene have none.
struct Proxy {
  std::uint32_t body;   // row in State::bodies
  std::uint32_t shape;  // in Model::shapes
  std::uint32_t child;  // index in the body
  bool is_dynamic;
  bool is_static;
  bool is_sensor;
  bool is_line;
  Filter filter;
  Real ccd_margin;  // m: so much of its box is there for what must not be passed through alone; < 0: all is for
                    // everything
};

/// Two proxies that may touch, first < second.
struct Pair {
  std::uint32_t first;
  std::uint32_t second;
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
