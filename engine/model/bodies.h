// The hot records of all bodies for one tick: filled from the state, worked on by the solver, stored back.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Fills scratch.bodies, one record per row, then those that stand for everything immovable; and scratch.masses.
void prepare_bodies(const Model& model, const State& state, Scratch& scratch);

/// So many records from each other no two threads meet in a cache line, or in the pair of lines that is fetched at
/// once.
inline constexpr std::size_t record_stride = 4;
/// A record at rest that is only read.
inline std::uint32_t dummy_body(const Scratch& scratch) {
  return static_cast<std::uint32_t>(scratch.masses.size() + record_stride);
}
/// Records that are only written: where impulses on immovable bodies go. Each chunk of a loop has its own.
inline std::uint32_t dummy_sink(const Scratch& scratch, std::size_t chunk = 0) {
  return static_cast<std::uint32_t>(scratch.masses.size() + (2 + chunk) * record_stride);
}

/// Poses and velocities of all bodies in groups back to the state.
void store_bodies(const Scratch& scratch, State& state);
/// Velocities only: for stages after the solver.
void store_velocities(const Scratch& scratch, State& state);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
