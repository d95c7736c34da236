// A seeded model of a person's clicks and drags: a mouse session that anyone can reproduce.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "base/result.h"
#include "engine/scene/input.h"
#include "engine/scene/scene.h"

namespace ticktrue::tool {

/// About one press a second; one press in six starts a drag. The session ends with `end`. The same seed gives the same
/// inputs on every platform. docs/scenes.md, "Mouse sessions", describes the model. Errors: incompatible (the scene has
/// no pointer), usage (no window; seconds not in 0..100'000).
Result<std::vector<engine::Input>> model_mouse_session(const engine::Scene& scene, std::uint64_t seed, double seconds);

}  // namespace ticktrue::tool
