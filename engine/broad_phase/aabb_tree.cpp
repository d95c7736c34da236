// A tree of fat AABBs and a list of overlapping pairs, cached from tick to tick.
// SPDX-License-Identifier: MIT
// Source: Verlet, "Computer Experiments on Classical Fluids I", 1967 (neighbour lists with a margin, valid until a
// particle has moved as far).
//
// Each shape has a fat AABB. While each shape stays inside its fat AABB, the list of overlapping fat AABBs contains
// every pair that may touch. A shape that leaves gets a new fat AABB and new pairs. It is then a moved proxy, whose box
// in the tree no longer counts. With many moved proxies everything is built anew. Listed are the pairs whose tight
// AABBs overlap. These are the pairs of the other algorithms and a few more. The tight AABB of a slow body is enlarged
// by a margin (`box_margin_share`), so that it stays valid for some ticks. If more fat AABBs overlap than a tick may
// have pairs, only pairs of tight AABBs are listed and nothing is cached. If the list was valid for a few ticks only,
// as in a gas, pairs are listed by cells (neighbour_cells.h) for a while.
#include <atomic>
#include <cstring>

#include "engine/broad_phase/broad_phase.h"
#include "engine/broad_phase/neighbour_cells.h"
#include "engine/broad_phase/pair_listing.h"
#include "engine/model/selection.h"
#include "engine/narrow_phase/motion_bounds.h"
#include "engine/narrow_phase/narrow_phase.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr Real ticks_predicted = 4;          // the fat AABB includes the motion of so many ticks
constexpr Real share_of_radius = Real(0.1);  // and this margin
// More moved proxies than this share, or this number, and everything is built anew.
constexpr std::size_t moving_per_moved_proxy = 8;
constexpr std::size_t moved_proxy_count_max = 1024;
// The margin of tight AABBs, relative to the size of the body.
constexpr Real box_margin_share = Real(1) / 512;
constexpr Real ticks_of_margin = 4;  // with fewer ticks in the margin it does not pay
// A body slower than this share of its size per tick is certainly not fast (motion_bounds.h).
constexpr Real certainly_slow_share = Real(0.2);
// If more bodies than this share are unchanged, the narrow phase reuses single manifolds instead of whole blocks.
constexpr std::size_t bodies_per_unchanged = 4;

Box fat_box(const Model& model, const State& state, const PairCache& cache, std::uint32_t index) {
  const Proxy& proxy = cache.proxies[index];
  const BodyRow& body = state.bodies[proxy.body];
  const Real radius = model.shapes[proxy.shape].bounding_radius;
  const Real spin = absolute(body.angular_velocity) * radius * cache.dt;
  const Real margin =
      (share_of_radius * radius + smaller(8 * cache.gravity_displacement, 2 * share_of_radius * radius)) +
      smaller(ticks_predicted * spin, share_of_radius * radius);
  const auto predict = [&](Real speed) {
    return smaller(larger(ticks_predicted * cache.dt * speed, -2 * radius), 2 * radius);
  };
  const Vec2 predicted{predict(body.velocity.x), predict(body.velocity.y)};
  Box box = cache.boxes[index];
  box.lower = {box.lower.x - margin + smaller(predicted.x, 0), box.lower.y - margin + smaller(predicted.y, 0)};
  box.upper = {box.upper.x + margin + larger(predicted.x, 0), box.upper.y + margin + larger(predicted.y, 0)};
  return box;
}

bool is_inside(const Box& inner, const Box& outer) {
  return outer.lower.x <= inner.lower.x && outer.lower.y <= inner.lower.y && inner.upper.x <= outer.upper.x &&
         inner.upper.y <= outer.upper.y;
}

bool same_bits(const BodyRow& a, const BodyRow& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}
bool same_pose(const BodyRow& a, const BodyRow& b) {
  return std::memcmp(&a.position, &b.position, sizeof a.position) == 0 &&
         std::memcmp(&a.rotation, &b.rotation, sizeof a.rotation) == 0;
}

