// What a person should know of a scene that is valid, and does something else than it seems to ask for.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "engine/engine.h"
#include "engine/scene/scene.h"

namespace ticktrue::tool {

/// In f32, this many sizes of the smallest moving shape from the origin: a place there is rounded to a 64th of its size
/// (24 bits of a float less 17, and the size is twice the radius).
inline constexpr double f32_extent_max = 0x1p17;
/// From here on a place is rounded to an eighth of that size or more, and the scene is refused.
inline constexpr double f32_extent_refused = 0x1p20;

/// One line each; none for most scenes: bounces of restitution 1 that lose energy since they are not located, positions
/// too far from the origin for f32, and joints of a rigid angle whose bodies start more than .1 rad from it. Requires:
/// a valid scene.
std::vector<std::string> scene_notes(const engine::Scene& scene);

/// A line on the ticks of a run that the substep budget has changed; empty if it has changed none, or there is none.
std::string budget_text(const std::optional<engine::BudgetReport>& report, std::uint64_t tick_count);

/// For scenes that are loaded from a file or by name; the scene of a trace runs as it was recorded. `source` begins the
/// message. Requires: a valid scene. Errors: incompatible (f32, and a moving body farther out than f32_extent_refused
/// sizes).
Status check_f32_reach(const engine::Scene& scene, const std::string& source);

}  // namespace ticktrue::tool
