// The level schedule: levels in which the joints of a body are close together. A wavefront sweep needs such levels
// (wavefront.h).
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/math/real.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct JointOrder;
struct JointOrderWork;
struct SolvedSet;

/// Raises levels of the joints until the joints of each body are less than schedule.distance levels apart. Then sorts
/// the bodies by the level of their first joint. False: no distance pays, or a joint is attached to a kinematic body;
/// the levels are unchanged. Requires: places in scene order.
bool schedule_levels(const SolvedSet& solved, JointOrderWork& work, JointOrder& order);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
