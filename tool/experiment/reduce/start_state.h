// A later start of a session: the state of a tick as the start of the scene.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "engine/engine.h"
#include "tool/experiment/soak_case.h"

namespace ticktrue::reduce {

/// The session that begins with the present state of `engine`, as far as a scene can say it: poses and velocities,
/// gravity and motors as inputs set them. Impulses, sleep and what a pointer holds are not kept. Inputs before that
/// tick are gone; ids follow where only `spawn` makes bodies.
/// Requires: the engine has run the first ticks of the session.
verifier::soak::SoakCase begin_at_state(const verifier::soak::SoakCase& session, const engine::Engine& engine);

}  // namespace ticktrue::reduce
