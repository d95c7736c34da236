// Scenes in binary: exact bits, embedded in every trace, so that a replay parses no text.
// SPDX-License-Identifier: MIT
#pragma once

#include "base/bytes.h"
#include "base/result.h"
#include "engine/scene/scene.h"

namespace ticktrue::engine {

/// docs/trace_format.md, "Setup of ticktrue.engine". Equal scenes give equal bytes on every platform.
Bytes encode_scene(const Scene& scene);

/// Bounds every size before it allocates. Calls check_scene.
/// Errors: corrupt, invalid_scene, limit.
Result<Scene> decode_scene(ByteView bytes);

}  // namespace ticktrue::engine
