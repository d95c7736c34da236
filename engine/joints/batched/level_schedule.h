// Levels in which the joints of a body are near each other, so that passes over the levels can be woven (wavefront.h).
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/math/real.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Scratch;

/// Raises levels of the plan's joints until those of each body are less than plan.distance apart, and sorts the bodies
/// by the first. False: no distance is found that is worth it, or a joint holds on to a kinematic body; the levels are
/// as before. Requires: places in scene order.
bool schedule_levels(Scratch& scratch);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
