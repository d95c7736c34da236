// A state of the engine as one self-contained SVG picture.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "engine/engine.h"

namespace ticktrue::verifier {

/// A rectangle of the world, m; empty until something is added.
struct WorldBox {
  double lower_x = 0, lower_y = 0, upper_x = 0, upper_y = 0;
  bool is_empty = true;

  void add(double x, double y);
  void add(const WorldBox& other);
  double width() const { return upper_x - lower_x; }
  double height() const { return upper_y - lower_y; }
};

/// The box around the shapes of a body. Empty if its pose is not finite.
WorldBox box_of(const engine::BodyReport& body);

/// What a picture shows, from the bodies at the start and the box of all places where bodies were that can move: those
/// places, but not further off than 3 times the starting picture or 100 m, and of static bodies what is near.
WorldBox choose_view(const engine::Engine& start, const WorldBox& visited);

/// The bodies with their shapes (static ones grey, names as titles), contact points and normals. Readable on light and
/// on dark ground: the background is left transparent.
std::string svg_picture(const engine::Engine& engine, std::uint64_t tick, const WorldBox& view);

}  // namespace ticktrue::verifier
