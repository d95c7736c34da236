// Islands: bodies connected by contacts and joints. Decides which islands sleep and which are solved together.
// SPDX-License-Identifier: MIT
// Source: Tarjan, "Efficiency of a Good But Not Linear Set Union Algorithm", 1975 (union-find); Anderson, Woll,
// "Wait-free Parallel Algorithms for the Union-Find Problem", 1991 (by several threads at once).
#include "engine/islands/islands.h"

#include <algorithm>
#include <atomic>
#include <bitset>

#include "base/limits.h"
#include "engine/impacts/impacts.h"
#include "engine/model/selection.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// find_root while other threads unite: the result may no longer be a root. Path halving is safe, since the parent of a
/// row that is not a root only moves towards the root.
std::uint32_t find_root_shared(std::vector<std::uint32_t>& parent, std::uint32_t row) {
  for (;;) {
    const std::uint32_t next = __atomic_load_n(&parent[row], __ATOMIC_RELAXED);
    if (next == row) return row;
    const std::uint32_t after = __atomic_load_n(&parent[next], __ATOMIC_RELAXED);
    if (after != next) __atomic_store_n(&parent[row], after, __ATOMIC_RELAXED);
    row = after;
  }
}

/// unite while other threads unite: the roots are the same in any order.
void unite_shared(std::vector<std::uint32_t>& parent, std::uint32_t a, std::uint32_t b) {
  for (;;) {
    const std::uint32_t root_a = find_root_shared(parent, a);
    const std::uint32_t root_b = find_root_shared(parent, b);
    if (root_a == root_b) return;
    const std::uint32_t first = root_a < root_b ? root_a : root_b;
    const std::uint32_t last = root_a < root_b ? root_b : root_a;
    std::uint32_t still_root = last;
    if (__atomic_compare_exchange_n(&parent[last], &still_root, first, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED))
      return;
  }
}

constexpr std::size_t contacts_per_chunk_least = 512;

void unite_by_contacts(TickLists& tick, IslandWork& work) {
  const std::size_t count = tick.contact_pairs.size();
  const std::size_t size = tick.parallel.chunk_size(count, contacts_per_chunk_least);
  tick.parallel.for_chunks(count, size, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const std::uint32_t a = tick.contact_pairs[i].body_a;
      const std::uint32_t b = tick.contact_pairs[i].body_b;
      if (!is_dynamic(work, a) || !is_dynamic(work, b)) continue;
      if (size < count)
        unite_shared(tick.island, a, b);
      else
        unite(tick.island, a, b);
    }
  });
}

/// Calls meet(row, row) for each two bodies of a joint. A gear joins its four bodies.
template <typename Meet>
void for_each_joined_pair(const Model& model, const State& state, Meet meet) {
  for (const JointRow& joint : state.joints) {
    if (joint.body_a == no_reference) continue;
    const std::uint32_t gear = model.joints[joint.joint].gear;
    if (gear == no_gear) {
      meet(row_of(state, joint.body_a), row_of(state, joint.body_b));
      continue;
    }
    const auto& bodies = model.gears[gear].bodies;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t k = i + 1; k < 4; ++k) meet(row_of(state, bodies[i]), row_of(state, bodies[k]));
  }
}

/// Finds tick.island. Contacts, impacts, joints and springs connect dynamic bodies.
void unite_bodies(const Model& model, const State& state, TickLists& tick, IslandWork& work) {
  const std::size_t count = state.bodies.size();
  tick.island.resize(count);
  for (std::uint32_t row = 0; row < count; ++row) tick.island[row] = row;
  const auto meet = [&](std::uint32_t a, std::uint32_t b) {
    if (is_dynamic(work, a) && is_dynamic(work, b)) unite(tick.island, a, b);
  };
  unite_by_contacts(tick, work);
  for (const ImpactPair& pair : tick.impacts) meet(pair.body_a, pair.body_b);
  for_each_joined_pair(model, state, meet);
  for (const SpringForce& spring : model.springs) {
    if (spring.other == no_reference) continue;
    const std::uint32_t a = row_of(state, spring.body);
    const std::uint32_t b = row_of(state, spring.other);
    if (a < count && b < count) meet(a, b);
  }
  // A parent is never behind its row.
  for (std::uint32_t row = 0; row < count; ++row) tick.island[row] = tick.island[tick.island[row]];
}

// ---- Sleep ----

constexpr std::size_t bodies_per_chunk_least = 512;

/// Calls predicate(row) for each body. True if it was true for any.
template <typename Predicate>
bool any_body(const TickLists& tick, std::size_t count, Predicate predicate) {
  std::atomic<bool> any{false};
  tick.parallel.for_chunks(count, tick.parallel.chunk_size(count, bodies_per_chunk_least, 64), [&](const Chunk& chunk) {
    bool found = false;
    for (std::size_t row = chunk.begin; row < chunk.end; ++row) found |= predicate(static_cast<std::uint32_t>(row));
    if (found) any.store(true, std::memory_order_relaxed);
  });
  return any.load(std::memory_order_relaxed);
}

