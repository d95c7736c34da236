// Boxes, a tree over them and the pairs that overlap, kept from tick to tick.
// SPDX-License-Identifier: MIT
// Source: Verlet, "Computer Experiments on Classical Fluids I", 1967 (lists of pairs that may come near, with a margin,
// until something has moved as far).
//
// Each shape gets a box that is larger than it needs. While all shapes stay inside, the list of overlapping large boxes
// holds every pair that may touch. A shape that leaves gets a new large box and its pairs are found anew; it is then a
// stray, whose box in the tree no longer counts. When there are many strays, everything is built anew. What is handed
// on are those pairs of the list whose present boxes overlap: those of any other algorithm, and a few more, since boxes
// of what has moved have a little room (`box_room_share`), with which they hold for some ticks of a slow body. Where
// more large boxes overlap than a tick may have pairs, only the pairs of present boxes are listed, and nothing is kept.
// Where what was built held for a few ticks only, such as in a gas, pairs are listed by cells (neighbour_cells.h) for a
// while.
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

constexpr Real ticks_ahead = 4;              // a large box has room for so many ticks at the present velocity
constexpr Real share_of_radius = Real(0.1);  // and for so much besides.
// More strays than this share, or this number, and everything is built anew.
constexpr std::size_t moving_per_moved_proxy = 8;
constexpr std::size_t moved_proxy_count_max = 1024;
// A body's boxes have room for so much of its size.
constexpr Real box_room_share = Real(1) / 512;
constexpr Real ticks_of_room = 4;  // at the present velocity; for less it is not worth it
// What is slower than this share of its size a tick is certainly not fast (motion_bounds.h).
constexpr Real certainly_slow_share = Real(0.2);
// Where more bodies than this share are still, their contacts are looked for.
constexpr std::size_t bodies_per_unchanged = 4;

Box large_box(const Model& model, const State& state, const PairCache& kept, std::uint32_t index) {
  const Proxy& proxy = kept.proxies[index];
  const BodyRow& body = state.bodies[proxy.body];
  const Real radius = model.shapes[proxy.shape].bounding_radius;
  const Real spin = absolute(body.angular_velocity) * radius * kept.dt;
  const Real room = (share_of_radius * radius + smaller(8 * kept.fall, 2 * share_of_radius * radius)) +
                    smaller(ticks_ahead * spin, share_of_radius * radius);
  const auto ahead = [&](Real speed) {
    return smaller(larger(ticks_ahead * kept.dt * speed, -2 * radius), 2 * radius);
  };
  const Vec2 way{ahead(body.velocity.x), ahead(body.velocity.y)};
  Box box = kept.boxes[index];
  box.lower = {box.lower.x - room + smaller(way.x, 0), box.lower.y - room + smaller(way.y, 0)};
  box.upper = {box.upper.x + room + larger(way.x, 0), box.upper.y + room + larger(way.y, 0)};
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

/// Whether the proxies are those of the present bodies.
bool fits(const Scratch& scratch, const State& state) {
  const PairCache& kept = scratch.caches.pairs;
  const std::size_t count = state.bodies.size();
  if (!kept.is_valid || kept.bodies.size() != count) return false;
  std::atomic<bool> fits{true};
  scratch.parallel.for_chunks(count, scratch.parallel.chunk_size(count, 512), [&](const Chunk& chunk) {
    bool same = true;
    for (std::size_t row = chunk.begin; row < chunk.end; ++row)
      same &= kept.bodies[row].id == state.bodies[row].id && kept.bodies[row].source == state.bodies[row].source;
    if (!same) fits.store(false, std::memory_order_relaxed);
  });
  return fits.load(std::memory_order_relaxed);
}

void list_proxies(const Model& model, const State& state, PairCache& kept) {
  ++kept.body_set;
  kept.static_count = 0;
  for (const BodyRow& body : state.bodies)
    kept.static_count += model.bodies[body.source].type == BodyType::static_body ? 1 : 0;
  kept.proxies.clear();
  kept.first_proxy.clear();
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
    kept.first_proxy.push_back(static_cast<std::uint32_t>(kept.proxies.size()));
    add_proxies(model, state, row, kept.proxies);
  }
  kept.first_proxy.push_back(static_cast<std::uint32_t>(kept.proxies.size()));
  kept.boxes.resize(kept.proxies.size());
  kept.large_boxes.assign(kept.proxies.size(), empty_box);
  kept.is_moved_proxy.assign(kept.proxies.size(), 0);
  kept.bodies = state.bodies;
  kept.boxed.resize(state.bodies.size());
  kept.is_unchanged.resize(state.bodies.size());
  kept.looks.assign(state.bodies.size(), 0);
}

