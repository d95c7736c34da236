// A flip: bits that are drawn at random, and a simulation whose state has them flipped.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/state/cells.h"
#include "base/state/simulation.h"
#include "base/state/state_view.h"
#include "verifier/inject/inject.h"

namespace ticktrue::verifier {

/// One flipped bit.
struct FlippedBit {
  StatePlace place;
  std::uint32_t bit = 0;
  std::optional<std::uint64_t> true_bits;  // unknown inside the solver
  std::string row_name;
};

/// The requested flip, and its place after it was made.
struct Flip {
  std::uint64_t tick = 0;
  std::uint64_t seed = 0;  // of the random draws for table, row, column, lane and bit
  const InjectOptions* options = nullptr;

  bool done = false;
  std::vector<FlippedBit> bits;
  std::vector<CellOwner> concerned;  // rows whose values the flip changes
  Bytes row_after;                   // inside the solver: the row at the end of the tick
  bool waived = false;               // this row is the same as without the flip
  std::uint64_t rows_seen = 0;       // in the largest table that the flip can hit
};

/// Passes calls to the real simulation, and makes the flip in its tick: at the end of the tick, or inside the solver.
/// `ticks_done`: of the present state. The flip must outlive the result.
std::unique_ptr<Simulation> flipping_simulation(std::unique_ptr<Simulation> real, std::uint64_t ticks_done, Flip& flip);

/// The bytes of a row; empty: the state has no such row.
Bytes row_bytes(const StateView& state, const StatePlace& place);

/// The table with the rows of bodies: the table with most references to it. Without references, the first table with a
/// key.
std::size_t table_of_bodies(const StateSchema& schema);

}  // namespace ticktrue::verifier
