// The pairs of shapes that can touch in a scene, and the shapes that can touch no other.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "engine/model/model.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The pairs of shape families that can touch, as "circle x circle, circle x polygon", or a text that says that no pair
/// can. Counts the bodies, and the prototypes that inputs may spawn. Boxes are polygons; `round` are capsules, segments
/// and rounded polygons; `chain` are edges of chains.
std::string meeting_pairs(const Model& model);

/// Fills model.is_non_colliding: the children that no other body of the scene can touch, and no body that inputs may
/// spawn.
void find_non_colliding_shapes(Model& model);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
