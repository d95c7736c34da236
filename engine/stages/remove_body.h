// Removal of a body from the state, with everything that refers to it.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/pipeline.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Removes the row, its contacts, its joints and the pointers that hold it. Forces of this tick's inputs stay with
/// their bodies.
void remove_body(State& state, Scratch& scratch, std::size_t row);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
