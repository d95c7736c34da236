// A state of the engine as one self-contained SVG picture.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "engine/engine.h"

namespace ticktrue::tool {

/// A rectangle of the world, m; empty until something is added.
struct WorldBox {
  double lower_x = 0, lower_y = 0, upper_x = 0, upper_y = 0;
  bool is_empty = true;

  void add(double x, double y);
  void add(const WorldBox& other);
  double width() const { return upper_x - lower_x; }
  double height() const { return upper_y - lower_y; }
};

/// The box around the shapes of a body. Empty if the body's pose is not finite.
WorldBox box_of(const engine::BodyReport& body);

/// The view of a picture. `visited` is the box of all places of the moving bodies. The view contains the moving bodies
/// at the start, and `visited` up to 3 times their size or 100 m beyond. It contains the static bodies nearby.
WorldBox choose_view(const engine::Engine& start, const WorldBox& visited);

/// Draws the bodies with their shapes (static bodies grey, names as titles), contact points and normals. The picture is
/// readable on light and on dark backgrounds, because its own background is transparent.
std::string svg_picture(const engine::Engine& engine, std::uint64_t tick, const WorldBox& view);

}  // namespace ticktrue::tool