/// Whether the cached proxies are those of the present bodies.
bool is_valid_for_bodies(const Scratch& scratch, const State& state) {
  const PairCache& cache = scratch.caches.pairs;
  const std::size_t count = state.bodies.size();
  if (!cache.is_valid || cache.bodies.size() != count) return false;
  std::atomic<bool> same_bodies{true};
  scratch.parallel.for_chunks(count, scratch.parallel.chunk_size(count, 512), [&](const Chunk& chunk) {
    bool same = true;
    for (std::size_t row = chunk.begin; row < chunk.end; ++row)
      same &= cache.bodies[row].id == state.bodies[row].id && cache.bodies[row].source == state.bodies[row].source;
    if (!same) same_bodies.store(false, std::memory_order_relaxed);
  });
  return same_bodies.load(std::memory_order_relaxed);
}

void list_proxies(const Model& model, const State& state, PairCache& cache) {
  ++cache.body_set;
  cache.static_count = 0;
  for (const BodyRow& body : state.bodies)
    cache.static_count += model.bodies[body.source].type == BodyType::static_body ? 1 : 0;
  cache.proxies.clear();
  cache.first_proxy.clear();
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
    cache.first_proxy.push_back(static_cast<std::uint32_t>(cache.proxies.size()));
    add_proxies(model, state, row, cache.proxies);
  }
  cache.first_proxy.push_back(static_cast<std::uint32_t>(cache.proxies.size()));
  cache.boxes.resize(cache.proxies.size());
  cache.fat_boxes.assign(cache.proxies.size(), empty_box);
  cache.is_moved_proxy.assign(cache.proxies.size(), 0);
  cache.bodies = state.bodies;
  cache.boxed.resize(state.bodies.size());
  cache.is_unchanged.resize(state.bodies.size());
  cache.box_flags.assign(state.bodies.size(), 0);
}

// Bits of PairCache::box_flags.
constexpr std::uint8_t has_ccd_margin = 1;  // its proxies have a ccd_margin > 0
constexpr std::uint8_t is_swept = 2;        // (swept_displacement_of)
constexpr std::uint8_t has_margin = 4;

/// An upper bound of the speed of any point of a body, m/s.
Real speed_bound(const BodyRow& body, Real extent) {
  return (magnitude(body.velocity.x) + magnitude(body.velocity.y)) + magnitude(body.angular_velocity) * extent;
}

/// Whether the tight AABBs of a body still contain its shapes. A point moves by at most the displacement of its body
/// and the chord of its rotation.
bool is_still_valid(const BoxedBody& boxed, const BodyRow& body) {
  const Real delta_position =
      larger(magnitude(body.position.x - boxed.position.x), magnitude(body.position.y - boxed.position.y));
  const Real delta_rotation =
      magnitude(body.rotation.c - boxed.rotation.c) + magnitude(body.rotation.s - boxed.rotation.s);
  return delta_position + delta_rotation * boxed.extent < boxed.margin && speed_bound(body, boxed.extent) < boxed.speed;
}

/// The margin of the tight AABBs of a body without swept displacement, m; 0 if the body would soon leave it.
Real margin_for(const BodyModel& constants, const BodyRow& body, const MotionBounds& bounds) {
  // Less the rounding of a box.
  const Real far = larger(magnitude(body.position.x), magnitude(body.position.y)) + constants.extent;
  const Real margin = box_margin_share * constants.size - 16 * epsilon * far;
  return ticks_of_margin * bounds.dt * speed_bound(body, constants.extent) < margin ? margin : Real(0);
}

BoxedBody boxed_body(const BodyModel& constants, const BodyRow& body, const MotionBounds& bounds, Real margin) {
  const Real gravity_speed = absolute(constants.gravity_scale) * bounds.gravity * bounds.dt;
  const Real speed = bounds.has_ccd ? certainly_slow_share * constants.size / bounds.dt - gravity_speed : Real(1e30);
  return {body.position, body.rotation, constants.extent, margin, speed};
}