// Bits of KeptPairs::looks.
constexpr std::uint8_t looks_ahead = 1;  // its proxies have an `ahead` > 0
constexpr std::uint8_t has_way = 2;      // (swept_displacement_of)
constexpr std::uint8_t has_room = 4;

/// No point of a body is faster, m/s.
Real speed_bound(const BodyRow& body, Real reach) {
  return (magnitude(body.velocity.x) + magnitude(body.velocity.y)) + magnitude(body.angular_velocity) * reach;
}

/// Whether the boxes of a body hold its shapes still. A point moves by no more than its body and the chord of its turn.
bool hold(const BoxedBody& boxed, const BodyRow& body) {
  const Real moved =
      larger(magnitude(body.position.x - boxed.position.x), magnitude(body.position.y - boxed.position.y));
  const Real turned = magnitude(body.rotation.c - boxed.rotation.c) + magnitude(body.rotation.s - boxed.rotation.s);
  return moved + turned * boxed.reach < boxed.room && speed_bound(body, boxed.reach) < boxed.speed;
}

/// The room of the boxes of a body that has no way, m; 0 for one that would soon have left it.
Real room_for(const BodyModel& constants, const BodyRow& body, const MotionBounds& reach) {
  // Less what rounding may make of a box.
  const Real far = larger(magnitude(body.position.x), magnitude(body.position.y)) + constants.reach;
  const Real room = box_room_share * constants.size - 16 * epsilon * far;
  return ticks_of_room * reach.dt * speed_bound(body, constants.reach) < room ? room : Real(0);
}

BoxedBody boxed_body(const BodyModel& constants, const BodyRow& body, const MotionBounds& reach, Real room) {
  const Real fall = absolute(constants.gravity_scale) * reach.gravity * reach.dt;
  const Real speed = reach.guards ? certainly_slow_share * constants.size / reach.dt - fall : Real(1e30);
  return {body.position, body.rotation, constants.reach, room, speed};
}

