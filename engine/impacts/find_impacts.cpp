// Selects the pairs whose impacts are located in time.
// SPDX-License-Identifier: MIT
#include "engine/impacts/find_impacts.h"

#include <algorithm>
#include <atomic>
#include <tuple>

#include "engine/joints/joint_model.h"
#include "engine/model/enclosures.h"
#include "engine/model/motion_bounds.h"
#include "engine/narrow_phase/distance.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// The index of the contact of two proxies, or the number of contacts. `first`: the start of the search, or
/// no_reference. Callers ask for pairs in order.
std::uint32_t contact_of(const State& state, const Proxy& a, const Proxy& b, std::uint32_t& first) {
  const std::tuple wanted(state.bodies[a.body].id, a.child, state.bodies[b.body].id, b.child);
  const auto key_of = [](const ContactRow& row) {
    return std::tuple(row.body_a, row.child_a, row.body_b, row.child_b);
  };
  const auto count = static_cast<std::uint32_t>(state.contacts.size());
  if (first == no_reference)
    first =
        static_cast<std::uint32_t>(std::partition_point(state.contacts.begin(), state.contacts.end(),
                                                        [&](const ContactRow& row) { return key_of(row) < wanted; }) -
                                   state.contacts.begin());
  while (first < count && key_of(state.contacts[first]) < wanted) ++first;
  return first < count && key_of(state.contacts[first]) == wanted ? first : count;
}

const BodyModel& constants_of(const Model& model, const BodyRow& body) {
  return model.bodies[body.source];
}

/// Marks the fast bodies. False: no body is fast.
bool find_fast(const Model& model, const State& state, const Parallel& parallel, const MotionBounds& bounds,
               std::vector<std::uint8_t>& fast_rows) {
  std::atomic<bool> any{false};
  const std::size_t count = state.bodies.size();
  fast_rows.resize(count);
  parallel.for_chunks(count, parallel.chunk_size(count, 256), [&](const Chunk& chunk) {
    bool found = false;
    for (std::size_t row = chunk.begin; row < chunk.end; ++row) {
      const bool fast = is_fast(bounds, constants_of(model, state.bodies[row]), state.bodies[row]);
      fast_rows[row] = fast ? 1 : 0;
      found |= fast;
    }
    if (found) any.store(true, std::memory_order_relaxed);
  });
  return any.load(std::memory_order_relaxed);
}

/// Appends the candidate pairs of begin..end-1 whose impacts are located.
void add_impacts(const Model& model, const State& state, const TickLists& tick,
                 const std::vector<std::uint8_t>& fast_rows, const MotionBounds& bounds, std::size_t begin,
                 std::size_t end, std::vector<ImpactPair>& impacts) {
  const Settings& settings = model.scene.settings;
  const Real gravity_displacement = gravity_displacement_of_tick(model, state);
  std::uint32_t next_contact = no_reference;
  for (std::size_t i = begin; i < end; ++i) {
    const Pair& candidate = tick.pairs[i];
    const Proxy& a = tick.proxies[candidate.first];
    const Proxy& b = tick.proxies[candidate.second];
    const bool one_is_fast = (fast_rows[a.body] | fast_rows[b.body]) != 0;
    if (!one_is_fast && !settings.locate_impacts) continue;
    if (a.is_sensor || b.is_sensor) continue;
    const ShapeModel& shape_a = model.shapes[a.shape];
    const ShapeModel& shape_b = model.shapes[b.shape];
    const Real restitution = mix(settings.restitution_mix, shape_a.restitution, shape_b.restitution);
    const bool bounces = settings.locate_impacts && restitution > 0;
    const bool between_moving = a.is_dynamic && b.is_dynamic;
    const bool is_ccd_pair = !between_moving || model.bodies[state.bodies[a.body].source].is_bullet ||
                             model.bodies[state.bodies[b.body].source].is_bullet;
    const BodyRow& body_a = state.bodies[a.body];
    const BodyRow& body_b = state.bodies[b.body];
    const bool fast = settings.continuous && is_ccd_pair && one_is_fast;
    if (!bounces && !fast) continue;
    const Real swept_a = swept_displacement_of(bounds, constants_of(model, body_a), body_a);
    const Real swept_b = swept_displacement_of(bounds, constants_of(model, body_b), body_b);
    const Circle circle_a = circle_around(body_a, shape_a, gravity_displacement, swept_a);
    const Circle circle_b = circle_around(body_b, shape_b, gravity_displacement, swept_b);
    const Real touch_distance = circle_a.radius + circle_b.radius;
    if (length_squared(circle_b.center - circle_a.center) > Real(1.01) * (touch_distance * touch_distance)) continue;
    if (are_separated(model, state, body_a.id, body_b.id)) continue;
    const Distance gap =
        distance(model, shape_a, {body_a.position, body_a.rotation}, shape_b, {body_b.position, body_b.rotation});
    if (gap.separation > swept_a + swept_b) continue;
    // An impact would leave an overlap beyond the middle on the other side. The contact solver corrects such an
    // overlap.
    if (gap.separation < Real(-0.5) * pair_size(shape_a, shape_b)) continue;
    ImpactPair pair{};
    pair.body_a = a.body;
    pair.body_b = b.body;
    pair.shape_a = a.shape;
    pair.shape_b = b.shape;
    pair.friction = mix(settings.friction_mix, shape_a.friction, shape_b.friction);
    pair.restitution = restitution;
    pair.is_fast = fast;
    pair.slow = slow_closing(model, state, tick, pair, contact_of(state, a, b, next_contact), bounds.dt);
    impacts.push_back(pair);
  }
}

}  // namespace

void ImpactFinder::run(const Model& model, State& state, TickLists& tick, Real dt) {
  const Settings& settings = model.scene.settings;
  tick.impacts.clear();
  if (tick.pairs.empty()) return;
  const MotionBounds bounds = motion_bounds_of_tick(model, state, dt);
  // Broad phases that follow bodies know whether any body is fast.
  if (bounds.has_ccd && !bounds.locates_impacts && tick.changes.is_known && !tick.changes.any_swept) return;
  if (!find_fast(model, state, tick.parallel, bounds, work_.is_fast) && !settings.locate_impacts) return;
  const std::size_t count = tick.pairs.size();
  const std::size_t size = tick.parallel.chunk_size(count, 256);
  if (size >= count) return add_impacts(model, state, tick, work_.is_fast, bounds, 0, count, tick.impacts);
  const std::size_t chunk_count = Parallel::chunk_count(count, size);
  if (work_.parts.size() < chunk_count) work_.parts.resize(chunk_count);
  tick.parallel.for_chunks(count, size, [&](const Chunk& chunk) {
    work_.parts[chunk.index].clear();
    add_impacts(model, state, tick, work_.is_fast, bounds, chunk.begin, chunk.end, work_.parts[chunk.index]);
  });
  for (std::size_t i = 0; i < chunk_count; ++i)
    tick.impacts.insert(tick.impacts.end(), work_.parts[i].begin(), work_.parts[i].end());
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
