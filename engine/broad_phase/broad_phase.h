// Broad phase: pairs of shapes that may touch. Every algorithm gives the same bits: any superset of the touching pairs
// is enough, since the narrow phase decides on contacts, and pairs are sorted before it.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "engine/broad_phase/broad_phase_work.h"
#include "engine/model/model.h"
#include "engine/model/stage.h"
#include "engine/model/tick_lists.h"
#include "engine/narrow_phase/narrow_phase.h"
#include "engine/simd/realx4.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The stage of this kind.
std::unique_ptr<Stage> make_broad_phase(BroadPhaseKind kind);

/// Appends a proxy for each shape of the body at `row` that can touch another.
void add_proxies(const Model& model, const State& state, std::uint32_t row, std::vector<Proxy>& proxies);

/// The margin around a shape, besides its swept displacement: the speculative margin plus the rounding of coordinates
/// this far out. No algorithm can then miss a pair that another one finds.
inline Real margin_around(Vec2 center, const ShapeModel& shape, Real gravity_displacement) {
  const Real extent = larger(magnitude(center.x), magnitude(center.y)) + shape.bounding_radius;
  return speculative_margin(shape.size, gravity_displacement) + 16 * epsilon * extent;
}

/// The circle and the box around a shape of a body with its margin and its swept displacement in this tick
/// (swept_displacement_of). If the narrow phase finds contact points, circles and boxes of the two shapes overlap.
/// `gravity_displacement`: gravity_displacement_of_tick.
inline Circle circle_around(const BodyRow& body, const ShapeModel& shape, Real gravity_displacement, Real swept) {
  const Vec2 center = body.position + rotate(body.rotation, shape.center);
  return {center, (shape.bounding_radius + margin_around(center, shape, gravity_displacement)) + swept};
}
Box box_around_hull(const Model& model, const BodyRow& body, const ShapeModel& shape, Real gravity_displacement,
                    Real swept);
/// `lower`, `upper`: of its vertices, from the body's position.
inline Box box_between(const BodyRow& body, const ShapeModel& shape, Vec2 lower, Vec2 upper, Real gravity_displacement,
                       Real swept) {
  const Vec2 center = body.position + rotate(body.rotation, shape.center);
  const Real around = (shape.radius + margin_around(center, shape, gravity_displacement)) + swept;
  const Vec2 extent{around, around};
  return {(body.position + lower) - extent, (body.position + upper) + extent};
}
inline Box box_around_quad(const Quad& corners, const BodyRow& body, const ShapeModel& shape, Real gravity_displacement,
                           Real swept) {
  const Realx4 x = load_x4(corners.x);
  const Realx4 y = load_x4(corners.y);
  const Rotation q = body.rotation;
  const Realx4 rotated_x = q.c * x - q.s * y;
  const Realx4 rotated_y = q.s * x + q.c * y;
  return box_between(body, shape, {smallest_lane(rotated_x), smallest_lane(rotated_y)},
                     {largest_lane(rotated_x), largest_lane(rotated_y)}, gravity_displacement, swept);
}
inline Box box_around(const Model& model, const BodyRow& body, const ShapeModel& shape, Real gravity_displacement,
                      Real swept) {
  if (shape.quad != no_quad) return box_around_quad(model.quads[shape.quad], body, shape, gravity_displacement, swept);
  if (shape.family != ShapeFamily::circle) return box_around_hull(model, body, shape, gravity_displacement, swept);
  const Circle circle = circle_around(body, shape, gravity_displacement, swept);
  const Vec2 extent{circle.radius, circle.radius};
  return {circle.center - extent, circle.center + extent};
}

/// Fills tick.proxies and work.boxes from the present poses.
void make_proxies(const Model& model, const State& state, TickLists& tick, BroadPhaseWork& work, Real dt);

/// The rule of scene.h: one non-zero group decides; else each category must be in the other's mask.
inline bool pass(const Filter& a, const Filter& b) {
  if (a.group == b.group && a.group != 0) return a.group > 0;
  return (a.mask & b.category) != 0 && (b.mask & a.category) != 0;
}

/// Whether two proxies may touch in any pose: they have different bodies, their filters allow it, and one of them is no
/// line. Contacts need a dynamic proxy. Overlaps with a sensor need one that is not static; sensors do not detect
/// sensors.
inline bool may_touch(const Proxy& a, const Proxy& b) {
  if (a.body == b.body || !pass(a.filter, b.filter) || (a.is_line && b.is_line)) return false;
  if (a.is_sensor || b.is_sensor) return a.is_sensor != b.is_sensor && !(a.is_static && b.is_static);
  return a.is_dynamic || b.is_dynamic;
}

/// A box without its CCD margin.
inline Box inner_box(const Box& box, Real ccd_margin) {
  const Vec2 extent{ccd_margin, ccd_margin};
  return ccd_margin > 0 ? Box{box.lower + extent, box.upper - extent} : box;
}

/// Whether two proxies with overlapping boxes are a pair.
inline bool are_pair(const Proxy& a, const Proxy& b, const Box& box_a, const Box& box_b) {
  if (!may_touch(a, b)) return false;
  if (a.ccd_margin < 0 || b.ccd_margin < 0 || a.ccd_margin + b.ccd_margin <= 0) return true;
  return overlaps(inner_box(box_a, a.ccd_margin), inner_box(box_b, b.ccd_margin));
}

/// Whether so many pairs are more than a tick may have; then also gives up: notes it and lists none. What counts are
/// pairs (are_pair) whose boxes overlap, so that every broad phase gives up in the same tick.
bool are_too_many(TickLists& tick, std::size_t pair_count);

/// Sorts work.unsorted_pairs (each pair once, any order) into `pairs`.
void sort_pairs(const Parallel& parallel, BroadPhaseWork& work, std::size_t proxy_count, std::vector<Pair>& pairs);
/// The same, as the pairs of this tick.
inline void list_sorted(TickLists& tick, BroadPhaseWork& work, std::size_t proxy_count) {
  sort_pairs(tick.parallel, work, proxy_count, work.pair_rows);
  tick.pairs = work.pair_rows;
}

void brute_force(const Model& model, State& state, TickLists& tick, BroadPhaseWork& work, Real dt);
void bounding_circle(const Model& model, State& state, TickLists& tick, BroadPhaseWork& work, Real dt);
void sweep_and_prune(const Model& model, State& state, TickLists& tick, BroadPhaseWork& work, Real dt);
void uniform_grid(const Model& model, State& state, TickLists& tick, BroadPhaseWork& work, Real dt);

/// The largest integer not above `value`, at most `limit` away from 0; 0 for a NaN. Never decreases as `value` rises.
/// Requires: limit is a power of two, at most 2^30.
inline std::int32_t clamped_floor(Real value, Real limit) {
  if (!(value > -limit)) return value == value ? -static_cast<std::int32_t>(limit) : 0;
  if (value >= limit) return static_cast<std::int32_t>(limit);
  const auto whole = static_cast<std::int32_t>(value);
  return static_cast<Real>(whole) > value ? whole - 1 : whole;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