/// For the bodies first..end-1: boxes of what has left their room, or of everything, then without room. Lists what has
/// left its large box from `leaving` on; returns how many.
std::size_t follow_bodies(const Model& model, const State& state, PairCache& kept, const MotionBounds& reach,
                          bool everything, std::size_t first, std::size_t end, std::uint32_t* leaving,
                          std::atomic<bool>& any_boxed) {
  const bool speculates =
      model.scene.settings.auto_substeps.has_value();  // contacts follow from velocities and dt, too
  const bool is_high_churn = kept.high_churn_ticks != 0;
  const bool gives_room = !everything && !is_high_churn && !reach.locates && !reach.speculates;
  const Real fall = kept.fall;
  // By pointers of its own: what is written as bytes might otherwise change those of the vectors.
  const BodyRow* bodies = state.bodies.data();
  const BodyModel* constants = model.bodies.data();
  const ShapeModel* shapes = model.shapes.data();
  BodyRow* bodies_before = kept.bodies.data();
  std::uint8_t* is_unchanged = kept.is_unchanged.data();
  std::uint8_t* looks = kept.looks.data();
  BoxedBody* boxed = kept.boxed.data();
  const std::uint32_t* first_proxy = kept.first_proxy.data();
  Proxy* proxies = kept.proxies.data();
  Box* boxes = kept.boxes.data();
  const Box* large_boxes = kept.large_boxes.data();
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
    if (gives_room && (looks[row] & has_room) != 0 && hold(boxed[row], body)) continue;
    const std::uint32_t proxy_end = first_proxy[row + 1];
    if (first_proxy[row] == proxy_end) continue;
    const Real way = swept_displacement_of(reach, constants[body.source], body);
    const Real ahead = ahead_of(reach, constants[body.source], way);
    some_boxed = true;
    const Real room = gives_room && !(way > 0) ? room_for(constants[body.source], body, reach) : Real(0);
    if (room > 0) boxed[row] = boxed_body(constants[body.source], body, reach, room);
    looks[row] =
        static_cast<std::uint8_t>((ahead > 0 ? looks_ahead : 0) | (way > 0 ? has_way : 0) | (room > 0 ? has_room : 0));
    for (std::uint32_t i = first_proxy[row]; i < proxy_end; ++i) {
      if (proxies[i].ahead != ahead) proxies[i].ahead = ahead;  // most lines stay as they are
      boxes[i] = box_around(model, body, shapes[proxies[i].shape], fall, way);
      if (room > 0)
        boxes[i] = {{boxes[i].lower.x - room, boxes[i].lower.y - room},
                    {boxes[i].upper.x + room, boxes[i].upper.y + room}};
      if (!is_high_churn && !is_inside(boxes[i], large_boxes[i])) leaving[count++] = i;
    }
  }
  if (some_boxed) any_boxed.store(true, std::memory_order_relaxed);
  return count;
}

/// Boxes of what has left their room, or of everything; lists what has left its large box. True if there are any.
bool follow(const Model& model, const State& state, Scratch& scratch, const MotionBounds& reach, bool everything) {
  PairCache& kept = scratch.caches.pairs;
  kept.leaving.resize(kept.proxies.size());
  const std::size_t count = state.bodies.size();
  const std::size_t size = scratch.parallel.chunk_size(count, 128);
  std::atomic<bool> any_boxed{false};
  scratch.part_counts.assign(Parallel::chunk_count(count, size), 0);
  scratch.parallel.for_chunks(count, size, [&](const Chunk& chunk) {
    scratch.part_counts[chunk.index] =
        static_cast<std::uint32_t>(follow_bodies(model, state, kept, reach, everything, chunk.begin, chunk.end,
                                                 kept.leaving.data() + kept.first_proxy[chunk.begin], any_boxed));
  });
  std::size_t unchanged_count = 0;
  for (const std::uint8_t is_unchanged : kept.is_unchanged) unchanged_count += is_unchanged;
  kept.many_are_unchanged = bodies_per_unchanged * (unchanged_count - kept.static_count) > count - kept.static_count;
  std::uint8_t looks = 0;
  for (const std::uint8_t of_body : kept.looks) looks |= of_body;
  kept.any_looks_ahead = (looks & looks_ahead) != 0;
  kept.any_swept = (looks & has_way) != 0;
  const auto begin_of = [&](std::size_t chunk) { return std::size_t{kept.first_proxy[chunk * size]}; };
  kept.leaving.resize(put_together(kept.leaving.data(), scratch.part_counts, begin_of));
  return any_boxed.load(std::memory_order_relaxed);
}

/// Boxes without room, to be counted.
void box_exactly(const Model& model, const State& state, PairCache& kept, const MotionBounds& reach) {
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
    const BodyRow& body = state.bodies[row];
    const Real way = swept_displacement_of(reach, model.bodies[body.source], body);
    for (std::uint32_t i = kept.first_proxy[row]; i < kept.first_proxy[row + 1]; ++i)
      kept.boxes[i] = box_around(model, body, model.shapes[kept.proxies[i].shape], kept.fall, way);
    kept.looks[row] &= static_cast<std::uint8_t>(~has_room);
  }
}

