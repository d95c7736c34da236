// Dispatch over shape families, and the stage that finds the contacts of pairs.
// SPDX-License-Identifier: MIT
#include "engine/narrow_phase/narrow_phase.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <new>

#include "engine/model/enclosures.h"
#include "engine/narrow_phase/box_pairs.h"
#include "engine/narrow_phase/convex_hulls.h"
#include "engine/narrow_phase/speculative.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// Lines have no contact with lines.
Manifold no_contact(const Model&, const ShapeModel&, const ShapeModel&, const Placement&, Real) {
  return {};
}

/// [family of A][family of B], in the order of ShapeFamily.
constexpr CollideFunction collide_functions[shape_family_count][shape_family_count] = {
    {collide_circles, collide_circle_polygon, swapped<collide_round_circle>, swapped<collide_chain_circle>},
    {collide_polygon_circle, collide_polygons, collide_rounds, swapped<collide_chain_hull>},
    {collide_round_circle, collide_rounds, collide_rounds, swapped<collide_chain_hull>},
    {collide_chain_circle, collide_chain_hull, collide_chain_hull, no_contact},
};

std::size_t row_of(ShapeFamily family) {
  return static_cast<std::size_t>(family);
}

/// The order of contacts.
struct ContactKey {
  std::uint64_t a;  // body, child
  std::uint64_t b;

  bool operator==(const ContactKey&) const = default;
  bool operator<(const ContactKey& other) const { return a != other.a ? a < other.a : b < other.b; }
};

std::uint64_t key_of(std::uint32_t body, std::uint32_t child) {
  return std::uint64_t{body} << 32 | child;
}
ContactKey key_of(const ContactRow& row) {
  return {key_of(row.body_a, row.child_a), key_of(row.body_b, row.child_b)};
}

CollideFunction function_of(const Model& model, const ShapeModel& a, const ShapeModel& b, const BodyRow& body_a,
                            const BodyRow& body_b) {
  const auto moves = [&](const BodyRow& row) { return model.bodies[row.source].type == BodyType::dynamic_body; };
  const CollideFunction function = collide_functions[row_of(a.family)][row_of(b.family)];
  if (function == collide_polygon_circle && moves(body_a)) return collide_polygon_on_circle;
  if (function == collide_circle_polygon && moves(body_b)) return collide_circle_under_polygon;
  return function;
}

/// Writes the row of a contact. Points keep the forces of the last tick for the same features. Fields are written one
/// by one, since copying a struct waits until all of it is written.
void write_row(const BodyRow& a, std::uint32_t child_a, const BodyRow& b, std::uint32_t child_b,
               const Manifold& manifold, const ContactRow* old_row, ContactRow& out) {
  out.body_a = a.id;
  out.child_a = child_a;
  out.body_b = b.id;
  out.child_b = child_b;
  for (int p = 0; p < 2; ++p) {
    const std::uint32_t feature = p < manifold.point_count ? manifold.points[p].feature : no_feature;
    Real normal_force = 0;
    Real tangent_force = 0;
    if (old_row != nullptr && feature != no_feature)
      for (int old = 0; old < 2; ++old)
        if (old_row->feature[old] == feature) {
          normal_force = old_row->normal_force[old];
          tangent_force = old_row->tangent_force[old];
        }
    out.feature[p] = feature;
    out.normal_force[p] = normal_force;
    out.tangent_force[p] = tangent_force;
  }
}

/// Whether a manifold is that of two circles whose centres are the same, up to rounding.
bool is_in_one_point(const Manifold& manifold, const ShapeModel& a, const ShapeModel& b) {
  return manifold.point_count == 1 && manifold.points[0].separation == -a.radius - b.radius &&
         a.family == ShapeFamily::circle && b.family == ShapeFamily::circle;
}

}  // namespace

