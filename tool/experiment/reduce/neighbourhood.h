// Orders bodies of a world by their distance from others: by contact, joint and position.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/engine.h"

namespace ticktrue::reduce {

/// Indices of all bodies in the scene, those nearest to `bodies` (ids) first. The order is by steps between neighbours,
/// then by distance, then by index. Two bodies are neighbours if they share a broad-phase pair, a joint or a spring.
/// Empty if none of `bodies` is in the scene.
std::vector<std::size_t> by_nearness(const engine::Engine& engine, const std::vector<std::uint32_t>& bodies);

/// Groups of moving bodies that broad-phase pairs and joints connect. Indices in each group ascend.
std::vector<std::vector<std::size_t>> connected_groups(const engine::Engine& engine);

}  // namespace ticktrue::reduce
