// Islands: bodies that hang together by contacts and joints. Decides which sleep and what is solved together.
// SPDX-License-Identifier: MIT
// Source: Tarjan, "Efficiency of a Good But Not Linear Set Union Algorithm", 1975 (union-find).
#include "engine/stages/islands.h"

#include "base/limits.h"
#include "engine/constraints/groups.h"
#include "engine/pipeline.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// The smaller row becomes the root, so that an island is named by its first row.
void unite(std::vector<std::uint32_t>& parent, std::uint32_t a, std::uint32_t b) {
  const std::uint32_t root_a = find_root(parent, a);
  const std::uint32_t root_b = find_root(parent, b);
  if (root_a < root_b) parent[root_b] = root_a;
  if (root_b < root_a) parent[root_a] = root_b;
}

bool is_moving(const BodyRow& body) {
  return body.velocity.x != 0 || body.velocity.y != 0 || body.angular_velocity != 0;
}

/// Unites what hangs together; notes islands that something immovable but moving keeps awake.
void unite_bodies(const Model& model, const State& state, Scratch& scratch) {
  const std::size_t count = state.bodies.size();
  scratch.island_parent.resize(count);
  scratch.body_types.resize(count);
  for (std::uint32_t row = 0; row < count; ++row) {
    scratch.island_parent[row] = row;
    scratch.body_types[row] = type_of(model, state, row);
  }
  const auto meet = [&](std::uint32_t a, std::uint32_t b) {
    if (scratch.body_types[a] == BodyType::dynamic_body && scratch.body_types[b] == BodyType::dynamic_body)
      unite(scratch.island_parent, a, b);
  };
  for (const TouchingPair& pair : scratch.touching) meet(pair.body_a, pair.body_b);
  for (const ImpactPair& pair : scratch.impacts) meet(pair.body_a, pair.body_b);
  for (const JointRow& joint : state.joints)
    if (joint.body_a != no_reference) meet(row_of(state, joint.body_a), row_of(state, joint.body_b));
  for (const SpringForce& spring : model.springs) {
    if (spring.other == no_reference) continue;
    const std::uint32_t a = row_of(state, spring.body);
    const std::uint32_t b = row_of(state, spring.other);
    if (a < count && b < count) meet(a, b);
  }
}

// ---- Sleep ----

void wake_and_sleep(const Model& model, State& state, Scratch& scratch) {
  const std::size_t count = state.bodies.size();
  scratch.island_awake.assign(count, model.scene.settings.sleep ? 0 : 1);
  if (!model.scene.settings.sleep) return;
  const Real after = static_cast<Real>(model.scene.settings.sleep->after_s);
  for (const PointerRow& pointer : state.pointers) state.sleep[state.find_body(pointer.body)].calm = 0;
  const auto touch_moving = [&](std::uint32_t still, std::uint32_t other) {
    if (scratch.body_types[other] == BodyType::kinematic_body && is_moving(state.bodies[other]))
      state.sleep[still].calm = 0;
  };
  for (const TouchingPair& pair : scratch.touching) {
    touch_moving(pair.body_a, pair.body_b);
    touch_moving(pair.body_b, pair.body_a);
  }
  for (const JointRow& joint : state.joints) {
    if (joint.body_a == no_reference) continue;
    touch_moving(row_of(state, joint.body_a), row_of(state, joint.body_b));
    touch_moving(row_of(state, joint.body_b), row_of(state, joint.body_a));
  }
  for (const SpringForce& spring : model.springs) {
    if (spring.other == no_reference) continue;
    const std::uint32_t a = row_of(state, spring.body);
    const std::uint32_t b = row_of(state, spring.other);
    if (!(a < count && b < count)) continue;
    touch_moving(a, b);
    touch_moving(b, a);
  }
  for (std::uint32_t row = 0; row < count; ++row)
    if (scratch.body_types[row] == BodyType::dynamic_body && !(state.sleep[row].calm >= after))
      scratch.island_awake[find_root(scratch.island_parent, row)] = 1;
  for (std::uint32_t row = 0; row < count; ++row) {
    if (scratch.body_types[row] != BodyType::dynamic_body) continue;
    SleepRow& sleep = state.sleep[row];
    const bool awake = scratch.island_awake[find_root(scratch.island_parent, row)] != 0;
    if (awake && sleep.asleep != 0) sleep.calm = 0;
    if (!awake) {
      state.bodies[row].velocity = {0, 0};
      state.bodies[row].angular_velocity = 0;
    }
    sleep.asleep = awake ? 0 : 1;
  }
}

// ---- Groups ----

/// Islands of equal substeps into one group each, fewest first; those with landings apart. Everything kinematic moves
/// in each of them.
void make_groups(const Model& model, const State& state, Scratch& scratch) {
  scratch.groups.clear();
  scratch.group_rows.clear();
  scratch.group_contacts.clear();
  scratch.body_group.assign(state.bodies.size(), no_group);
  const auto key_of = [&](std::uint32_t row) {
    const std::uint32_t root = find_root(scratch.island_parent, row);
    return scratch.island_awake[root] != 0 ? 2 * scratch.island_level[root] + scratch.island_lands[root] : 0u;
  };
  bool in_use[2 * limits::substep_count_max + 2] = {};
  in_use[2 * model.scene.settings.substeps] = true;  // always, for what is kinematic
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row)
    if (type_of(model, state, row) == BodyType::dynamic_body) in_use[key_of(row)] = true;
  for (std::uint32_t key = 2; key <= 2 * limits::substep_count_max + 1; ++key) {
    if (!in_use[key]) continue;
    const auto index = static_cast<std::uint32_t>(scratch.groups.size());
    SolveGroup group;
    group.substeps = static_cast<int>(key / 2);
    group.has_landings = key % 2 != 0;
    group.first_row = static_cast<std::uint32_t>(scratch.group_rows.size());
    group.first_contact = static_cast<std::uint32_t>(scratch.group_contacts.size());
    for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
      const BodyType type = type_of(model, state, row);
      if (type == BodyType::static_body) continue;
      if (type == BodyType::dynamic_body && key_of(row) != key) continue;
      scratch.group_rows.push_back(row);
      scratch.body_group[row] = index;
    }
    for (std::uint32_t contact = 0; contact < scratch.touching.size(); ++contact) {
      const TouchingPair& pair = scratch.touching[contact];
      const bool a_moves = type_of(model, state, pair.body_a) == BodyType::dynamic_body;
      if (key_of(a_moves ? pair.body_a : pair.body_b) == key && !is_left_to_impacts(model, state, scratch, contact))
        scratch.group_contacts.push_back(contact);
    }
    group.row_end = static_cast<std::uint32_t>(scratch.group_rows.size());
    group.contact_end = static_cast<std::uint32_t>(scratch.group_contacts.size());
    scratch.groups.push_back(group);
  }
}

}  // namespace

void find_islands(const Model& model, State& state, Scratch& scratch, Real dt) {
  unite_bodies(model, state, scratch);
  wake_and_sleep(model, state, scratch);
  choose_substeps(model, state, scratch, dt);
  make_groups(model, state, scratch);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