Manifold collide(const Model& model, const ShapeModel& a, const ShapeModel& b, const BodyRow& body_a,
                 const BodyRow& body_b, Real gravity_displacement, Real reach) {
  const Placement b_in_a{rotate_back(body_a.rotation, body_b.position - body_a.position),
                         between(body_a.rotation, body_b.rotation)};
  const Real margin = speculative_margin(pair_size(a, b), gravity_displacement) + reach;
  Manifold manifold = function_of(model, a, b, body_a, body_b)(model, a, b, b_in_a, margin);
  manifold.normal = rotate(body_a.rotation, manifold.normal);
  const Vec2 a_from_b = body_a.position - body_b.position;
  for (int i = 0; i < manifold.point_count; ++i) {
    ManifoldPoint& point = manifold.points[i];
    point.anchor_a = rotate(body_a.rotation, point.anchor_a);
    point.anchor_b = point.anchor_a + a_from_b;
  }
  if (is_in_one_point(manifold, a, b)) {
    const Vec2 normal = parting_direction(body_a.id, body_b.id);
    const Vec2 shift = Real(0.5) * (a.radius - b.radius) * (normal - manifold.normal);
    manifold.normal = normal;
    manifold.points[0].anchor_a = manifold.points[0].anchor_a + shift;
    manifold.points[0].anchor_b = manifold.points[0].anchor_b + shift;
  }
  return manifold;
}

namespace {

/// Fills the fields of a contact that do not depend on poses.
void fill_constants(const Model& model, std::span<const Proxy> proxies, const Pair& of, ContactPair& pair) {
  const ShapeModel& a = model.shapes[proxies[of.first].shape];
  const ShapeModel& b = model.shapes[proxies[of.second].shape];
  const MixedMaterial mixed = mixed_material(model, a, b);
  pair.body_a = proxies[of.first].body;
  pair.body_b = proxies[of.second].body;
  pair.proxy_a = of.first;
  pair.proxy_b = of.second;
  pair.friction = mixed.friction;
  pair.radius_a = a.radius;
  pair.radius_b = b.radius;
  pair.size = pair_size(a, b);
  pair.restitution = mixed.restitution;
}

/// The parameters of the search for contacts in a tick.
struct PairSearch {
  const Model& model;
  const State& state;
  const TickLists& tick;
  Real gravity_displacement;
  Real dt;
  bool speculates;
  bool is_sparse;                // most pairs are far apart, so that a test of circles pays
  bool may_reuse;                // contacts of bodies with the same bits as in the tick before are the same
  bool is_in_place;              // contacts are written to the places of the tick before
  const ContactRow* old_rows;    // of the tick before, ascending
  const ContactPair* old_pairs;  // of the tick before, if may_reuse
  std::size_t old_count;
  std::uint32_t generation;
  bool may_skip;         // blocks with the same pairs as in the tick before are valid
  bool pairs_unchanged;  // all pairs are those of the tick before