/// Fills work.body_types. True if some body disturbs what it touches.
bool find_types(const Model& model, const State& state, TickLists& tick, IslandWork& work) {
  work.body_types.resize(state.bodies.size());
  return any_body(tick, state.bodies.size(), [&](std::uint32_t row) {
    work.body_types[row] = type_of(model, state, row);
    return disturbs(state, tick, work, row);
  });
}

/// Resets the idle timers of bodies that a moving or new immovable body touches, may hit in this tick, or holds by a
/// joint or spring.
void disturb(const Model& model, State& state, TickLists& tick, IslandWork& work) {
  const std::size_t count = state.bodies.size();
  const auto meet = [&](std::uint32_t a, std::uint32_t b) {
    Real none = 0;  // several contacts of a body may write at once
    if (disturbs(state, tick, work, b)) __atomic_store(&state.sleep[a].calm, &none, __ATOMIC_RELAXED);
    if (disturbs(state, tick, work, a)) __atomic_store(&state.sleep[b].calm, &none, __ATOMIC_RELAXED);
  };
  const std::size_t contact_count = tick.contact_pairs.size();
  tick.parallel.for_chunks(contact_count, tick.parallel.chunk_size(contact_count, contacts_per_chunk_least),
                           [&](const Chunk& chunk) {
                             for (std::size_t i = chunk.begin; i < chunk.end; ++i)
                               meet(tick.contact_pairs[i].body_a, tick.contact_pairs[i].body_b);
                           });
  for (const ImpactPair& pair : tick.impacts) meet(pair.body_a, pair.body_b);
  for_each_joined_pair(model, state, meet);
  for (const SpringForce& spring : model.springs) {
    if (spring.other == no_reference) continue;
    const std::uint32_t a = row_of(state, spring.body);
    const std::uint32_t b = row_of(state, spring.other);
    if (a < count && b < count) meet(a, b);
  }
}

/// Whether a body has been idle long enough to sleep with its island. A body that moves or was disturbed has an idle
/// time of 0, which is never enough, also where the scene waits for no time at all.
bool may_sleep(const Model& model, const State& state, std::uint32_t row) {
  const Real calm = state.sleep[row].calm;
  return calm > 0 && calm >= static_cast<Real>(model.scene.settings.sleep->after_s);
}

void wake(SleepRow& sleep) {
  if (sleep.asleep != 0) sleep.calm = 0;
  sleep.asleep = 0;
}

/// Resets the idle timers of dragged and disturbed bodies. Wakes all bodies if no body may sleep; true in this case.
bool stay_awake(const Model& model, State& state, TickLists& tick, IslandWork& work, bool some_disturb) {
  if (!model.scene.settings.sleep) return true;
  for (const PointerRow& pointer : state.pointers) state.sleep[state.find_body(pointer.body)].calm = 0;
  if (some_disturb) disturb(model, state, tick, work);
  const std::size_t count = state.bodies.size();
  if (any_body(tick, count, [&](std::uint32_t row) { return is_dynamic(work, row) && may_sleep(model, state, row); }))
    return false;
  for (std::uint32_t row = 0; row < count; ++row)
    if (is_dynamic(work, row)) wake(state.sleep[row]);
  return true;
}

/// An island sleeps if all its bodies may sleep. Requires: islands are united.
void sleep_by_islands(const Model& model, State& state, TickLists& tick, IslandWork& work) {
  const std::size_t count = state.bodies.size();
  work.island_awake.assign(count, 0);
  work.all_are_held = true;
  for (std::uint32_t row = 0; row < count; ++row)
    if (is_dynamic(work, row) && !may_sleep(model, state, row)) work.island_awake[tick.island[row]] = 1;
  for (std::uint32_t row = 0; row < count; ++row) {
    if (!is_dynamic(work, row)) continue;
    if (work.island_awake[tick.island[row]] != 0) {
      wake(state.sleep[row]);
      work.all_are_held = false;
      continue;
    }
    state.sleep[row].asleep = 1;
    state.bodies[row].velocity = {0, 0};
    state.bodies[row].angular_velocity = 0;
  }
}

/// Lists the bodies and contacts of the islands that are solved. Dynamic bodies that touch are in the same island.
void list_awake(const State& state, const TickLists& tick, IslandWork& work) {
  work.awake_rows.clear();
  work.dynamic_count = 0;
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
    if (!is_dynamic(work, row)) continue;
    ++work.dynamic_count;
    if (work.island_awake[tick.island[row]] != 0) work.awake_rows.push_back(row);
  }
  work.awake_contacts.clear();
  for (std::uint32_t i = 0; i < tick.contact_pairs.size(); ++i) {
    const ContactPair& pair = tick.contact_pairs[i];
    if (is_awake(tick, work, is_dynamic(work, pair.body_a) ? pair.body_a : pair.body_b))
      work.awake_contacts.push_back(i);
  }
}