struct NodesToList {
  std::uint32_t level;
  bool is_tight;  // present boxes must overlap, too
};

/// Lists the pairs of a chunk of the nodes of a level of the moving tree: each with itself, with those after it, and
/// with what is static.
void list_pairs_of_nodes(const PairCache& kept, NodesToList nodes, const Chunk& chunk, PairListing& listing,
                         std::vector<Pair>& pairs) {
  const std::uint32_t level = nodes.level;
  const BoxTree& moving = kept.moving_tree;
  const BoxTree& others = kept.static_tree;
  bool goes_on = true;
  const auto add = [&](std::uint32_t a, std::uint32_t b) {
    if (!may_touch(kept.proxies[a], kept.proxies[b])) return true;
    if (nodes.is_tight && !(overlaps(kept.boxes[a], kept.boxes[b]) &&
                            are_pair(kept.proxies[a], kept.proxies[b], kept.boxes[a], kept.boxes[b])))
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

/// The level of a tree whose nodes are shared out: of at most so many nodes, since each is compared with each.
std::uint32_t shared_level(const BoxTree& tree) {
  constexpr std::uint32_t node_count_max = 128;
  std::uint32_t level = 0;
  while (level < top_level(tree) && tree.level_start[level + 1] - tree.level_start[level] > node_count_max) ++level;
  return level > 0 || tree.proxies.size() < 2 ? level : level + 1;
}

/// All pairs of large boxes that overlap, in any order; `is_tight`: of these, those whose present boxes do. False:
/// there are more of them than a tick may have, and not all are listed.
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

void build_everything(const Model& model, const State& state, Scratch& scratch, const MotionBounds& reach) {
  PairCache& kept = scratch.caches.pairs;
  const std::size_t proxy_count = kept.proxies.size();
  scratch.parallel.for_chunks(proxy_count, scratch.parallel.chunk_size(proxy_count, 128), [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i)
      kept.large_boxes[i] = large_box(model, state, kept, static_cast<std::uint32_t>(i));
  });
  kept.is_moved_proxy.assign(kept.proxies.size(), 0);
  kept.moved_proxies.clear();
  for (const bool is_static : {true, false}) {
    scratch.sort_entries.clear();
    for (std::uint32_t i = 0; i < kept.proxies.size(); ++i)
      if (kept.proxies[i].is_static == is_static) scratch.sort_entries.push_back({0, i});
    build_tree(kept.large_boxes, scratch.sort_entries, scratch.sort_buffer,
               is_static ? kept.static_tree : kept.moving_tree);
  }
  const bool fits = list_pairs(scratch, false);
  if (!fits) box_exactly(model, state, kept, reach);
  if (!fits && !list_pairs(scratch, true)) {
    are_too_many(scratch, scratch.pair_count_max + 1);
    return;
  }
  kept.is_valid = fits;
  kept.has_pairs = true;
  kept.ticks_held = 0;
  kept.common_side = 0;
  sort_pairs(scratch, kept.proxies.size(), kept.pairs);
}

constexpr std::uint32_t ticks_held_least = 6;   // after the one in which all was built; less was not worth it
constexpr std::uint32_t high_churn_ticks = 60;  // until it is tried again
constexpr std::uint32_t ticks_per_side = 8;     // for which cells are of one size

/// Lists the pairs of this tick by themselves, and keeps none. False: the scene is not for it.
bool list_present_pairs(const Model& model, const State& state, Scratch& scratch, const MotionBounds& reach) {
  PairCache& kept = scratch.caches.pairs;
  kept.has_pairs = false;
  const bool has_side = kept.common_side > 0 && kept.high_churn_ticks % ticks_per_side != 0;
  count_use(scratch.caches.report, CacheKind::cell_side, has_side);
  if (!has_side) kept.common_side = 0;
  CellListing listing = list_by_cells(scratch, kept.proxies, kept.boxes, kept.common_side);
  if (listing == CellListing::unsuited && has_side) {
    kept.common_side = 0;
    listing = list_by_cells(scratch, kept.proxies, kept.boxes, kept.common_side);
  }
  if (listing == CellListing::too_many) {
    box_exactly(model, state, kept, reach);
    listing = list_by_cells(scratch, kept.proxies, kept.boxes, kept.common_side);
  }
  if (listing == CellListing::unsuited) return false;
  if (listing == CellListing::too_many)
    are_too_many(scratch, scratch.pair_count_max + 1);
  else
    sort_present_pairs(scratch, kept.proxies.size());
  return true;
}

constexpr std::uint8_t moved_proxies_now = 2;

/// Adds the pairs of a shape that has a new large box. Of two such shapes the one with the smaller index finds both.
void find_pairs_of(Scratch& scratch, std::uint32_t index) {
  PairCache& kept = scratch.caches.pairs;
  const Box box = kept.large_boxes[index];
  const auto add = [&](std::uint32_t other) {
    if (may_touch(kept.proxies[index], kept.proxies[other]))
      scratch.unsorted_pairs.push_back(index < other ? Pair{index, other} : Pair{other, index});
    return true;
  };
  for_each_overlap_of(kept.static_tree, box, [&](std::uint32_t leaf) { return add(kept.static_tree.proxies[leaf]); });
  for_each_overlap_of(kept.moving_tree, box, [&](std::uint32_t leaf) {
    const std::uint32_t other = kept.moving_tree.proxies[leaf];
    return kept.is_moved_proxy[other] != 0 || add(other);
  });
  for (const std::uint32_t other : kept.moved_proxies)
    if ((kept.is_moved_proxy[other] != moved_proxies_now || index < other) && other != index &&
        overlaps(box, kept.large_boxes[other]))
      add(other);
}

/// Puts the pairs of what has left its large box in the place of those it had. False: large boxes have too many pairs,
/// and all is to be built anew.
bool follow_moved_proxies(const Model& model, const State& state, Scratch& scratch) {
  PairCache& kept = scratch.caches.pairs;
  for (const std::uint32_t index : kept.leaving) {
    kept.large_boxes[index] = large_box(model, state, kept, index);
    if (kept.is_moved_proxy[index] == 0) kept.moved_proxies.push_back(index);
    kept.is_moved_proxy[index] = moved_proxies_now;
  }
  scratch.unsorted_pairs.clear();
  for (const std::uint32_t index : kept.leaving) {
    find_pairs_of(scratch, index);
    if (scratch.unsorted_pairs.size() > scratch.pair_count_max) return false;
  }
  const std::vector<Pair>& added = scratch.pair_rows;
  sort_pairs(scratch, kept.proxies.size(), scratch.pair_rows);
  kept.merged.clear();
  std::size_t next = 0;
  const auto comes_before = [](Pair a, Pair b) {
    return a.first < b.first || (a.first == b.first && a.second < b.second);
  };
  for (const Pair& pair : kept.pairs) {
    if (kept.is_moved_proxy[pair.first] == moved_proxies_now || kept.is_moved_proxy[pair.second] == moved_proxies_now)
      continue;
    while (next < added.size() && comes_before(added[next], pair)) kept.merged.push_back(added[next++]);
    kept.merged.push_back(pair);
  }
  while (next < added.size()) kept.merged.push_back(added[next++]);
  kept.pairs.swap(kept.merged);
  for (const std::uint32_t index : kept.leaving) kept.is_moved_proxy[index] = 1;
  return kept.pairs.size() <= scratch.pair_count_max;
}

/// Copies those of the pairs whose present boxes overlap, as long as no shape looks ahead; returns how many. Without
/// branches: which do is anybody's guess.
std::size_t copy_overlapping(const PairCache& kept, std::size_t begin, std::size_t end, Pair* out) {
  std::size_t count = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const Pair pair = kept.pairs[i];
    const Box& a = kept.boxes[pair.first];
    const Box& b = kept.boxes[pair.second];
    out[count] = pair;
    count += static_cast<std::size_t>((a.lower.x <= b.upper.x) & (b.lower.x <= a.upper.x) & (a.lower.y <= b.upper.y) &
                                      (b.lower.y <= a.upper.y));
  }
  return count;
}

