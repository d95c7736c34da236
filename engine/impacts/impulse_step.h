// One step of all contacts that push together: where passes settle slowly, impulses are solved for at once.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Changes the impulses of the contacts of a group that push, or hold by friction, so that their velocities are what
/// the relax pass drives them to; as far as they all still push. What is too wide to be solved so is left alone.
void step_active_contacts(Scratch& scratch, const SolverSet& set);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