// ---- Solver sets ----

constexpr std::uint32_t key_of_no_set = 0;  // asleep, or static
constexpr std::uint32_t key_of_all_sets = 1;
constexpr std::uint32_t key_least = 2;
constexpr std::uint32_t key_count = 2 * limits::substep_count_max + 2;

/// Fills work.set_keys. Keys ascend with the number of substeps; sets with resting impacts come after sets without.
void find_set_keys(TickLists& tick, IslandWork& work) {
  const std::size_t count = work.body_types.size();
  work.set_keys.resize(count);
  for (std::uint32_t row = 0; row < count; ++row) {
    const BodyType type = work.body_types[row];
    std::uint32_t key = type == BodyType::kinematic_body ? key_of_all_sets : key_of_no_set;
    if (type == BodyType::dynamic_body) {
      const std::uint32_t root = tick.island[row];
      if (work.island_awake[root] != 0) key = 2 * tick.island_level[root] + tick.island_has_resting_impact[root];
    }
    work.set_keys[row] = key;
  }
}

void add_solver_set(const Model& model, const State& state, TickLists& tick, IslandWork& work, std::uint32_t key) {
  const auto index = static_cast<std::uint32_t>(tick.solver_sets.size());
  SolverSet set;
  set.substeps = static_cast<int>(key / 2);
  set.has_resting_impacts = key % 2 != 0;
  set.first_row = static_cast<std::uint32_t>(tick.set_rows.size());
  set.first_contact = static_cast<std::uint32_t>(tick.set_contacts.size());
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
    if (work.set_keys[row] != key && work.set_keys[row] != key_of_all_sets) continue;
    tick.set_rows.push_back(row);
    tick.body_solver_set[row] = index;
  }
  const auto select = [&](std::size_t begin, std::size_t end, std::uint32_t* out) {
    std::size_t count = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t contact = work.awake_contacts[i];
      const ContactPair& pair = tick.contact_pairs[contact];
      const std::uint32_t of_a = work.set_keys[pair.body_a];
      // Dynamic bodies that touch are in the same island.
      if ((of_a < key_least ? work.set_keys[pair.body_b] : of_a) == key &&
          !is_left_to_impacts(model, state, tick, contact))
        out[count++] = contact;
    }
    return count;
  };
  tick.set_contacts.resize(set.first_contact + work.awake_contacts.size());
  const std::size_t contact_count =
      select_in_chunks(tick.parallel, work.part_counts, work.awake_contacts.size(), contacts_per_chunk_least,
                       tick.set_contacts.data() + set.first_contact, select);
  tick.set_contacts.resize(set.first_contact + contact_count);
  set.row_end = static_cast<std::uint32_t>(tick.set_rows.size());
  set.contact_end = static_cast<std::uint32_t>(tick.set_contacts.size());
  tick.solver_sets.push_back(set);
}

/// Makes one solver set of the islands with equal substeps, fewest substeps first. Islands with resting impacts have
/// their own set. Moving kinematic bodies are in every set.
void make_solver_sets(const Model& model, const State& state, TickLists& tick, IslandWork& work) {
  tick.solver_sets.clear();
  tick.set_rows.clear();
  tick.set_contacts.clear();
  tick.body_solver_set.assign(state.bodies.size(), no_solver_set);
  find_set_keys(tick, work);
  std::bitset<key_count> in_use;
  std::uint32_t last = 2 * static_cast<std::uint32_t>(model.scene.settings.substeps);
  in_use[last] = true;  // always, for kinematic bodies
  for (const std::uint32_t key : work.set_keys) {
    in_use[key] = true;
    last = std::max(last, key);
  }
  for (std::uint32_t key = key_least; key <= last; ++key)
    if (in_use[key]) add_solver_set(model, state, tick, work, key);
}

}  // namespace

void IslandFinder::run(const Model& model, State& state, TickLists& tick, Real dt) {
  const bool some_disturb = find_types(model, state, tick, work_);
  const bool all_awake = stay_awake(model, state, tick, work_, some_disturb);
  // While all bodies are awake and have equal substeps, islands have no effect.
  tick.has_solver_sets = !all_awake || model.scene.settings.auto_substeps;
  if (!tick.has_solver_sets) return;
  unite_bodies(model, state, tick, work_);
  work_.all_are_held = false;
  if (all_awake)
    work_.island_awake.assign(state.bodies.size(), 1);
  else
    sleep_by_islands(model, state, tick, work_);
  if (holds_islands(model)) hold_islands(model, state, tick, work_, dt);
  list_awake(state, tick, work_);
  choose_substeps(model, state, tick, work_, dt);
  make_solver_sets(model, state, tick, work_);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
