// Proxies and pairs, the output of broad phases.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "engine/math/real.h"
#include "engine/scene/scene.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// One convex shape of one body in the world. Proxies are in (body row, child) order, so that comparing indices
/// compares shape ids. A shape that can touch nothing in its scene has no proxy.
struct Proxy {
  std::uint32_t body;   // row in State::bodies
  std::uint32_t shape;  // in Model::shapes
  std::uint32_t child;  // index in the body
  bool is_dynamic;
  bool is_static;
  bool is_sensor;
  bool is_line;
  Filter filter;
  Real ccd_margin;  // m: the part of its box for CCD targets alone; < 0: its whole box counts for every pair
};

/// Two proxies that may touch, first < second.
struct Pair {
  std::uint32_t first;
  std::uint32_t second;
};

/// The rule of scene.h: a common non-zero group decides; otherwise each category must be in the other's mask.
inline bool pass(const Filter& a, const Filter& b) {
  if (a.group == b.group && a.group != 0) return a.group > 0;
  return (a.mask & b.category) != 0 && (b.mask & a.category) != 0;
}

/// Whether two proxies may touch in any pose: they have different bodies, their filters allow it, and at most one is a
/// line. Contacts need a dynamic proxy. Overlaps with a sensor need a proxy that is not static; sensors do not detect
/// sensors.
inline bool may_touch(const Proxy& a, const Proxy& b) {
  if (a.body == b.body || !pass(a.filter, b.filter) || (a.is_line && b.is_line)) return false;
  if (a.is_sensor || b.is_sensor) return a.is_sensor != b.is_sensor && !(a.is_static && b.is_static);
  return a.is_dynamic || b.is_dynamic;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
