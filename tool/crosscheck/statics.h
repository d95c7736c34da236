// Whether a structure can stand, by statics alone: no solver of a simulation is asked.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/scene/scene.h"

namespace ticktrue::tool {

struct StaticBody {
  bool is_dynamic = false;
  engine::Point center;  // m, centre of mass
  engine::Point weight;  // N
  double size = 0;       // m, the arm that makes a moment comparable with a force
};

struct StaticContact {
  std::uint32_t body_a = 0;  // index of a body
  std::uint32_t body_b = 0;
  engine::Point point;   // m, world
  engine::Point normal;  // unit, from A to B
  double friction = 0;   // Coulomb coefficient
};

/// More points than these are not solved: the answer is "not known", so false.
inline constexpr std::size_t statics_point_count_max = 400;

/// Whether there are contact forces, each within its friction cone, that balance the weight and the moment of each
/// dynamic body. In two dimensions a cone is the sum of its two edges with factors >= 0, so the question is a
/// non-negative least squares problem. Source: Lawson and Hanson, Solving Least Squares Problems (1974), chapter 23.
bool can_balance(std::span<const StaticBody> bodies, std::span<const StaticContact> contacts);

}  // namespace ticktrue::tool