/// For the bodies first..end-1: makes the tight AABBs that are no longer valid, or all (then without margins). Lists
/// proxies outside of their fat AABBs from `leaving` on and returns their number.
std::size_t follow_bodies(const Model& model, const State& state, PairCache& cache, const MotionBounds& bounds,
                          bool everything, std::size_t first, std::size_t end, std::uint32_t* leaving,
                          std::atomic<bool>& any_boxed) {
  const bool speculates = model.scene.settings.auto_substeps.has_value();  // contacts depend on velocities and dt, too
  const bool is_high_churn = cache.high_churn_ticks != 0;
  const bool adds_margin = !everything && !is_high_churn && !bounds.locates_impacts && !bounds.speculates;
  const Real gravity_displacement = cache.gravity_displacement;
  // Local pointers: a store of bytes might otherwise alias the vectors.
  const BodyRow* bodies = state.bodies.data();
  const BodyModel* constants = model.bodies.data();
  const ShapeModel* shapes = model.shapes.data();
  BodyRow* bodies_before = cache.bodies.data();
  std::uint8_t* is_unchanged = cache.is_unchanged.data();
  std::uint8_t* box_flags = cache.box_flags.data();
  BoxedBody* boxed = cache.boxed.data();
  const std::uint32_t* first_proxy = cache.first_proxy.data();
  Proxy* proxies = cache.proxies.data();
  Box* boxes = cache.boxes.data();
  const Box* fat_boxes = cache.fat_boxes.data();
  std::size_t count = 0;
  bool some_boxed = false;
  for (std::size_t row = first; row < end; ++row) {
    const BodyRow& body = bodies[row];
    BodyRow& before = bodies_before[row];
    const bool has_pose = same_pose(body, before);
    const bool is_same = has_pose && same_bits(body, before);
    is_unchanged[row] = (speculates ? is_same : has_pose) ? 1 : 0;
    if (!everything && is_same) continue;
    before = body;
    if (adds_margin && (box_flags[row] & has_margin) != 0 && is_still_valid(boxed[row], body)) continue;
    const std::uint32_t proxy_end = first_proxy[row + 1];
    if (first_proxy[row] == proxy_end) continue;
    const Real swept = swept_displacement_of(bounds, constants[body.source], body);
    const Real ccd_margin = ccd_margin_of(bounds, constants[body.source], swept);
    some_boxed = true;
    const Real margin = adds_margin && !(swept > 0) ? margin_for(constants[body.source], body, bounds) : Real(0);
    if (margin > 0) boxed[row] = boxed_body(constants[body.source], body, bounds, margin);
    box_flags[row] = static_cast<std::uint8_t>((ccd_margin > 0 ? has_ccd_margin : 0) | (swept > 0 ? is_swept : 0) |
                                               (margin > 0 ? has_margin : 0));
    for (std::uint32_t i = first_proxy[row]; i < proxy_end; ++i) {
      if (proxies[i].ccd_margin != ccd_margin) proxies[i].ccd_margin = ccd_margin;  // most values are unchanged
      boxes[i] = box_around(model, body, shapes[proxies[i].shape], gravity_displacement, swept);
      if (margin > 0)
        boxes[i] = {{boxes[i].lower.x - margin, boxes[i].lower.y - margin},
                    {boxes[i].upper.x + margin, boxes[i].upper.y + margin}};
      if (!is_high_churn && !is_inside(boxes[i], fat_boxes[i])) leaving[count++] = i;
    }
  }
  if (some_boxed) any_boxed.store(true, std::memory_order_relaxed);
  return count;
}

