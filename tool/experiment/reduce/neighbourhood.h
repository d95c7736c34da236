// Which bodies of a world are near others: by contact, joint and distance.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/engine.h"

namespace ticktrue::reduce {

/// Indices of all bodies of the scene, the nearest to `bodies` (ids) first: by how many steps of neighbours away, a
/// step being a pair of the broad phase, a joint or a spring; then by distance; then by index. Empty where none of
/// `bodies` is in the scene.
std::vector<std::size_t> by_nearness(const engine::Engine& engine, const std::vector<std::uint32_t>& bodies);

/// Groups of bodies that are not static and hang together by pairs of the broad phase and joints, each ascending.
std::vector<std::vector<std::size_t>> connected_groups(const engine::Engine& engine);

}  // namespace ticktrue::reduce
