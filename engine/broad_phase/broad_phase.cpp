// Proxies and limits that all broad phases share; the two without a data structure.
// SPDX-License-Identifier: MIT
#include "engine/broad_phase/broad_phase.h"

#include "engine/broad_phase/aabb_tree.h"
#include "engine/model/motion_bounds.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

using BroadPhaseFunction = void (*)(const Model& model, State& state, TickLists& tick, BroadPhaseWork& work, Real dt);

/// A broad phase that caches nothing.
class PlainBroadPhase final : public Stage {
 public:
  explicit PlainBroadPhase(BroadPhaseFunction list_pairs) : list_pairs_(list_pairs) {}
  void run(const Model& model, State& state, TickLists& tick, Real dt) override {
    list_pairs_(model, state, tick, work_, dt);
  }
  void poison() override { list_fields(work_, Poison{}); }

 private:
  BroadPhaseFunction list_pairs_;
  BroadPhaseWork work_;
};

struct BroadPhaseEntry {
  BroadPhaseKind kind;
  std::unique_ptr<Stage> (*make)();
};
template <BroadPhaseFunction list_pairs>
std::unique_ptr<Stage> make_plain() {
  return std::make_unique<PlainBroadPhase>(list_pairs);
}
constexpr std::array<BroadPhaseEntry, broad_phases.size()> entries{{
    {BroadPhaseKind::brute_force, make_plain<brute_force>},
    {BroadPhaseKind::bounding_circle, make_plain<bounding_circle>},
    {BroadPhaseKind::sweep_and_prune, make_plain<sweep_and_prune>},
    {BroadPhaseKind::uniform_grid, make_plain<uniform_grid>},
    {BroadPhaseKind::aabb_tree, []() -> std::unique_ptr<Stage> { return std::make_unique<AabbTree>(); }},
}};
static_assert(rows_are_in_order(entries));

}  // namespace

std::unique_ptr<Stage> make_broad_phase(BroadPhaseKind kind) {
  return info_of(entries, kind).make();
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

void make_proxies(const Model& model, const State& state, TickLists& tick, BroadPhaseWork& work, Real dt) {
  tick.changes = {};
  const Real gravity_displacement = gravity_displacement_of_tick(model, state);
  const MotionBounds bounds = motion_bounds_of_tick(model, state, dt);
  work.proxy_rows.clear();
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) add_proxies(model, state, row, work.proxy_rows);
  tick.proxies = work.proxy_rows;
  work.boxes.clear();
  for (Proxy& proxy : work.proxy_rows) {
    const BodyRow& body = state.bodies[proxy.body];
    const Real swept = swept_displacement_of_row(model, state, bounds, proxy.body);
    work.boxes.push_back(box_around(model, body, model.shapes[proxy.shape], gravity_displacement, swept));
    proxy.ccd_margin = ccd_margin_of(bounds, model.bodies[body.source], swept);
  }
}

bool are_too_many(TickLists& tick, std::size_t pair_count) {
  if (pair_count <= tick.pair_count_max) return false;
  tick.has_too_many_pairs = true;
  tick.pairs = {};
  return true;
}

void brute_force(const Model& model, State& state, TickLists& tick, BroadPhaseWork& work, Real dt) {
  make_proxies(model, state, tick, work, dt);
  const std::span<const Proxy> proxies = tick.proxies;
  const std::vector<Box>& boxes = work.boxes;
  work.pair_rows.clear();
  for (std::uint32_t i = 0; i < proxies.size(); ++i) {
    for (std::uint32_t j = i + 1; j < proxies.size(); ++j)
      if (overlaps(boxes[i], boxes[j]) && are_pair(proxies[i], proxies[j], boxes[i], boxes[j]))
        work.pair_rows.push_back({i, j});
    if (are_too_many(tick, work.pair_rows.size())) return;
  }
  tick.pairs = work.pair_rows;
}

namespace {

/// Counts the overlapping pairs of boxes without listing them. Does nothing if the proxies have too few pairs to be too
/// many.
bool boxes_are_too_many(TickLists& tick, const BroadPhaseWork& work) {
  const std::span<const Proxy> proxies = tick.proxies;
  const std::vector<Box>& boxes = work.boxes;
  const std::uint64_t count = proxies.size();
  std::size_t pair_count = 0;
  if (count == 0 || count * (count - 1) / 2 <= tick.pair_count_max) return false;
  for (std::uint32_t i = 0; i < proxies.size(); ++i) {
    for (std::uint32_t j = i + 1; j < proxies.size(); ++j)
      pair_count += overlaps(boxes[i], boxes[j]) && are_pair(proxies[i], proxies[j], boxes[i], boxes[j]) ? 1 : 0;
    if (are_too_many(tick, pair_count)) return true;
  }
  return false;
}

}  // namespace

void bounding_circle(const Model& model, State& state, TickLists& tick, BroadPhaseWork& work, Real dt) {
  make_proxies(model, state, tick, work, dt);
  if (boxes_are_too_many(tick, work)) return;
  const std::span<const Proxy> proxies = tick.proxies;
  const Real gravity_displacement = gravity_displacement_of_tick(model, state);
  const MotionBounds bounds = motion_bounds_of_tick(model, state, dt);
  std::vector<Circle>& circles = work.circles;
  circles.clear();
  for (const Proxy& proxy : proxies)
    circles.push_back(circle_around(state.bodies[proxy.body], model.shapes[proxy.shape], gravity_displacement,
                                    swept_displacement_of_row(model, state, bounds, proxy.body)));
  work.pair_rows.clear();
  for (std::uint32_t i = 0; i < proxies.size(); ++i) {
    for (std::uint32_t j = i + 1; j < proxies.size(); ++j) {
      const Real near = circles[i].radius + circles[j].radius;
      if (length_squared(circles[j].center - circles[i].center) <= near * near && may_touch(proxies[i], proxies[j]))
        work.pair_rows.push_back({i, j});
    }
    // More circles than boxes may overlap. The pairs of boxes are within the limit, and they include all touching
    // pairs.
    if (work.pair_rows.size() > tick.pair_count_max) return brute_force(model, state, tick, work, dt);
  }
  tick.pairs = work.pair_rows;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
