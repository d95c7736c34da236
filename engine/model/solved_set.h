// The present solver set, as input of the rooms of the solver.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

#include "engine/islands/island_rows.h"
#include "engine/model/bodies.h"
#include "engine/model/model.h"
#include "engine/model/state.h"
#include "engine/model/tick_lists.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The common input of the rooms of the solver. A room writes the bodies, and its own ranges of the set.
struct SolvedSet {
  const Model& model;
  const State& state;  // at the start of the tick
  const TickLists& tick;
  SolverSet& set;
  std::uint32_t index;  // of the set
  SolverBodies& bodies;
  std::span<const std::uint32_t> rows;  // the bodies of the set that move in the present passes

  const Parallel& parallel() const { return tick.parallel; }
  const SolverKernels& kernels() const { return model.kernels; }
  bool has_body(std::size_t row) const { return tick.body_solver_set[row] == index; }
  /// All rows of the set.
  std::span<const std::uint32_t> all_rows() const {
    return {tick.set_rows.data() + set.first_row, set.row_end - set.first_row};
  }
  /// The contacts of the set, in TickLists::contact_pairs.
  std::span<const std::uint32_t> contacts() const {
    return {tick.set_contacts.data() + set.first_contact, set.contact_end - set.first_contact};
  }
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
