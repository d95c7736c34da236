// Separate integration of bodies without constraints.
// SPDX-License-Identifier: MIT
#include "engine/integrators/free_bodies.h"

#include "engine/integrators/flow.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

bool find_constrained(const Model& model, const State& state, const TickLists& tick, FreeBodies& free) {
  constexpr std::size_t bodies_per_contact_least = 2;
  if (!model.is_composed || !bodies_step_alone(model) || model.has_pointer || !state.joints.empty() || tick.injected ||
      state.bodies.size() < bodies_per_contact_least * tick.contact_pairs.size())
    return false;
  free.is_constrained.assign(state.bodies.size(), 0);
  const auto mark = [&](const auto& pairs) {
    for (const auto& pair : pairs) free.is_constrained[pair.body_a] = free.is_constrained[pair.body_b] = 1;
  };
  mark(tick.contact_pairs);
  mark(tick.impacts);
  return true;
}

void integrate_free_bodies(SolvedSet& solved, std::vector<std::uint32_t>& set_rows, FreeBodies& free,
                           const MotionWorkspace& work) {
  std::uint32_t* rows = set_rows.data() + solved.set.first_row;
  const std::size_t count = solved.rows.size();
  std::size_t constrained_count = 0;
  free.rows.resize(count);
  std::size_t free_count = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t row = rows[i];
    const std::size_t is_constrained = free.is_constrained[row];
    rows[constrained_count] = row;
    free.rows[free_count] = row;
    constrained_count += is_constrained;
    free_count += 1 - is_constrained;
  }
  solved.rows = {free.rows.data(), free_count};
  integrate_freely(solved, work);
  solved.rows = {rows, constrained_count};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
