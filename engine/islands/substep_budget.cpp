// The budget of automatic substeps: levels of islands, and the work left to resting impacts.
// SPDX-License-Identifier: MIT
#include "engine/islands/substep_budget.h"

#include <algorithm>

#include "base/limits.h"
#include "engine/islands/islands.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

// The work of a substep, in contacts solved once.
constexpr std::uint64_t work_of_body = 1;
constexpr std::uint64_t work_of_contact = 3;  // solve, relax, warm start
constexpr std::uint64_t work_of_joint = 4;
constexpr std::uint64_t work_of_direct_joint = 20;
constexpr std::uint64_t work_of_driven_direct_joint = 80;  // springs, motors and limits: the solve is repeated
constexpr std::uint64_t work_of_impact = 130;              // a pair whose impacts are located

// Small scenes count as this: twenty boxes before a ram then have 256 substeps, in about .3 ms.
constexpr std::uint64_t substep_least = 352;
constexpr std::uint32_t cap_step = 8;  // substeps
// Resting impacts may use what this many ticks have left over.
constexpr std::uint64_t saved_ticks = 5;

void count_up(std::uint32_t& count) {
  if (count != no_reference) ++count;
}

std::uint64_t direct_work(const JointModel& joint) {
  const bool is_driven = joint.spring.exists || joint.has_motor || joint.has_limits;
  return is_driven ? work_of_driven_direct_joint : work_of_direct_joint;
}

/// Finds the work of a substep of each awake island, at its first row. Returns the sum with iterative joints, which
/// fixed substeps have. The sum has held islands, too: they use nothing of their budget.
std::uint64_t find_work(const Model& model, const State& state, TickLists& tick, IslandWork& work) {
  std::vector<std::uint64_t>& of_island = work.island_work;
  of_island.assign(state.bodies.size(), 0);
  work.has_direct.assign(state.bodies.size(), 0);
  const bool holds = holds_islands(model);
  std::uint64_t sum = 0;
  const auto root_of = [&](std::uint32_t a, std::uint32_t b) {
    const bool a_moves = a != no_reference && is_dynamic(work, a);
    return tick.island[a_moves ? a : b];
  };
  const auto add = [&](std::uint32_t root, std::uint64_t amount, std::uint64_t fixed_amount) {
    const bool is_solved = work.island_awake[root] != 0;
    if (is_solved) of_island[root] += amount;
    if (is_solved || holds) sum += fixed_amount;
  };
  for (const std::uint32_t row : work.awake_rows) add(tick.island[row], work_of_body, work_of_body);
  for (std::size_t i = 0; i < state.joints.size(); ++i) {
    const JointRow& joint = state.joints[i];
    const std::uint32_t a = joint.body_a == no_reference ? no_reference : row_of(state, joint.body_a);
    const std::uint32_t root = root_of(a, row_of(state, joint.body_b));
    const bool is_direct = i < work.direct.is_direct.size() && work.direct.is_direct[i] != 0;
    if (is_direct) work.has_direct[root] = 1;
    add(root, is_direct ? direct_work(model.joints[joint.joint]) : work_of_joint, work_of_joint);
  }
  // Contacts beside direct joints are solved in two turns (direct_set.h).
  const auto add_pair = [&](const auto& pair, std::uint64_t amount) {
    const std::uint32_t root = root_of(pair.body_a, pair.body_b);
    add(root, work.has_direct[root] != 0 ? 2 * amount : amount, amount);
  };
  for (const std::uint32_t contact : work.awake_contacts) add_pair(tick.contact_pairs[contact], work_of_contact);
  for (const ImpactPair& pair : tick.impacts) add_pair(pair, work_of_impact);
  if (holds)
    sum += work_of_body * (work.dynamic_count - work.awake_rows.size()) +
           work_of_contact * (tick.contact_pairs.size() - work.awake_contacts.size());
  return sum;
}

/// Lowers the largest levels, but none below `kept`, until the work of the tick is at most `allowed`, or none is above
/// the least. Returns that work.
std::uint64_t lower_levels(const Settings& settings, std::uint64_t allowed, const std::vector<std::uint32_t>& kept,
                           TickLists& tick, const IslandWork& work) {
  const auto least = static_cast<std::uint32_t>(settings.substeps);
  std::uint64_t of_level[limits::substep_count_max + 1] = {};  // the work of a substep
  std::uint64_t of_kept[limits::substep_count_max + 1] = {};
  for (std::size_t row = 0; row < tick.island_level.size(); ++row) {
    of_level[tick.island_level[row]] += work.island_work[row];
    of_kept[kept[row]] += work.island_work[row];
  }
  const auto work_with = [&](std::uint32_t most) {
    std::uint64_t sum = 0;
    for (std::uint32_t level = 0; level <= limits::substep_count_max; ++level) {
      sum += of_level[level] * std::min(level, most);
      if (level > most) sum += of_kept[level] * (level - most);
    }
    return sum;
  };
  auto most = static_cast<std::uint32_t>(settings.auto_substeps->substeps_max);
  while (most > least && work_with(most) > allowed) most = most > least + cap_step ? most - cap_step : least;
  for (std::size_t row = 0; row < tick.island_level.size(); ++row)
    if (work.island_work[row] != 0)
      tick.island_level[row] = std::max(std::min(tick.island_level[row], most), kept[row]);
  return work_with(most);
}

}  // namespace

void apply_budget(const Model& model, State& state, TickLists& tick, IslandWork& work) {
  const std::uint64_t per_substep = find_work(model, state, tick, work);
  const Settings& settings = model.scene.settings;
  const std::uint64_t allowed =
      static_cast<std::uint64_t>(settings.substep_budget) * (per_substep > substep_least ? per_substep : substep_least);
  std::uint64_t used = 0;
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) used += work.island_work[row] * tick.island_level[row];
  // Islands that needed more lately, and do not any more, fall first. If that is enough, they begin from there in the
  // next tick.
  if (used > allowed) {
    used = lower_levels(settings, allowed, work.needed_level, tick, work);
    if (used <= allowed)
      for (const std::uint32_t row : work.awake_rows) {
        std::uint32_t& count = state.substeps[row].count;
        count = std::min(count, tick.island_level[tick.island[row]]);
      }
  }
  if (used > allowed) {
    const std::uint64_t needed = used;
    work.needed_level.assign(state.bodies.size(), 0);
    used = lower_levels(settings, allowed, work.needed_level, tick, work);
    if (used < needed) count_up(state.budget.limited_ticks);
  }
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
