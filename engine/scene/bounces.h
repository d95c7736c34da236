// How much the bodies of a scene bounce, and whether their impacts are to be located.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/scene/scene.h"

namespace ticktrue::engine {

/// The largest restitution of two shapes that may touch; 0 if there are none. Filters and joints do not count.
double largest_restitution(const Scene& scene);

/// What `"locate_impacts": "auto"` of a scene file stands for: whether some pair has restitution 1, and the scene may
/// have its impacts located.
bool locates_bounces(const Scene& scene);

}  // namespace ticktrue::engine