  ContactKey key(const Pair& pair) const {
    const Proxy& a = tick.proxies[pair.first];
    const Proxy& b = tick.proxies[pair.second];
    return {key_of(state.bodies[a.body].id, a.child), key_of(state.bodies[b.body].id, b.child)};
  }
};

/// The first old contact that may belong to this pair or a later one.
std::size_t first_old_contact(const PairSearch& search, const Pair& pair) {
  const ContactKey key = search.key(pair);
  std::size_t low = 0;
  std::size_t high = search.old_count;
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (key_of(search.old_rows[middle]) < key)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

/// The contacts of the tick before that may belong to the next pairs. In-place writes overwrite entries [0, next), and
/// `next` itself if it belongs to the same pair.
struct OldContacts {
  std::size_t first;  // at the begin of the buffer, if the buffer is in place
  std::size_t next;
  std::size_t end;
};

std::uint64_t place_of(const Pair& pair) {
  return std::uint64_t{pair.first} << 32 | pair.second;
}
std::uint64_t place_of(const ContactPair& pair) {
  return std::uint64_t{pair.proxy_a} << 32 | pair.proxy_b;
}

/// Moves old.next to the contact of a pair. True if it exists. Requires: may_reuse.
inline bool find_same(const ContactPair* old_pairs, const Pair& pair, OldContacts& old) {
  const std::uint64_t place = place_of(pair);
  while (old.next < old.end && place_of(old_pairs[old.next]) < place) ++old.next;
  return old.next < old.end && place_of(old_pairs[old.next]) == place;
}
/// Same as find_same, where bodies were added or removed, so that rows have changed.
bool find_old(const PairSearch& search, const Pair& pair, OldContacts& old) {
  const ContactKey key = search.key(pair);
  while (old.next < old.end && key_of(search.old_rows[old.next]) < key) ++old.next;
  return old.next < old.end && key_of(search.old_rows[old.next]) == key;
}

/// Whether the bounding circles of two shapes are too far apart for a contact.
bool are_far(const ShapeModel& shape_a, const ShapeModel& shape_b, const BodyRow& a, const BodyRow& b,
             Real gravity_displacement) {
  const Circle circle_a = circle_around(a, shape_a, gravity_displacement, 0);
  const Circle circle_b = circle_around(b, shape_b, gravity_displacement, 0);
  const Real touch_distance = circle_a.radius + circle_b.radius;
  return length_squared(circle_b.center - circle_a.center) > Real(1.01) * (touch_distance * touch_distance);
}

/// Whether a pair without a contact may begin one.
bool may_begin(const PairSearch& search, const Proxy& a, const Proxy& b) {
  if (a.is_sensor || b.is_sensor) return false;  // the events stage handles sensors
  const BodyRow& body_a = search.state.bodies[a.body];
  const BodyRow& body_b = search.state.bodies[b.body];
  if (are_separated(search.model, search.state, body_a.id, body_b.id)) return false;
  return !search.is_sparse || !are_far(search.model.shapes[a.shape], search.model.shapes[b.shape], body_a, body_b,
                                       search.gravity_displacement);
}

/// The candidates of a block in the tick before.
struct OldCandidates {
  std::uint64_t touched = 0;                      // [candidate] one bit each
  std::uint64_t unchanged = 0;                    // [candidate] one bit each: poses have not changed
  std::uint32_t next[PairBlock::pair_count_max];  // place of the old contact of this or a later candidate, if may_reuse

  bool all_touched(std::uint32_t count) const {
    return count > 0 && touched == ~std::uint64_t{0} >> (PairBlock::pair_count_max - count);
  }
};

/// Whether the pairs of a block are those for which it was made.
bool is_same(const PairSearch& search, const PairBlock& block, const Pair* pairs, std::size_t count) {
  return search.may_skip && block.is_valid && block.generation + 1 == search.generation &&
         (search.pairs_unchanged ||
          (block.pair_count == count && std::memcmp(block.pairs, pairs, count * sizeof(Pair)) == 0));
}

/// Finds the old contacts of an unchanged block, which were consecutive.
void find_old_of_block(const PairSearch& search, const PairBlock& block, OldContacts& old, OldCandidates& out) {
  const std::uint64_t place = place_of(block.pairs[0]);
  while (old.next < old.end && place_of(search.old_pairs[old.next]) < place) ++old.next;
  out.touched = block.found;
  auto next = static_cast<std::uint32_t>(old.next);
  if (out.all_touched(block.candidate_count)) {
    for (std::uint32_t i = 0; i < block.candidate_count; ++i) out.next[i] = next + i;
    next += block.candidate_count;
  } else {
    for (std::uint32_t i = 0; i < block.candidate_count; ++i) {
      out.next[i] = next;
      next += static_cast<std::uint32_t>(block.found >> i & 1);
    }
  }
  old.next = next;
}

/// Selects the candidates, the pairs of a block that may have contacts.
void choose_candidates(const PairSearch& search, const Pair* pairs, std::size_t count, OldContacts& old,
                       PairBlock& block, OldCandidates& out) {
  const ShapeModel* shapes = search.model.shapes.data();
  const Proxy* proxies = search.tick.proxies.data();
  const std::uint8_t* unchanged = search.may_reuse ? search.tick.changes.is_unchanged.data() : nullptr;
  block.pair_count = static_cast<std::uint32_t>(count);
  block.candidate_count = 0;
  block.box_count = 0;
  std::memcpy(block.pairs, pairs, count * sizeof(Pair));
  bool leaves_out_unchanged = false;
  for (std::size_t i = 0; i < count; ++i) {
    const Pair pair = pairs[i];
    const Proxy& a = proxies[pair.first];
    const Proxy& b = proxies[pair.second];
    const bool has_old = search.may_reuse && find_same(search.old_pairs, pair, old);
    if (!has_old && !may_begin(search, a, b)) continue;
    const bool is_unchanged = search.may_reuse && unchanged[a.body] != 0 && unchanged[b.body] != 0;
    if (is_unchanged && !has_old) {
      leaves_out_unchanged = true;
      continue;
    }
    const std::uint32_t place = block.candidate_count++;
    out.touched |= std::uint64_t{has_old} << place;
    out.unchanged |= std::uint64_t{is_unchanged} << place;
    out.next[place] = static_cast<std::uint32_t>(old.next);
    block.candidates[place] = {
        static_cast<std::uint8_t>(i),
        is_unchanged ? no_place
                     : add_box(block, shapes[a.shape], shapes[b.shape], a.body, b.body, search.gravity_displacement)};
  }
  complete_boxes(block);
  // A block is valid for later ticks only if its selection followed from the pairs alone.
  block.is_valid = !search.is_sparse && out.unchanged == 0 && !leaves_out_unchanged;
}

/// Where contacts are written: the first `limit` to `pairs` and `rows`, the others to the spill.
struct ContactBuffer {
  ContactPair* pairs;
  ContactRow* rows;
  std::size_t limit;
  ContactPair* contact_pairs_spilled;
  ContactRow* rows_spilled;
};

struct FoundContacts {
  std::size_t count;
  std::size_t in_place;  // the other contacts are in the spill
  bool any_new;          // some contact did not exist in the tick before
  CacheCounts blocks{};
  std::uint64_t unchanged_count = 0;  // contacts with unchanged manifolds
};

/// Copies the fields of a contact that do not depend on poses from the contact of the tick before.
void copy_constants(const ContactPair& old, ContactPair& pair) {
  pair.body_a = old.body_a;
  pair.body_b = old.body_b;
  std::memcpy(&pair.proxy_a, &old.proxy_a, sizeof(ContactPair) - offsetof(ContactPair, proxy_a));
}

/// Whether the row of a contact has the features of the manifold, in the same places.
bool has_features(const ContactRow& row, const Manifold& manifold) {
  return row.feature[0] == manifold.points[0].feature && row.feature[0] != row.feature[1] &&
         row.feature[1] == (manifold.point_count == 2 ? manifold.points[1].feature : no_feature);
}

/// Pairs begin..end-1 and their blocks.
struct PairRange {
  std::size_t begin;
  std::size_t end;
  PairBlock* blocks;
};

/// Finds and writes the contacts of some pairs, block by block.
class ContactWriter {
 public:
  ContactWriter(const PairSearch& search, const OldContacts& old)
      : search_(search),
        bodies_(search.state.bodies.data()),
        proxies_(search.tick.proxies.data()),
        old_(old),
        is_in_place_(search.is_in_place) {}

  FoundContacts found{0, 0, false, {}, 0};

  /// Begins a block: selects candidates, unless the block is unchanged. True if the block is unchanged.
  bool begin(const Pair* pairs, std::size_t count, PairBlock& block) {
    before_.touched = before_.unchanged = 0;
    const bool is_same_block = is_same(search_, block, pairs, count);
    if (is_same_block)
      find_old_of_block(search_, block, old_, before_);
    else
      choose_candidates(search_, pairs, count, old_, block, before_);
    ++(is_same_block ? found.blocks.hits : found.blocks.invalidations);
    found.unchanged_count += static_cast<std::uint64_t>(__builtin_popcountll(before_.unchanged));
    block.generation = search_.generation;
    block.found = 0;
    return is_same_block;
  }

  /// Sets the destination of the block's contacts.
  void enter(const ContactBuffer& buffer) {
    buffer_ = buffer;
    limit_ = std::min(buffer.limit, limit_in_place_);
  }

  /// Updates the contacts of an unchanged block if all its candidates are boxes with the same features as before. In a
  /// resting world most blocks are of this kind.
  bool renew(const BoxManifolds& boxes, PairBlock& block) {
    const std::size_t count = block.candidate_count;
    if (!is_in_place_ || !block.has_features || !before_.all_touched(block.candidate_count) ||
        found.count + count > limit_ || old_.first + found.count != before_.next[0] ||
        !boxes.renew(block, buffer_.pairs + found.count))
      return false;
    found.count += count;
    block.found = before_.touched;
    return true;
  }

  /// Finds the contact of candidate i, if it has one.
  [[gnu::always_inline]] void find(const BoxManifolds& boxes, PairBlock& block, std::size_t i) {
    const auto [index, place] = block.candidates[i];
    const Pair& pair = block.pairs[index];
    const bool touched = (before_.touched >> i & 1) != 0;
    const bool is_unchanged = (before_.unchanged >> i & 1) != 0;
    // Whether a new contact would overwrite an old contact of a later pair.
    const bool is_taken =
        is_in_place_ && !touched && found.count < limit_ && old_.first + found.count == before_.next[i];
    Manifold& manifold = is_taken ? not_yet_ : pair_at(found.count).manifold;
    if (!is_unchanged) {
      collide_pair(boxes, pair, place, manifold);
      if (manifold.point_count == 0) return;
    }
    const bool has_old = search_.may_reuse ? touched : find_old(search_, pair, old_);
    const std::size_t old_index = search_.may_reuse ? before_.next[i] : old_.next;
    if (is_taken) {
      limit_ = limit_in_place_ = found.count;
      is_in_place_ = false;
      pair_at(found.count).manifold = not_yet_;
    }
    write(pair, is_unchanged, has_old, old_index);
    block.found |= std::uint64_t{1} << i;
    found.any_new |= !has_old;
    ++found.count;
  }

  void leave() { found.in_place = std::min(found.count, limit_); }

 private:
  ContactPair& pair_at(std::size_t index) {
    return index < limit_ ? buffer_.pairs[index] : buffer_.contact_pairs_spilled[index - limit_];
  }
  ContactRow& row_at(std::size_t index) {
    return index < limit_ ? buffer_.rows[index] : buffer_.rows_spilled[index - limit_];
  }

  /// Finds the manifold of a pair. `place`: of the pair in `boxes`, or no_place.
  void collide_pair(const BoxManifolds& boxes, const Pair& pair, std::uint8_t place, Manifold& manifold) const {
    if (place != no_place) {
      boxes.write(place, manifold);
      if (!search_.speculates || manifold.point_count == 2) return;
    }
    const Proxy& a = proxies_[pair.first];
    const Proxy& b = proxies_[pair.second];
    const ShapeModel& shape_a = search_.model.shapes[a.shape];
    const ShapeModel& shape_b = search_.model.shapes[b.shape];
    const BodyRow& body_a = bodies_[a.body];
    const BodyRow& body_b = bodies_[b.body];
    if (place == no_place)
      new (&manifold) Manifold(collide(search_.model, shape_a, shape_b, body_a, body_b, search_.gravity_displacement));
    if (!search_.speculates) return;
    if (manifold.point_count == 0)
      manifold = speculative_manifold(search_.model, shape_a, shape_b, body_a, body_b, search_.gravity_displacement,
                                      search_.dt);
    else
      add_later_point(search_.model, shape_a, shape_b, body_a, body_b, search_.gravity_displacement, search_.dt,
                      manifold);
  }

  /// Writes the contact of a pair. Requires: its manifold is found, unless the pair is unchanged.
  void write(const Pair& pair, bool is_unchanged, bool has_old, std::size_t old_index) {
    ContactPair& contact = pair_at(found.count);
    ContactRow& row = row_at(found.count);
    const ContactRow* old_row = has_old ? search_.old_rows + old_index : nullptr;
    const Proxy& a = proxies_[pair.first];
    const Proxy& b = proxies_[pair.second];
    const auto write_now = [&](const ContactRow* old) {
      write_row(bodies_[a.body], a.child, bodies_[b.body], b.child, contact.manifold, old, row);
    };
    if (old_row == &row) {
      if (has_features(row, contact.manifold)) return;
      const ContactRow was = row;
      write_now(&was);
      return;
    }
    if (is_unchanged)
      contact = search_.old_pairs[old_index];
    else if (has_old && search_.may_reuse)
      copy_constants(search_.old_pairs[old_index], contact);
    else
      fill_constants(search_.model, search_.tick.proxies, pair, contact);
    write_now(old_row);
  }

  const PairSearch& search_;
  const BodyRow* bodies_;
  const Proxy* proxies_;
  OldContacts old_;
  OldCandidates before_;
  ContactBuffer buffer_{};
  std::size_t limit_ = 0;                         // later contacts go to the spill
  std::size_t limit_in_place_ = ~std::size_t{0};  // set at the first new contact
  bool is_in_place_;
  Manifold not_yet_;
};

/// Finds the contacts of some pairs. buffer_for(n, m): the destination of the first n contacts, of which at most m go
/// to the spill.
template <typename BufferFor>
FoundContacts find_contacts_of(const PairSearch& search, const PairRange& range, const OldContacts& old,
                               BufferFor buffer_for) {
  ContactWriter writer(search, old);
  const FoundContacts& found = writer.found;
  for (std::size_t first = range.begin; first < range.end; first += PairBlock::pair_count_max) {
    PairBlock& block = range.blocks[(first - range.begin) / PairBlock::pair_count_max];
    const std::size_t pair_count = std::min(PairBlock::pair_count_max, range.end - first);
    const bool is_same_block = writer.begin(search.tick.pairs.data() + first, pair_count, block);
    const BoxManifolds boxes(search.model, search.state, block);
    const std::size_t count = block.candidate_count;
    writer.enter(buffer_for(found.count + count, found.count - found.in_place + count));
    if (!is_same_block || !writer.renew(boxes, block)) {
      boxes.cache_features(block);
      for (std::size_t i = 0; i < count; ++i) writer.find(boxes, block, i);
    }
    writer.leave();
  }
  return found;
}

std::size_t blocks_of(std::size_t pair_count) {
  return (pair_count + PairBlock::pair_count_max - 1) / PairBlock::pair_count_max;
}

constexpr std::size_t pairs_per_chunk_least = 48;
constexpr std::size_t pairs_per_contact_dense = 2;

/// Finds contacts in chunks. Each chunk writes to its places of the tick before; further contacts go to the spill.
/// Unless every chunk fills exactly its places, all contacts are then copied to their places.
FoundContacts find_contacts_in_chunks(const PairSearch& search, NarrowPhaseWork& work, PairBlock* blocks,
                                      std::size_t chunk_size) {
  const std::size_t pair_count = search.tick.pairs.size();
  const std::size_t chunk_count = Parallel::chunk_count(pair_count, chunk_size);
  work.parts.resize(chunk_count);
  work.contact_pairs_spilled.resize(pair_count);
  work.contacts_spilled.resize(pair_count);
  // No larger than before: clearing unused rows takes as long as finding some contacts.
  const std::size_t old_count = search.is_in_place ? search.old_count : std::min(search.old_count, pair_count);
  work.contact_pairs.resize(old_count);
  work.contacts.resize(old_count);
  // Finds the first contacts of chunks before any contact is overwritten.
  for (std::size_t chunk = 0; chunk < chunk_count; ++chunk)
    work.parts[chunk].first = first_old_contact(search, search.tick.pairs[chunk * chunk_size]);
  std::atomic<bool> any_new{false};
  std::atomic<std::uint64_t> hit_count{0};
  std::atomic<std::uint64_t> made_count{0};
  std::atomic<std::uint64_t> unchanged_count{0};
  search.tick.parallel.for_chunks(pair_count, chunk_size, [&](const Chunk& chunk) {
    ListPart& part = work.parts[chunk.index];
    const std::size_t old_end = chunk.index + 1 < chunk_count ? work.parts[chunk.index + 1].first : search.old_count;
    const std::size_t first = std::min(part.first, old_count);
    const ContactBuffer place{work.contact_pairs.data() + first, work.contacts.data() + first,
                              std::min(old_end, old_count) - first, work.contact_pairs_spilled.data() + chunk.begin,
                              work.contacts_spilled.data() + chunk.begin};
    const FoundContacts found =
        find_contacts_of(search, {chunk.begin, chunk.end, blocks + chunk.index * blocks_of(chunk_size)},
                         {first, part.first, old_end}, [&](std::size_t, std::size_t) { return place; });
    part.in_place = found.in_place;
    part.count = found.count;
    if (found.any_new) any_new.store(true, std::memory_order_relaxed);
    hit_count.fetch_add(found.blocks.hits, std::memory_order_relaxed);
    made_count.fetch_add(found.blocks.invalidations, std::memory_order_relaxed);
    unchanged_count.fetch_add(found.unchanged_count, std::memory_order_relaxed);
  });
  std::size_t total = 0;
  bool all_in_place = true;
  for (ListPart& part : work.parts) {
    part.first = std::min(part.first, old_count);
    all_in_place = all_in_place && part.first == total && part.in_place == part.count;
    part.place = total;
    total += part.count;
  }
  const CacheCounts block_counts{hit_count, made_count};
  if (all_in_place) return {total, total, any_new, block_counts, unchanged_count};
  work.contact_pairs_moved.resize(total);
  work.contacts_moved.resize(total);
  search.tick.parallel.for_chunks(pair_count, chunk_size, [&](const Chunk& chunk) {
    const ListPart& part = work.parts[chunk.index];
    for (std::size_t i = 0; i < part.count; ++i) {
      const bool is_there = i < part.in_place;
      const std::size_t spilled = chunk.begin + i - part.in_place;
      work.contact_pairs_moved[part.place + i] =
          is_there ? work.contact_pairs[part.first + i] : work.contact_pairs_spilled[spilled];
      work.contacts_moved[part.place + i] = is_there ? work.contacts[part.first + i] : work.contacts_spilled[spilled];
    }
  });
  work.contact_pairs.swap(work.contact_pairs_moved);
  work.contacts.swap(work.contacts_moved);
  return {total, total, any_new, block_counts, unchanged_count};
}

/// Finds all contacts in one range, into lists without old contacts.
FoundContacts find_all_contacts(const PairSearch& search, NarrowPhaseWork& work, PairBlock* blocks) {
  work.contacts.resize(work.contact_pairs.size());
  return find_contacts_of(search, {0, search.tick.pairs.size(), blocks}, {0, 0, search.old_count},
                          [&](std::size_t count, std::size_t) {
                            if (work.contact_pairs.size() < count) {
                              work.contact_pairs.resize(count);
                              work.contacts.resize(count);
                            }
                            return ContactBuffer{work.contact_pairs.data(), work.contacts.data(),
                                                 work.contact_pairs.size(), nullptr, nullptr};
                          });
}

/// Finds all contacts in one range, in place up to the first contact that did not exist in the tick before.
FoundContacts find_contacts_in_place(const PairSearch& search, NarrowPhaseWork& work, PairBlock* blocks) {
  const FoundContacts found = find_contacts_of(
      search, {0, search.tick.pairs.size(), blocks}, {0, 0, search.old_count}, [&](std::size_t, std::size_t spilled) {
        if (work.contact_pairs_spilled.size() < spilled) {
          work.contact_pairs_spilled.resize(spilled);
          work.contacts_spilled.resize(spilled);
        }
        return ContactBuffer{work.contact_pairs.data(), work.contacts.data(), search.old_count,
                             work.contact_pairs_spilled.data(), work.contacts_spilled.data()};
      });
  work.contact_pairs.resize(found.count);
  work.contacts.resize(found.count);
  for (std::size_t i = found.in_place; i < found.count; ++i) {
    work.contact_pairs[i] = work.contact_pairs_spilled[i - found.in_place];
    work.contacts[i] = work.contacts_spilled[i - found.in_place];
  }
  return found;
}

}  // namespace

void NarrowPhase::run(const Model& model, State& state, TickLists& tick, Real dt) {
  const bool speculates = model.scene.settings.auto_substeps.has_value();
  const ManifoldKey key{tick.changes.is_known, tick.changes.body_generation, gravity_displacement_of_tick(model, state),
                        speculates ? dt : Real(0)};
  const bool may_reuse = manifolds_.valid_for(key, state.contacts.size());
  const bool is_in_place = may_reuse && places_.valid();
  if (is_in_place) {
    manifolds_.take(work_.contact_pairs);
    work_.contacts.swap(state.contacts);
  }
  const std::vector<ContactRow>& old = is_in_place ? work_.contacts : state.contacts;
  const std::size_t pair_count = tick.pairs.size();
  const std::size_t chunk_size = tick.parallel.chunk_size(pair_count, pairs_per_chunk_least, PairBlock::pair_count_max);
  PairBlock* blocks = blocks_.begin_tick(Parallel::chunk_count(pair_count, chunk_size) * blocks_of(chunk_size));
  const bool is_sparse = !speculates && pair_count > pairs_per_contact_dense * old.size();
  const PairSearch search{model,
                          state,
                          tick,
                          key.gravity_displacement,
                          dt,
                          speculates,
                          is_sparse,
                          may_reuse,
                          is_in_place,
                          old.data(),
                          is_in_place ? work_.contact_pairs.data() : manifolds_.pairs().data(),
                          old.size(),
                          blocks_.tick(),
                          may_reuse && !is_sparse && !tick.changes.many_are_unchanged,
                          tick.changes.same_pairs};
  FoundContacts found{};
  places_.count(is_in_place);
  if (chunk_size < pair_count)
    found = find_contacts_in_chunks(search, work_, blocks, chunk_size);
  else
    found = is_in_place ? find_contacts_in_place(search, work_, blocks) : find_all_contacts(search, work_, blocks);
  blocks_.count(found.blocks);
  manifolds_.count(found.unchanged_count, may_reuse);
  work_.contact_pairs.resize(found.count);
  work_.contacts.resize(found.count);
  state.contacts.swap(work_.contacts);
  places_.rebuild(found.any_new, is_in_place && !found.any_new && found.count == search.old_count);
  manifolds_.rebuild(key, work_.contact_pairs);
  tick.contact_pairs = manifolds_.pairs();
  tick.contact_generation = places_.generation();
}

void NarrowPhase::list_caches(std::vector<TickCache*>& caches) {
  caches.insert(caches.end(), {&manifolds_, &places_, &blocks_});
}

bool contains(const Model& model, const ShapeModel& shape, const BodyRow& row, Vec2 point) {
  const Vec2 local = rotate_back(row.rotation, point - row.position);
  if (shape.family == ShapeFamily::circle) return length_squared(local - shape.center) <= shape.radius * shape.radius;
  if (is_line(shape)) return false;
  bool inside = shape.vertex_count > 2;
  for (std::uint32_t i = shape.first_vertex; inside && i < shape.first_vertex + shape.vertex_count; ++i)
    inside = dot(model.normals[i], local - model.vertices[i]) <= 0;
  if (inside || shape.family == ShapeFamily::polygon) return inside;
  const Vec2 no_normals[1] = {};
  const ClosestPoints closest = closest_points(hull_of(model, shape), {&local, no_normals, 1});
  return closest.distance_squared <= shape.radius * shape.radius;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
