// Pins in batches: packed from the state, solved by kernels, stored back.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "engine/constraints/contact_batch.h"
#include "engine/constraints/joint_order.h"
#include "engine/constraints/pin_lanes.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// How pins are solved.
enum class PinOrder : std::uint8_t {
  levels,  // eight at a time: those of a batch share no moving body
  row,     // one after the other
};

struct PinBatches {
  PinOrder order = PinOrder::levels;
  std::vector<PinBatch> batches;  // the first `batch_count` are in use
  std::vector<PinArms> arms;      // [batch], of rows
  std::uint32_t batch_count = 0;
  std::uint32_t last_level = 0;  // of the last batch
  Softness soft;
};

/// Adds a pin to the last batch, or begins a new one where that is full, of another level or not of this run.
void add_pin(const Model& model, const State& state, Scratch& scratch, const JointPlace& place, bool begins_run,
             Real h);
void warm_start_pins(Scratch& scratch, std::uint32_t first, std::uint32_t last);
void solve_pins(Scratch& scratch, std::uint32_t first, std::uint32_t last, Real h, Bias bias);
/// Impulses back to state.joints, as forces.
void store_pins(const Scratch& scratch, State& state, Real h);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
