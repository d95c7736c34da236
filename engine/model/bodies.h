// The hot records of all bodies for one tick: filled from the state, used by the solver, stored back.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Fills scratch.masses and scratch.bodies: one record per row, then the dummy body and the sinks.
void prepare_bodies(const Model& model, const State& state, Scratch& scratch);

/// Records at this distance share no cache line, and no pair of lines that is fetched together.
inline constexpr std::size_t record_stride = 4;
/// The dummy body: a record at rest that stands for non-dynamic bodies and is only read.
inline std::uint32_t dummy_body(const Scratch& scratch) {
  return static_cast<std::uint32_t>(scratch.masses.size() + record_stride);
}
/// Sinks: records that are only written, with impulses on non-dynamic bodies. Each chunk of a loop has its own.
inline std::uint32_t dummy_sink(const Scratch& scratch, std::size_t chunk = 0) {
  return static_cast<std::uint32_t>(scratch.masses.size() + (2 + chunk) * record_stride);
}

/// Stores poses and velocities of all bodies in solver sets.
void store_bodies(const Scratch& scratch, State& state);
/// Stores velocities only, for stages after the solver.
void store_velocities(const Scratch& scratch, State& state);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