/// Makes tight AABBs that are no longer valid, or all. Lists proxies outside of their fat AABBs. True if it made any.
bool follow(const Model& model, const State& state, Scratch& scratch, const MotionBounds& bounds, bool everything) {
  PairCache& cache = scratch.caches.pairs;
  cache.leaving.resize(cache.proxies.size());
  const std::size_t count = state.bodies.size();
  const std::size_t size = scratch.parallel.chunk_size(count, 128);
  std::atomic<bool> any_boxed{false};
  scratch.part_counts.assign(Parallel::chunk_count(count, size), 0);
  scratch.parallel.for_chunks(count, size, [&](const Chunk& chunk) {
    scratch.part_counts[chunk.index] =
        static_cast<std::uint32_t>(follow_bodies(model, state, cache, bounds, everything, chunk.begin, chunk.end,
                                                 cache.leaving.data() + cache.first_proxy[chunk.begin], any_boxed));
  });
  std::size_t unchanged_count = 0;
  for (const std::uint8_t is_unchanged : cache.is_unchanged) unchanged_count += is_unchanged;
  cache.many_are_unchanged = bodies_per_unchanged * (unchanged_count - cache.static_count) > count - cache.static_count;
  std::uint8_t box_flags = 0;
  for (const std::uint8_t of_body : cache.box_flags) box_flags |= of_body;
  cache.any_ccd_margin = (box_flags & has_ccd_margin) != 0;
  cache.any_swept = (box_flags & is_swept) != 0;
  const auto begin_of = [&](std::size_t chunk) { return std::size_t{cache.first_proxy[chunk * size]}; };
  cache.leaving.resize(put_together(cache.leaving.data(), scratch.part_counts, begin_of));
  return any_boxed.load(std::memory_order_relaxed);
}

/// Makes tight AABBs without margins, so that pairs can be counted.
void make_tight_boxes(const Model& model, const State& state, PairCache& cache, const MotionBounds& bounds) {
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
    const BodyRow& body = state.bodies[row];
    const Real swept = swept_displacement_of(bounds, model.bodies[body.source], body);
    for (std::uint32_t i = cache.first_proxy[row]; i < cache.first_proxy[row + 1]; ++i)
      cache.boxes[i] = box_around(model, body, model.shapes[cache.proxies[i].shape], cache.gravity_displacement, swept);
    cache.box_flags[row] &= static_cast<std::uint8_t>(~has_margin);
  }
}

struct NodesToList {
  std::uint32_t level;
  bool is_tight;  // tight AABBs must overlap, too
};

/// Lists the pairs of a chunk of nodes of the moving tree, all of one level. Each node is compared with itself, with
/// later nodes and with the static tree.
void list_pairs_of_nodes(const PairCache& cache, NodesToList nodes, const Chunk& chunk, PairListing& listing,
                         std::vector<Pair>& pairs) {
  const std::uint32_t level = nodes.level;
  const BoxTree& moving = cache.moving_tree;
  const BoxTree& others = cache.static_tree;
  bool goes_on = true;
  const auto add = [&](std::uint32_t a, std::uint32_t b) {
    if (!may_touch(cache.proxies[a], cache.proxies[b])) return true;
    if (nodes.is_tight && !(overlaps(cache.boxes[a], cache.boxes[b]) &&
                            are_pair(cache.proxies[a], cache.proxies[b], cache.boxes[a], cache.boxes[b])))
      return true;
    pairs.push_back(a < b ? Pair{a, b} : Pair{b, a});
    goes_on = listing.goes_on(pairs.size());
    return goes_on;
  };
  const Box* boxes = moving.boxes.data() + moving.level_start[level];
  const std::uint32_t node_count = moving.level_start[level + 1] - moving.level_start[level];
  for (auto a = static_cast<std::uint32_t>(chunk.begin); a < chunk.end && goes_on; ++a) {
    const auto add_two = [&](std::uint32_t i, std::uint32_t j) { return add(moving.proxies[i], moving.proxies[j]); };
    if (level > 0) for_each_overlap_below(moving, level, a, a, add_two);
    for (std::uint32_t b = a + 1; b < node_count && goes_on; ++b)
      if (level > 0 && overlaps(boxes[a], boxes[b])) for_each_overlap_below(moving, level, a, b, add_two);
    if (goes_on && !others.proxies.empty())
      for_each_overlap_between(moving, level, a, others, [&](std::uint32_t i, std::uint32_t j) {
        return add(moving.proxies[i], others.proxies[j]);
      });
  }
}

