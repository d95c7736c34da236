// A bit flipped inside the solver, to test verification.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Flips the injected bit if its time is after this substep of this set.
void flip_injected(const SolvedSet& solved, int substep);

/// One branch for each substep of a set, outside its loops.
inline void after_substep(const SolvedSet& solved, int substep) {
  if (solved.tick.injected) flip_injected(solved, substep);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
