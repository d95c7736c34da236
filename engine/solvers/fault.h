// A bit flipped inside the solver, to test verification.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Flips the injected bit if it is due after this substep of this set.
void flip_injected(Scratch& scratch, std::size_t set, int substep);

/// One branch for each substep of a set, outside its loops.
inline void after_substep(Scratch& scratch, std::size_t set, int substep) {
  if (scratch.injected) flip_injected(scratch, set, substep);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
