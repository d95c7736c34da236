// Proxies and limits that all broad phases share; the two without a data structure.
// SPDX-License-Identifier: MIT
#include "engine/broad_phase/broad_phase.h"

#include "engine/narrow_phase/motion_bounds.h"
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

void add_proxies(const Model& model, const State& state, std::uint32_t row, std::vector<Proxy>& proxies) {
  const BodyModel& constants = model.bodies[state.bodies[row].source];
  for (std::uint32_t child = 0; child < constants.shape_count; ++child) {
    const std::uint32_t place = constants.first_shape + child;
    if (model.is_non_colliding[place] != 0) continue;
    const ShapeModel& shape = model.shapes[model.body_shapes[place]];
    proxies.push_back({row, model.body_shapes[place], child, constants.type == BodyType::dynamic_body,
                       constants.type == BodyType::static_body, shape.is_sensor, is_line(shape), shape.filter, -1});
  }
}

namespace {

Real swept_displacement_of_row(const Model& model, const State& state, const MotionBounds& bounds, std::uint32_t row) {
  return swept_displacement_of(bounds, model.bodies[state.bodies[row].source], state.bodies[row]);
}

}  // namespace

Box box_around_hull(const Model& model, const BodyRow& body, const ShapeModel& shape, Real gravity_displacement,
                    Real swept) {
  const Vec2* vertices = &model.vertices[shape.first_vertex];
  Vec2 lower = rotate(body.rotation, vertices[0]);
  Vec2 upper = lower;
  for (std::uint32_t i = 1; i < shape.vertex_count; ++i) {
    const Vec2 v = rotate(body.rotation, vertices[i]);
    lower = {smaller(lower.x, v.x), smaller(lower.y, v.y)};
    upper = {larger(upper.x, v.x), larger(upper.y, v.y)};
  }
  return box_between(body, shape, lower, upper, gravity_displacement, swept);
}

void make_proxies(const Model& model, const State& state, Scratch& scratch, Real dt) {
  scratch.caches.pairs.is_valid = false;  // of another broad phase
  scratch.caches.has_contact_pairs = false;
  const Real gravity_displacement = gravity_displacement_of_tick(model, state);
  const MotionBounds bounds = motion_bounds_of_tick(model, state, dt);
  scratch.proxy_rows.clear();
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) add_proxies(model, state, row, scratch.proxy_rows);
  scratch.proxies = scratch.proxy_rows;
  scratch.boxes.clear();
  for (Proxy& proxy : scratch.proxy_rows) {
    const BodyRow& body = state.bodies[proxy.body];
    const Real swept = swept_displacement_of_row(model, state, bounds, proxy.body);
    scratch.boxes.push_back(box_around(model, body, model.shapes[proxy.shape], gravity_displacement, swept));
    proxy.ccd_margin = ccd_margin_of(bounds, model.bodies[body.source], swept);
  }
}

bool are_too_many(Scratch& scratch, std::size_t pair_count) {
  if (pair_count <= scratch.pair_count_max) return false;
  scratch.has_too_many_pairs = true;
  forget(scratch, all_caches);
  scratch.pairs = {};
  return true;
}

void brute_force(const Model& model, State& state, Scratch& scratch, Real dt) {
  make_proxies(model, state, scratch, dt);
  const std::span<const Proxy> proxies = scratch.proxies;
  const std::vector<Box>& boxes = scratch.boxes;
  scratch.pair_rows.clear();
  for (std::uint32_t i = 0; i < proxies.size(); ++i) {
    for (std::uint32_t j = i + 1; j < proxies.size(); ++j)
      if (overlaps(boxes[i], boxes[j]) && are_pair(proxies[i], proxies[j], boxes[i], boxes[j]))
        scratch.pair_rows.push_back({i, j});
    if (are_too_many(scratch, scratch.pair_rows.size())) return;
  }
  scratch.pairs = scratch.pair_rows;
}

namespace {

/// Counts the pairs of overlapping boxes without listing them. Skips the count where there are too few proxies for too
/// many pairs.
bool boxes_are_too_many(Scratch& scratch) {
  const std::span<const Proxy> proxies = scratch.proxies;
  const std::vector<Box>& boxes = scratch.boxes;
  const std::uint64_t count = proxies.size();
  std::size_t pair_count = 0;
  if (count == 0 || count * (count - 1) / 2 <= scratch.pair_count_max) return false;
  for (std::uint32_t i = 0; i < proxies.size(); ++i) {
    for (std::uint32_t j = i + 1; j < proxies.size(); ++j)
      pair_count += overlaps(boxes[i], boxes[j]) && are_pair(proxies[i], proxies[j], boxes[i], boxes[j]) ? 1 : 0;
    if (are_too_many(scratch, pair_count)) return true;
  }
  return false;
}

}  // namespace

void bounding_circle(const Model& model, State& state, Scratch& scratch, Real dt) {
  make_proxies(model, state, scratch, dt);
  if (boxes_are_too_many(scratch)) return;
  const std::span<const Proxy> proxies = scratch.proxies;
  const Real gravity_displacement = gravity_displacement_of_tick(model, state);
  const MotionBounds bounds = motion_bounds_of_tick(model, state, dt);
  std::vector<Circle>& circles = scratch.circles;
  circles.clear();
  for (const Proxy& proxy : proxies)
    circles.push_back(circle_around(state.bodies[proxy.body], model.shapes[proxy.shape], gravity_displacement,
                                    swept_displacement_of_row(model, state, bounds, proxy.body)));
  scratch.pair_rows.clear();
  for (std::uint32_t i = 0; i < proxies.size(); ++i) {
    for (std::uint32_t j = i + 1; j < proxies.size(); ++j) {
      const Real radius_sum = circles[i].radius + circles[j].radius;
      if (length_squared(circles[j].center - circles[i].center) <= radius_sum * radius_sum &&
          may_touch(proxies[i], proxies[j]))
        scratch.pair_rows.push_back({i, j});
    }
    // More circles may overlap than pairs are allowed. The pairs of boxes are within the limit, and contain all
    // touching pairs.
    if (scratch.pair_rows.size() > scratch.pair_count_max) return brute_force(model, state, scratch, dt);
  }
  scratch.pairs = scratch.pair_rows;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
