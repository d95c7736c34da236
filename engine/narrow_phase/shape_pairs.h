// Which pairs of shapes can meet in a scene, and which shapes can meet none.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "engine/model/model.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// "circle x circle, circle x polygon": the pairs that the bodies, and the prototypes that inputs may spawn, can meet
/// in, or that there are none. Boxes are polygons; `round` are capsules, segments and rounded polygons; `chain` are
/// edges of chains.
std::string meeting_pairs(const Model& model);

/// Fills model.is_non_colliding: the children that no other body of the scene, and none that inputs may spawn, can
/// meet.
void find_non_colliding_shapes(Model& model);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
