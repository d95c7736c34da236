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

/// The rule of scene.h: one non-zero group decides; else each category must be in the other's mask.
inline bool pass(const Filter& a, const Filter& b) {
  if (a.group == b.group && a.group != 0) return a.group > 0;
  return (a.mask & b.category) != 0 && (b.mask & a.category) != 0;
}

/// Whether two proxies may touch in any pose: they have different bodies, their filters allow it, and one of them is no
/// line. Contacts need a dynamic proxy. Overlaps with a sensor need one that is not static; sensors do not detect
/// sensors.
inline bool may_touch(const Proxy& a, const Proxy& b) {
  if (a.body == b.body || !pass(a.filter, b.filter) || (a.is_line && b.is_line)) return false;
  if (a.is_sensor || b.is_sensor) return a.is_sensor != b.is_sensor && !(a.is_static && b.is_static);
  return a.is_dynamic || b.is_dynamic;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
