// The hot records of all bodies for one tick: filled from the state, used by the solver, stored back.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/model/body_rows.h"
#include "engine/simd/lanes.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Model;
struct State;
struct TickLists;

/// The bodies that the rooms of the solver share.
struct SolverBodies {
  std::vector<MovingBody> records;  // one per row, then the dummy body and the sinks
  std::vector<BodyMass> masses;     // [body]

  /// The records in the form of kernel arguments.
  Real* lanes() { return &records.data()->velocity.x; }
};

template <typename Visit>
void list_fields(SolverBodies& of, const Visit& visit) {
  auto& [records, masses] = of;
  visit(records, masses);
}

/// Fills masses and records.
void prepare_bodies(const Model& model, const State& state, const TickLists& tick, SolverBodies& bodies);

/// Records at this distance share no cache line, and no pair of lines that processors fetch together.
inline constexpr std::size_t record_stride = 4;
/// The dummy body: a record at rest that stands for non-dynamic bodies and is only read.
inline std::uint32_t dummy_body(const SolverBodies& bodies) {
  return static_cast<std::uint32_t>(bodies.masses.size() + record_stride);
}
/// Sinks: records that are only written, with impulses on non-dynamic bodies. Each chunk of a loop has its own.
inline std::uint32_t dummy_sink(const SolverBodies& bodies, std::size_t chunk = 0) {
  return static_cast<std::uint32_t>(bodies.masses.size() + (2 + chunk) * record_stride);
}

/// Stores poses and velocities of all bodies in solver sets, and fills TickLists::travel if the scene sleeps.
void store_bodies(const Model& model, const SolverBodies& bodies, TickLists& tick, State& state);
/// Stores velocities only, for stages after the solver.
void store_velocities(const SolverBodies& bodies, const TickLists& tick, State& state);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
