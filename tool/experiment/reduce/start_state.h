// A later start of a session: the state before a tick as the start of the scene.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "engine/engine.h"
#include "tool/experiment/soak_case.h"

namespace ticktrue::reduce {

/// The session that begins with the present state of `engine`, as far as a scene can express the state. Kept: poses,
/// velocities, and the gravity and motors that inputs set. Not kept: impulses, sleep, and the body that a pointer
/// holds. Earlier inputs are removed. Ids stay valid if only `spawn` creates bodies. Requires: the engine has run the
/// first ticks of the session.
soak::SoakCase begin_at_state(const soak::SoakCase& session, const engine::Engine& engine);

}  // namespace ticktrue::reduce