/// The level of a tree whose nodes are divided among chunks. It has few nodes, since each is compared with each.
std::uint32_t shared_level(const BoxTree& tree) {
  constexpr std::uint32_t node_count_max = 128;
  std::uint32_t level = 0;
  while (level < top_level(tree) && tree.level_start[level + 1] - tree.level_start[level] > node_count_max) ++level;
  return level > 0 || tree.proxies.size() < 2 ? level : level + 1;
}

/// Lists all pairs of overlapping fat AABBs, in any order. `is_tight`: only pairs whose tight AABBs overlap, too.
/// False: there are more than a tick may have, and not all are listed.
bool list_pairs(Scratch& scratch, bool is_tight) {
  const BoxTree& tree = scratch.caches.pairs.moving_tree;
  scratch.unsorted_pairs.clear();
  if (tree.proxies.empty()) return true;
  const std::size_t proxy_count = tree.proxies.size();
  const bool is_shared = scratch.parallel.chunk_size(proxy_count, 128) < proxy_count;
  const std::uint32_t level = is_shared ? shared_level(tree) : top_level(tree);
  const std::size_t node_count = tree.level_start[level + 1] - tree.level_start[level];
  return list_in_chunks(scratch, node_count, is_shared ? 1 + node_count / 32 : node_count,
                        [&](const Chunk& chunk, PairListing& listing, std::vector<Pair>& pairs) {
                          list_pairs_of_nodes(scratch.caches.pairs, {level, is_tight}, chunk, listing, pairs);
                        });
}

void build_everything(const Model& model, const State& state, Scratch& scratch, const MotionBounds& bounds) {
  PairCache& cache = scratch.caches.pairs;
  const std::size_t proxy_count = cache.proxies.size();
  scratch.parallel.for_chunks(proxy_count, scratch.parallel.chunk_size(proxy_count, 128), [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i)
      cache.fat_boxes[i] = fat_box(model, state, cache, static_cast<std::uint32_t>(i));
  });
  cache.is_moved_proxy.assign(cache.proxies.size(), 0);
  cache.moved_proxies.clear();
  for (const bool is_static : {true, false}) {
    scratch.sort_entries.clear();
    for (std::uint32_t i = 0; i < cache.proxies.size(); ++i)
      if (cache.proxies[i].is_static == is_static) scratch.sort_entries.push_back({0, i});
    build_tree(cache.fat_boxes, scratch.sort_entries, scratch.sort_buffer,
               is_static ? cache.static_tree : cache.moving_tree);
  }
  const bool all_listed = list_pairs(scratch, false);
  if (!all_listed) make_tight_boxes(model, state, cache, bounds);
  if (!all_listed && !list_pairs(scratch, true)) {
    are_too_many(scratch, scratch.pair_count_max + 1);
    return;
  }
  cache.is_valid = all_listed;
  cache.has_pairs = true;
  cache.ticks_since_build = 0;
  cache.common_side = 0;
  sort_pairs(scratch, cache.proxies.size(), cache.pairs);
}

constexpr std::uint32_t ticks_since_build_least = 6;  // ticks after a build; less did not pay
constexpr std::uint32_t high_churn_ticks = 60;        // ticks until the list is tried again
constexpr std::uint32_t ticks_per_side = 8;           // ticks with the same cell size

/// Lists the pairs of this tick only, and caches none. False: cells do not suit the scene.
bool list_present_pairs(const Model& model, const State& state, Scratch& scratch, const MotionBounds& bounds) {
  PairCache& cache = scratch.caches.pairs;
  cache.has_pairs = false;
  const bool has_side = cache.common_side > 0 && cache.high_churn_ticks % ticks_per_side != 0;
  count_use(scratch.caches.report, CacheKind::cell_side, has_side);
  if (!has_side) cache.common_side = 0;
  CellListing listing = list_by_cells(scratch, cache.proxies, cache.boxes, cache.common_side);
  if (listing == CellListing::unsuited && has_side) {
    cache.common_side = 0;
    listing = list_by_cells(scratch, cache.proxies, cache.boxes, cache.common_side);
  }
  if (listing == CellListing::too_many) {
    make_tight_boxes(model, state, cache, bounds);
    listing = list_by_cells(scratch, cache.proxies, cache.boxes, cache.common_side);
  }
  if (listing == CellListing::unsuited) return false;
  if (listing == CellListing::too_many)
    are_too_many(scratch, scratch.pair_count_max + 1);
  else
    sort_present_pairs(scratch, cache.proxies.size());
  return true;
}

