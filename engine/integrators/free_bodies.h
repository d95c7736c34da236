// Bodies without constraints in a tick take their substeps independently.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/integrators/motion_rows.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct FreeBodies {
  std::vector<std::uint8_t> is_constrained;  // [body] something touches the body in this tick, or may touch it
  std::vector<std::uint32_t> rows;           // of the set that is being solved
};

template <typename Visit>
void list_fields(FreeBodies& of, const Visit& visit) {
  auto& [is_constrained, rows] = of;
  visit(is_constrained, rows);
}

/// Finds the bodies with contacts or impacts in this tick. False: separate integration does not pay, or bodies interact
/// in other ways.
bool find_constrained(const Model& model, const State& state, const TickLists& tick, FreeBodies& free);
/// Integrates the unconstrained bodies of the set through all substeps and leaves the others in solved.rows. Reorders
/// TickLists::set_rows. Requires: find_constrained, and the integrator has begun.
void integrate_free_bodies(SolvedSet& solved, std::vector<std::uint32_t>& set_rows, FreeBodies& free,
                           const MotionWorkspace& work);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
