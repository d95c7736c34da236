// Selects the pairs whose impacts are located in time.
// SPDX-License-Identifier: MIT
#include "engine/constraints/impacts.h"

#include <atomic>
#include <tuple>

#include "engine/broad_phase/broad_phase.h"
#include "engine/constraints/joint_model.h"
#include "engine/narrow_phase/distance.h"
#include "engine/pipeline.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// The contact of two proxies, or the number of contacts. `first`: where to begin; pairs are asked for in order.
std::uint32_t contact_of(const State& state, const Proxy& a, const Proxy& b, std::uint32_t& first) {
  const std::tuple wanted(state.bodies[a.body].id, a.child, state.bodies[b.body].id, b.child);
  const auto key_of = [](const ContactRow& row) {
    return std::tuple(row.body_a, row.child_a, row.body_b, row.child_b);
  };
  const auto count = static_cast<std::uint32_t>(state.contacts.size());
  while (first < count && key_of(state.contacts[first]) < wanted) ++first;
  return first < count && key_of(state.contacts[first]) == wanted ? first : count;
}

bool any_is_fast(const Model& model, const State& state, const Scratch& scratch, Real dt) {
  std::atomic<bool> any{false};
  const std::size_t count = state.bodies.size();
  scratch.parallel.for_chunks(count, scratch.parallel.chunk_size(count, 256), [&](const Chunk& chunk) {
    for (std::size_t row = chunk.begin; row < chunk.end && !any.load(std::memory_order_relaxed); ++row)
      if (is_fast(model, state, static_cast<std::uint32_t>(row), dt)) any.store(true, std::memory_order_relaxed);
  });
  return any.load(std::memory_order_relaxed);
}

}  // namespace

void find_impacts(const Model& model, State& state, Scratch& scratch, Real dt) {
  const Settings& settings = model.scene.settings;
  scratch.impacts.clear();
  scratch.offsets_in_use = settings.integrator != IntegratorKind::semi_implicit_euler;
  if (!settings.locate_impacts && !any_is_fast(model, state, scratch, dt)) return;
  const Real farthest = farthest_reach(model, state, dt);
  const Real fall = fall_of_a_tick(model, state);
  std::uint32_t next_contact = 0;
  for (const Pair& candidate : scratch.pairs) {
    const Proxy& a = scratch.proxies[candidate.first];
    const Proxy& b = scratch.proxies[candidate.second];
    if (a.is_sensor || b.is_sensor) continue;
    const ShapeModel& shape_a = model.shapes[a.shape];
    const ShapeModel& shape_b = model.shapes[b.shape];
    const Real restitution = mix(settings.restitution_mix, shape_a.restitution, shape_b.restitution);
    const bool bounces = settings.locate_impacts && restitution > 0;
    const bool between_moving = a.is_dynamic && b.is_dynamic;
    const bool guarded = !between_moving || model.bodies[state.bodies[a.body].source].is_bullet ||
                         model.bodies[state.bodies[b.body].source].is_bullet;
    const bool fast =
        settings.continuous && guarded && (is_fast(model, state, a.body, dt) || is_fast(model, state, b.body, dt));
    if (!bounces && !fast) continue;
    const BodyRow& body_a = state.bodies[a.body];
    const BodyRow& body_b = state.bodies[b.body];
    const Real sweep_a = sweep_of(model, state, a.body, dt, farthest);
    const Real sweep_b = sweep_of(model, state, b.body, dt, farthest);
    const Circle circle_a = circle_around(body_a, shape_a, fall, sweep_a);
    const Circle circle_b = circle_around(body_b, shape_b, fall, sweep_b);
    const Real near = circle_a.radius + circle_b.radius;
    if (length_squared(circle_b.center - circle_a.center) > Real(1.01) * (near * near)) continue;
    if (!model.separated.empty() && are_separated(model.separated, body_a.id, body_b.id)) continue;
    const Distance gap =
        distance(model, shape_a, {body_a.position, body_a.rotation}, shape_b, {body_b.position, body_b.rotation});
    if (gap.separation > sweep_a + sweep_b) continue;
    // Beyond the middle the way out is on the other side: that overlap is the contact solver's to undo.
    if (gap.separation < Real(-0.5) * pair_size(shape_a, shape_b)) continue;
    ImpactPair pair{};
    pair.body_a = a.body;
    pair.body_b = b.body;
    pair.shape_a = a.shape;
    pair.shape_b = b.shape;
    pair.friction = mix(settings.friction_mix, shape_a.friction, shape_b.friction);
    pair.restitution = restitution;
    pair.is_fast = fast;
    pair.slow = slow_closing(model, state, scratch, pair, contact_of(state, a, b, next_contact), dt);
    scratch.impacts.push_back(pair);
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
