// The length scale at which Box2D simulates a scene. It is the same for every version of Box2D.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/scene/scene.h"

namespace ticktrue::tool {

/// Larger coordinates, in Box2D m, are too far out for Box2D's floats: a float resolves 2 mm here.
inline constexpr double box2d_coordinate_max_m = 2e4;

/// The largest extent of a shape: twice its bounding radius about its own centre.
double extent_of(const engine::Shape& shape);

/// Box2D lengths over scene lengths, a power of two, which adds no rounding. The scale brings the median moving body
/// into the range that Box2D is tuned for, 0.1 m to 10 m.
double choose_length_scale(const engine::Scene& scene);

}  // namespace ticktrue::tool
