// Pairs and bodies that the law of soft constraints does not judge, since nothing could meet what is asked of them:
// docs/soak.md, Overlaps and gaps.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "tool/experiment/oracle/law_view.h"

namespace ticktrue::soak {

using BodyIds = std::pair<std::uint32_t, std::uint32_t>;  // the smaller one first

/// Pairs of bodies that a weld holds in place against each other, and that collide all the same.
std::set<BodyIds> find_welded(const TickView& view);

/// Overlaps of bodies that the scene asks for, m: a pin holds a point that lies inside of both. Contacts push the two
/// points of an edge alike. Around a pin that turns bodies until a corner of one lies deep in an edge of the other.
std::map<BodyIds, double> find_pinned(const TickView& view);

/// Sets is_crushed[body] of bodies between two shapes of one body, between two immovable ones, or between two that a
/// joint holds together.
void find_squeezed(const TickView& view, std::vector<std::uint8_t>& is_crushed);

/// Sets is_crushed[body] in groups of touching and joined bodies that a moving kinematic body drives, by touch or by a
/// joint, and another immovable body holds.
void find_driven(const TickView& view, std::vector<std::uint8_t>& is_crushed);

}  // namespace ticktrue::soak