constexpr std::uint8_t moved_proxies_now = 2;

/// Adds the pairs of a shape with a new fat AABB. Of two such shapes, the one with the smaller index finds the pair.
void find_pairs_of(Scratch& scratch, std::uint32_t index) {
  PairCache& cache = scratch.caches.pairs;
  const Box box = cache.fat_boxes[index];
  const auto add = [&](std::uint32_t other) {
    if (may_touch(cache.proxies[index], cache.proxies[other]))
      scratch.unsorted_pairs.push_back(index < other ? Pair{index, other} : Pair{other, index});
    return true;
  };
  for_each_overlap_of(cache.static_tree, box, [&](std::uint32_t leaf) { return add(cache.static_tree.proxies[leaf]); });
  for_each_overlap_of(cache.moving_tree, box, [&](std::uint32_t leaf) {
    const std::uint32_t other = cache.moving_tree.proxies[leaf];
    return cache.is_moved_proxy[other] != 0 || add(other);
  });
  for (const std::uint32_t other : cache.moved_proxies)
    if ((cache.is_moved_proxy[other] != moved_proxies_now || index < other) && other != index &&
        overlaps(box, cache.fat_boxes[other]))
      add(other);
}

/// Replaces the pairs of proxies that have left their fat AABBs. False: there are too many pairs of fat AABBs, and
/// everything is built anew.
bool follow_moved_proxies(const Model& model, const State& state, Scratch& scratch) {
  PairCache& cache = scratch.caches.pairs;
  for (const std::uint32_t index : cache.leaving) {
    cache.fat_boxes[index] = fat_box(model, state, cache, index);
    if (cache.is_moved_proxy[index] == 0) cache.moved_proxies.push_back(index);
    cache.is_moved_proxy[index] = moved_proxies_now;
  }
  scratch.unsorted_pairs.clear();
  for (const std::uint32_t index : cache.leaving) {
    find_pairs_of(scratch, index);
    if (scratch.unsorted_pairs.size() > scratch.pair_count_max) return false;
  }
  const std::vector<Pair>& added = scratch.pair_rows;
  sort_pairs(scratch, cache.proxies.size(), scratch.pair_rows);
  cache.merged.clear();
  std::size_t next = 0;
  const auto comes_before = [](Pair a, Pair b) {
    return a.first < b.first || (a.first == b.first && a.second < b.second);
  };
  for (const Pair& pair : cache.pairs) {
    if (cache.is_moved_proxy[pair.first] == moved_proxies_now || cache.is_moved_proxy[pair.second] == moved_proxies_now)
      continue;
    while (next < added.size() && comes_before(added[next], pair)) cache.merged.push_back(added[next++]);
    cache.merged.push_back(pair);
  }
  while (next < added.size()) cache.merged.push_back(added[next++]);
  cache.pairs.swap(cache.merged);
  for (const std::uint32_t index : cache.leaving) cache.is_moved_proxy[index] = 1;
  return cache.pairs.size() <= scratch.pair_count_max;
}

/// Copies the pairs whose tight AABBs overlap and returns their number. Requires: no proxy has a CCD margin. Without
/// branches, since the outcome is hard to predict.
std::size_t copy_overlapping(const PairCache& cache, std::size_t begin, std::size_t end, Pair* out) {
  std::size_t count = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const Pair pair = cache.pairs[i];
    const Box& a = cache.boxes[pair.first];
    const Box& b = cache.boxes[pair.second];
    out[count] = pair;
    count += static_cast<std::size_t>((a.lower.x <= b.upper.x) & (b.lower.x <= a.upper.x) & (a.lower.y <= b.upper.y) &
                                      (b.lower.y <= a.upper.y));
  }
  return count;
}

