// Makes the engine of one precision.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "engine/engine.h"
#include "engine/math/real.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// `workers`: null for one thread. Requires: check_scene(scene).
std::unique_ptr<Engine> make_world(const Scene& scene, const EngineOptions& options,
                                   std::unique_ptr<ChunkRunner> workers);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