/// Copies the pairs of this tick; returns how many.
std::size_t copy_present(const PairCache& kept, std::size_t begin, std::size_t end, Pair* out) {
  if (!kept.any_looks_ahead) return copy_overlapping(kept, begin, end, out);
  std::size_t count = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const Pair pair = kept.pairs[i];
    const Box& a = kept.boxes[pair.first];
    const Box& b = kept.boxes[pair.second];
    if (overlaps(a, b) && are_pair(kept.proxies[pair.first], kept.proxies[pair.second], a, b)) out[count++] = pair;
  }
  return count;
}

/// The pairs of this tick.
void keep_overlapping(Scratch& scratch) {
  PairCache& kept = scratch.caches.pairs;
  kept.present.resize(kept.pairs.size());
  kept.present.resize(select_in_chunks(
      scratch, kept.pairs.size(), 512, kept.present.data(),
      [&](std::size_t begin, std::size_t end, Pair* out) { return copy_present(kept, begin, end, out); }));
}

}  // namespace

void aabb_tree(const Model& model, State& state, Scratch& scratch, Real dt) {
  PairCache& kept = scratch.caches.pairs;
  const Real fall = gravity_displacement_of_tick(model, state);
  const MotionBounds reach = motion_bounds_of_tick(model, state, dt);
  const bool fitted = fits(scratch, state);
  if (!fitted) list_proxies(model, state, kept);
  const bool boxes_hold = fitted && kept.dt == dt && kept.fall == fall && kept.farthest == reach.farthest;
  const bool speculates = model.scene.settings.auto_substeps.has_value();
  if (!fitted || kept.fall != fall || (speculates && kept.dt != dt)) scratch.caches.has_touching = false;
  kept.dt = dt;
  kept.fall = fall;
  kept.farthest = reach.farthest;
  kept.is_valid = true;
  const bool made_boxes = follow(model, state, scratch, reach, !boxes_hold);
  const bool all_hold = !made_boxes && kept.has_present;
  CacheReport& report = scratch.caches.report;
  count_uses(report, CacheKind::boxes, {boxes_hold ? 1u : 0u, made_boxes ? 1u : 0u});
  kept.has_present = kept.stay = false;
  scratch.proxies = kept.proxies;
  const std::size_t moved_proxy_count = kept.moved_proxies.size() + kept.leaving.size();
  const bool are_many = moved_proxy_count > moved_proxy_count_max ||
                        moved_proxy_count * moving_per_moved_proxy > kept.moving_tree.proxies.size();
  bool builds = !fitted || are_many || !kept.has_pairs;
  if (model.is_composed && fitted && are_many && kept.has_pairs && kept.ticks_held < ticks_held_least)
    kept.high_churn_ticks = high_churn_ticks;
  ++kept.ticks_held;
  if (kept.high_churn_ticks > 0) {
    --kept.high_churn_ticks;
    if (list_present_pairs(model, state, scratch, reach)) return;
    kept.high_churn_ticks = 0;
    builds = true;
  }
  kept.stay = all_hold && !builds;
  count_use(report, CacheKind::pair_list, !builds);
  count_use(report, CacheKind::present_pairs, kept.stay);
  if (builds || (!kept.leaving.empty() && !follow_moved_proxies(model, state, scratch)))
    build_everything(model, state, scratch, reach);
  if (scratch.has_too_many_pairs) return;
  if (!kept.stay) keep_overlapping(scratch);
  kept.has_present = true;
  scratch.pairs = kept.present;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