/// Copies the pairs of this tick and returns their number.
std::size_t copy_present(const PairCache& cache, std::size_t begin, std::size_t end, Pair* out) {
  if (!cache.any_ccd_margin) return copy_overlapping(cache, begin, end, out);
  std::size_t count = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const Pair pair = cache.pairs[i];
    const Box& a = cache.boxes[pair.first];
    const Box& b = cache.boxes[pair.second];
    if (overlaps(a, b) && are_pair(cache.proxies[pair.first], cache.proxies[pair.second], a, b)) out[count++] = pair;
  }
  return count;
}

/// The pairs of this tick.
void select_present_pairs(Scratch& scratch) {
  PairCache& cache = scratch.caches.pairs;
  cache.present.resize(cache.pairs.size());
  cache.present.resize(select_in_chunks(
      scratch, cache.pairs.size(), 512, cache.present.data(),
      [&](std::size_t begin, std::size_t end, Pair* out) { return copy_present(cache, begin, end, out); }));
}

}  // namespace

void aabb_tree(const Model& model, State& state, Scratch& scratch, Real dt) {
  PairCache& cache = scratch.caches.pairs;
  const Real gravity_displacement = gravity_displacement_of_tick(model, state);
  const MotionBounds bounds = motion_bounds_of_tick(model, state, dt);
  const bool was_valid = is_valid_for_bodies(scratch, state);
  if (!was_valid) list_proxies(model, state, cache);
  const bool boxes_valid = was_valid && cache.dt == dt && cache.gravity_displacement == gravity_displacement &&
                           cache.farthest == bounds.farthest;
  const bool speculates = model.scene.settings.auto_substeps.has_value();
  if (!was_valid || cache.gravity_displacement != gravity_displacement || (speculates && cache.dt != dt))
    scratch.caches.has_contact_pairs = false;
  cache.dt = dt;
  cache.gravity_displacement = gravity_displacement;
  cache.farthest = bounds.farthest;
  cache.is_valid = true;
  const bool made_boxes = follow(model, state, scratch, bounds, !boxes_valid);
  const bool all_valid = !made_boxes && cache.has_present;
  CacheReport& report = scratch.caches.report;
  count_uses(report, CacheKind::boxes, {boxes_valid ? 1u : 0u, made_boxes ? 1u : 0u});
  cache.has_present = cache.present_unchanged = false;
  scratch.proxies = cache.proxies;
  const std::size_t moved_proxy_count = cache.moved_proxies.size() + cache.leaving.size();
  const bool are_many = moved_proxy_count > moved_proxy_count_max ||
                        moved_proxy_count * moving_per_moved_proxy > cache.moving_tree.proxies.size();
  bool builds = !was_valid || are_many || !cache.has_pairs;
  if (model.is_composed && was_valid && are_many && cache.has_pairs &&
      cache.ticks_since_build < ticks_since_build_least)
    cache.high_churn_ticks = high_churn_ticks;
  ++cache.ticks_since_build;
  if (cache.high_churn_ticks > 0) {
    --cache.high_churn_ticks;
    if (list_present_pairs(model, state, scratch, bounds)) return;
    cache.high_churn_ticks = 0;
    builds = true;
  }
  cache.present_unchanged = all_valid && !builds;
  count_use(report, CacheKind::pair_list, !builds);
  count_use(report, CacheKind::present_pairs, cache.present_unchanged);
  if (builds || (!cache.leaving.empty() && !follow_moved_proxies(model, state, scratch)))
    build_everything(model, state, scratch, bounds);
  if (scratch.has_too_many_pairs) return;
  if (!cache.present_unchanged) select_present_pairs(scratch);
  cache.has_present = true;
  scratch.pairs = cache.present;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
