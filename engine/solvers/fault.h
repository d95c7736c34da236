// A bit flipped inside the solver, so that tests see what verification makes of it.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Flips the planted bit if it is due after this substep of this group.
void flip_injected(Scratch& scratch, std::size_t set, int substep);

/// One question for each substep of a group, none inside its loops.
inline void after_substep(Scratch& scratch, std::size_t set, int substep) {
  if (scratch.injected) flip_injected(scratch, set, substep);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
