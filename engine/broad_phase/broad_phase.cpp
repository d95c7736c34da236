// What all broad phases share: proxies and the order of pairs.
// SPDX-License-Identifier: MIT
#include "engine/broad_phase/broad_phase.h"

#include "engine/constraints/impacts.h"
#include "engine/narrow_phase/narrow_phase.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

struct BroadPhaseEntry {
  BroadPhaseKind kind;
  StageFunction run;
};
constexpr std::array<BroadPhaseEntry, broad_phases.size()> functions{{
    {BroadPhaseKind::brute_force, brute_force},
    {BroadPhaseKind::bounding_circle, bounding_circle},
    {BroadPhaseKind::sweep_and_prune, sweep_and_prune},
    {BroadPhaseKind::uniform_grid, uniform_grid},
    {BroadPhaseKind::aabb_tree, aabb_tree},
}};

}  // namespace

StageFunction broad_phase_function(BroadPhaseKind kind) {
  return info_of(functions, kind).run;
}

void make_proxies(const Model& model, const State& state, Scratch& scratch, Real dt) {
  const Real fall = fall_of_a_tick(model, state);
  scratch.proxies.clear();
  const Real farthest = farthest_reach(model, state, dt);
  for (std::size_t row = 0; row < state.bodies.size(); ++row) {
    const BodyRow& body = state.bodies[row];
    const BodyModel& constants = model.bodies[body.source];
    const auto index = static_cast<std::uint32_t>(row);
    const Real way = sweep_of(model, state, index, dt, farthest);
    for (std::uint32_t child = 0; child < constants.shape_count; ++child) {
      const std::uint32_t shape_index = model.body_shapes[constants.first_shape + child];
      const ShapeModel& shape = model.shapes[shape_index];
      Proxy proxy;
      proxy.body = static_cast<std::uint32_t>(row);
      proxy.shape = shape_index;
      proxy.child = child;
      proxy.is_dynamic = constants.type == BodyType::dynamic_body;
      proxy.is_static = constants.type == BodyType::static_body;
      proxy.is_sensor = shape.is_sensor;
      proxy.is_line = is_line(shape);
      proxy.filter = shape.filter;
      proxy.center = body.position + rotate(body.rotation, shape.center);
      // The margin covers what the narrow phase calls near, plus the rounding of coordinates this far out, so that no
      // algorithm can miss a pair that another one finds.
      const Real reach = larger(absolute(proxy.center.x), absolute(proxy.center.y)) + shape.bounding_radius;
      const Real margin = speculative_margin(shape.size, fall) + 16 * epsilon * reach;
      proxy.radius = (shape.bounding_radius + margin) + way;
      if (shape.family == ShapeFamily::circle) {
        const Vec2 extent{proxy.radius, proxy.radius};
        proxy.box = {proxy.center - extent, proxy.center + extent};
      } else {
        const Vec2* vertices = &model.vertices[shape.first_vertex];
        Vec2 lower = rotate(body.rotation, vertices[0]);
        Vec2 upper = lower;
        for (std::uint32_t i = 1; i < shape.vertex_count; ++i) {
          const Vec2 v = rotate(body.rotation, vertices[i]);
          lower = {smaller(lower.x, v.x), smaller(lower.y, v.y)};
          upper = {larger(upper.x, v.x), larger(upper.y, v.y)};
        }
        const Real around = (shape.radius + margin) + way;
        const Vec2 extent{around, around};
        proxy.box = {(body.position + lower) - extent, (body.position + upper) + extent};
      }
      scratch.proxies.push_back(proxy);
    }
  }
}

void sort_pairs(Scratch& scratch) {
  // Counting sort by `first`, then insertion sort of each short run by `second`.
  const std::vector<Pair>& in = scratch.unsorted_pairs;
  std::vector<Pair>& out = scratch.pairs;
  std::vector<std::uint32_t>& start = scratch.counts;
  start.assign(scratch.proxies.size() + 1, 0);
  for (const Pair& pair : in) ++start[pair.first + 1];
  for (std::size_t i = 1; i < start.size(); ++i) start[i] += start[i - 1];
  out.resize(in.size());
  for (const Pair& pair : in) out[start[pair.first]++] = pair;
  std::size_t begin = 0;
  for (std::size_t proxy = 0; proxy < scratch.proxies.size(); ++proxy) {
    const std::size_t end = start[proxy];  // after the loop above: where the run of `proxy` ends
    if (end - begin > 64) {
      // A large body, such as the ground: counting sort by `second` over its run.
      std::vector<std::uint32_t>& seen = scratch.order;
      seen.assign(scratch.proxies.size(), 0);
      for (std::size_t i = begin; i < end; ++i) seen[out[i].second] = 1;
      std::size_t next = begin;
      for (std::uint32_t second = 0; second < seen.size(); ++second)
        if (seen[second] != 0) out[next++].second = second;
    } else {
      for (std::size_t i = begin + 1; i < end; ++i) {
        const Pair pair = out[i];
        std::size_t at = i;
        for (; at > begin && out[at - 1].second > pair.second; --at) out[at] = out[at - 1];
        out[at] = pair;
      }
    }
    begin = end;
  }
}

void brute_force(const Model& model, State& state, Scratch& scratch, Real dt) {
  make_proxies(model, state, scratch, dt);
  const std::vector<Proxy>& proxies = scratch.proxies;
  scratch.pairs.clear();
  for (std::uint32_t i = 0; i < proxies.size(); ++i)
    for (std::uint32_t j = i + 1; j < proxies.size(); ++j)
      if (may_touch(proxies[i], proxies[j]) && overlaps(proxies[i].box, proxies[j].box))
        scratch.pairs.push_back({i, j});
}

void bounding_circle(const Model& model, State& state, Scratch& scratch, Real dt) {
  make_proxies(model, state, scratch, dt);
  const std::vector<Proxy>& proxies = scratch.proxies;
  scratch.pairs.clear();
  for (std::uint32_t i = 0; i < proxies.size(); ++i)
    for (std::uint32_t j = i + 1; j < proxies.size(); ++j) {
      if (!may_touch(proxies[i], proxies[j])) continue;
      const Real reach = proxies[i].radius + proxies[j].radius;
      if (length_squared(proxies[j].center - proxies[i].center) <= reach * reach) scratch.pairs.push_back({i, j});
    }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
