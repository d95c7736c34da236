// The budget of automatic substeps: levels of islands, and the work left to resting impacts.
// SPDX-License-Identifier: MIT
#include "engine/islands/substep_budget.h"

#include "engine/islands/islands.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

// The work of a substep, in contacts solved once.
constexpr std::uint64_t work_of_body = 1;
constexpr std::uint64_t work_of_contact = 3;  // solve, relax, warm start
constexpr std::uint64_t work_of_joint = 4;
constexpr std::uint64_t work_of_impact = 130;  // a pair whose impacts are located

constexpr std::uint32_t cap_step = 8;  // substeps
// Resting impacts may use what this many ticks have left over.
constexpr std::uint64_t saved_ticks = 5;

void count_up(std::uint32_t& count) {
  if (count != no_reference) ++count;
}

/// Finds the work of a substep of each awake island, at its first row. Returns the work of the held islands: they use
/// nothing of their budget.
std::uint64_t find_work(const Model& model, const State& state, TickLists& tick, IslandWork& work) {
  std::vector<std::uint64_t>& of_island = work.island_work;
  of_island.assign(state.bodies.size(), 0);
  const bool some_are_held = holds_islands(model);
  std::uint64_t held = 0;
  const auto add = [&](std::uint32_t row, std::uint64_t amount) {
    if (type_of(model, state, row) != BodyType::dynamic_body) return false;
    const std::uint32_t root = find_root(tick.island_parent, row);
    if (work.island_awake[root] != 0)
      of_island[root] += amount;
    else if (some_are_held)
      held += amount;
    return true;
  };
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) add(row, work_of_body);
  for (const ContactPair& pair : tick.contact_pairs)
    if (!add(pair.body_a, work_of_contact)) add(pair.body_b, work_of_contact);
  for (const ImpactPair& pair : tick.impacts)
    if (!add(pair.body_a, work_of_impact)) add(pair.body_b, work_of_impact);
  for (const JointRow& joint : state.joints) {
    if (joint.body_a != no_reference && add(row_of(state, joint.body_a), work_of_joint)) continue;
    add(row_of(state, joint.body_b), work_of_joint);
  }
  return held;
}

}  // namespace

void apply_budget(const Model& model, State& state, TickLists& tick, IslandWork& work) {
  std::uint64_t per_substep = find_work(model, state, tick, work);
  const Settings& settings = model.scene.settings;
  const auto least = static_cast<std::uint32_t>(settings.substeps);
  for (const std::uint64_t of_island : work.island_work) per_substep += of_island;
  const std::uint64_t allowed = static_cast<std::uint64_t>(settings.substep_budget) * per_substep;
  const auto work_with = [&](std::uint32_t most) {
    std::uint64_t sum = 0;
    for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
      const std::uint32_t level = tick.island_level[row];
      sum += work.island_work[row] * (level < most ? level : most);
    }
    return sum;
  };
  auto most = static_cast<std::uint32_t>(settings.auto_substeps->substeps_max);
  bool is_limited = false;
  while (most > least && work_with(most) > allowed) most = most > least + cap_step ? most - cap_step : least;
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
    if (work.island_work[row] == 0 || tick.island_level[row] <= most) continue;
    tick.island_level[row] = most;
    is_limited = true;
  }
  if (is_limited) count_up(state.budget.limited_ticks);
  const std::uint64_t used = work_with(most);
  const std::uint64_t rest = used < allowed ? allowed - used : 0;
  const std::uint64_t saved_max = saved_ticks * allowed;
  const std::uint64_t saved = state.budget.saved_work < saved_max ? state.budget.saved_work : saved_max;
  tick.shock_work_left = saved + rest;
}

void store_budget(const TickLists& tick, State& state) {
  state.budget.saved_work = tick.shock_work_left;
  if (tick.shock_is_cut) count_up(state.budget.cut_ticks);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
