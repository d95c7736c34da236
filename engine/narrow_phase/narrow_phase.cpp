// Dispatch over shape kinds, and the stage that turns pairs into contacts.
// SPDX-License-Identifier: MIT
#include "engine/narrow_phase/narrow_phase.h"

#include <algorithm>
#include <new>

#include "engine/broad_phase/broad_phase.h"
#include "engine/narrow_phase/box_pairs.h"
#include "engine/narrow_phase/convex_hulls.h"
#include "engine/narrow_phase/foresee.h"
#include "engine/pipeline.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// Lines do not meet lines.
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

/// What contacts ascend by.
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

/// The row of a pair that touches: with the forces of the last tick for the points that are still the same ones. Number
/// by number: copying a row that was just put together waits until all of it is written.
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

}  // namespace

Manifold collide(const Model& model, const ShapeModel& a, const ShapeModel& b, const BodyRow& body_a,
                 const BodyRow& body_b, Real fall) {
  const Placement b_in_a{rotate_back(body_a.rotation, body_b.position - body_a.position),
                         between(body_a.rotation, body_b.rotation)};
  const Real margin = speculative_margin(pair_size(a, b), fall);
  Manifold manifold = collide_functions[row_of(a.family)][row_of(b.family)](model, a, b, b_in_a, margin);
  manifold.normal = rotate(body_a.rotation, manifold.normal);
  const Vec2 a_from_b = body_a.position - body_b.position;
  for (int i = 0; i < manifold.point_count; ++i) {
    ManifoldPoint& point = manifold.points[i];
    point.anchor_a = rotate(body_a.rotation, point.anchor_a);
    point.anchor_b = point.anchor_a + a_from_b;
  }
  return manifold;
}

namespace {

/// What a pair is beside its manifold.
void fill_constants(const Model& model, const Proxy& proxy_a, const Proxy& proxy_b, const ShapeModel& a,
                    const ShapeModel& b, TouchingPair& pair) {
  const MixedMaterial mixed = mixed_material(model, a, b);
  pair.body_a = proxy_a.body;
  pair.body_b = proxy_b.body;
  pair.friction = mixed.friction;
  pair.radius_a = a.radius;
  pair.radius_b = b.radius;
  pair.size = pair_size(a, b);
  pair.restitution = mixed.restitution;
  pair.tangent_speed = a.tangent_speed + b.tangent_speed;
  pair.rolling_resistance = larger(a.rolling_resistance, b.rolling_resistance);
}

/// What the pairs of one tick are looked at with.
struct PairSearch {
  const Model& model;
  const State& state;
  const Scratch& scratch;
  Real fall;
  Real dt;
  bool foresees;
  bool is_sparse;  // most pairs are far from touching, and a look at them is worth its time
  bool may_reuse;  // two shapes whose bodies have the bits they had a tick ago, as far as they count, touch as they did

  ContactKey key(const Pair& pair) const {
    const Proxy& a = scratch.proxies[pair.first];
    const Proxy& b = scratch.proxies[pair.second];
    return {key_of(state.bodies[a.body].id, a.child), key_of(state.bodies[b.body].id, b.child)};
  }
};

/// The first contact of the tick before that may belong to this pair or a later one.
std::size_t first_old_contact(const PairSearch& search, const Pair& pair) {
  const ContactKey key = search.key(pair);
  const std::vector<ContactRow>& contacts = search.state.contacts;
  std::size_t low = 0;
  std::size_t high = contacts.size();
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (key_of(contacts[middle]) < key)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

/// A pair that may touch.
struct Candidate {
  const Proxy* a;
  const Proxy* b;
  bool is_still;       // it does what it did a tick ago
  std::uint8_t place;  // in the block of boxes
};

/// Whether two shapes are certainly too far apart to touch: so are the circles around them.
bool are_far(const ShapeModel& shape_a, const ShapeModel& shape_b, const BodyRow& a, const BodyRow& b, Real fall) {
  const Circle circle_a = circle_around(a, shape_a, fall, 0);
  const Circle circle_b = circle_around(b, shape_b, fall, 0);
  const Real near = circle_a.radius + circle_b.radius;
  return length_squared(circle_b.center - circle_a.center) > Real(1.01) * (near * near);
}

/// Chooses those of the pairs begin..end-1 that may touch, and lets kernels find the contacts of those they can do.
std::size_t choose_candidates(const PairSearch& search, std::size_t begin, std::size_t end, Candidate* out,
                              BoxBlock& boxes) {
  const Model& model = search.model;
  const BodyRow* bodies = search.state.bodies.data();
  const ShapeModel* shapes = model.shapes.data();
  const Proxy* proxies = search.scratch.proxies.data();
  const std::uint8_t* still = search.may_reuse ? search.scratch.kept.pairs.is_still.data() : nullptr;
  boxes.clear();
  std::size_t count = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const Pair& pair = search.scratch.pairs[i];
    const Proxy& a = proxies[pair.first];
    const Proxy& b = proxies[pair.second];
    if (a.is_sensor || b.is_sensor) continue;  // the events stage has those
    if (are_separated(model, bodies[a.body].id, bodies[b.body].id)) continue;
    const ShapeModel& shape_a = shapes[a.shape];
    const ShapeModel& shape_b = shapes[b.shape];
    if (search.is_sparse && are_far(shape_a, shape_b, bodies[a.body], bodies[b.body], search.fall)) continue;
    Candidate& candidate = out[count++];
    candidate = {&a, &b, still != nullptr && still[a.body] != 0 && still[b.body] != 0, BoxBlock::no_place};
    if (!candidate.is_still) candidate.place = boxes.add(shape_a, shape_b, a.body, b.body, search.fall);
  }
  boxes.collide(model, search.state);
  return count;
}

/// Where contacts are written: the first `size` of them in their places, those that do not fit apart.
struct ContactRoom {
  TouchingPair* touching;
  ContactRow* rows;
  std::size_t size;
  TouchingPair* touching_apart;
  ContactRow* rows_apart;
};

/// Finds the contacts of the pairs begin..end-1, at most one each: manifolds are large. room_for(n): where to write the
/// first n of them. Returns how many there are. `old_index`: first_old_contact of the first pair.
template <typename RoomFor>
std::size_t find_contacts_of(const PairSearch& search, std::size_t begin, std::size_t end, std::size_t old_index,
                             RoomFor room_for) {
  const Model& model = search.model;
  const BodyRow* bodies = search.state.bodies.data();
  const ContactRow* old_rows = search.state.contacts.data();
  const std::size_t old_count = search.state.contacts.size();
  std::size_t count = 0;
  BoxBlock boxes;
  Candidate candidates[BoxBlock::pair_count_max];
  for (std::size_t first = begin; first < end; first += BoxBlock::pair_count_max) {
    const std::size_t last = std::min(first + BoxBlock::pair_count_max, end);
    const std::size_t candidate_count = choose_candidates(search, first, last, candidates, boxes);
    const ContactRoom room = room_for(count + candidate_count);
    for (std::size_t i = 0; i < candidate_count; ++i) {
      const auto [proxy_a, proxy_b, is_still, place] = candidates[i];
      const BodyRow& body_a = bodies[proxy_a->body];
      const BodyRow& body_b = bodies[proxy_b->body];
      const ShapeModel& shape_a = model.shapes[proxy_a->shape];
      const ShapeModel& shape_b = model.shapes[proxy_b->shape];
      const bool fits = count < room.size;
      TouchingPair& touching = fits ? room.touching[count] : room.touching_apart[count];
      if (!is_still) {
        if (boxes.has(place))
          boxes.write(place, touching.manifold);
        else
          new (&touching.manifold) Manifold(collide(model, shape_a, shape_b, body_a, body_b, search.fall));
        if (search.foresees && touching.manifold.point_count == 0)
          touching.manifold = foresee(model, shape_a, shape_b, body_a, body_b, search.fall, search.dt);
        if (touching.manifold.point_count == 0) continue;
        fill_constants(model, *proxy_a, *proxy_b, shape_a, shape_b, touching);
      }
      const ContactKey key{key_of(body_a.id, proxy_a->child), key_of(body_b.id, proxy_b->child)};
      while (old_index < old_count && key_of(old_rows[old_index]) < key) ++old_index;
      const bool has_old = old_index < old_count && key_of(old_rows[old_index]) == key;
      if (is_still) {
        if (!has_old) continue;
        touching = search.scratch.kept.touching[old_index];
      }
      write_row(body_a, proxy_a->child, body_b, proxy_b->child, touching.manifold,
                has_old ? old_rows + old_index : nullptr, fits ? room.rows[count] : room.rows_apart[count]);
      ++count;
    }
  }
  return count;
}

constexpr std::size_t pairs_per_chunk_least = 48;
constexpr std::size_t pairs_per_contact_dense = 2;

/// In chunks: each writes where the contacts of its pairs were a tick ago, and what does not fit elsewhere. Where every
/// chunk has found as many as there were, all are in their places; else they are copied there.
std::size_t find_contacts_in_chunks(const PairSearch& search, Scratch& scratch, std::size_t chunk_size) {
  const std::size_t pair_count = scratch.pairs.size();
  const std::size_t chunk_count = Parallel::chunk_count(pair_count, chunk_size);
  scratch.parts.resize(chunk_count);
  scratch.touching_apart.resize(pair_count);
  scratch.contacts_apart.resize(pair_count);
  // No larger than before: to clear rows that nothing will be in takes as long as to find the contacts of some.
  const std::size_t old_count = std::min(search.state.contacts.size(), pair_count);
  scratch.touching.resize(old_count);
  scratch.contacts.resize(old_count);
  const auto guess = [&](std::size_t chunk) {
    if (chunk == chunk_count) return old_count;
    return std::min(first_old_contact(search, scratch.pairs[chunk * chunk_size]), old_count);
  };
  scratch.parallel.for_chunks(pair_count, chunk_size, [&](const Chunk& chunk) {
    const std::size_t first = guess(chunk.index);
    const std::size_t room = guess(chunk.index + 1) - first;
    const std::size_t old_index = first_old_contact(search, scratch.pairs[chunk.begin]);
    const ContactRoom place{scratch.touching.data() + first, scratch.contacts.data() + first, room,
                            scratch.touching_apart.data() + chunk.begin, scratch.contacts_apart.data() + chunk.begin};
    const std::size_t count =
        find_contacts_of(search, chunk.begin, chunk.end, old_index, [&](std::size_t) { return place; });
    scratch.parts[chunk.index] = {first, room, count, 0};
  });
  std::size_t total = 0;
  bool all_in_place = true;
  for (ListPart& part : scratch.parts) {
    all_in_place = all_in_place && part.first == total && part.count <= part.room;
    part.place = total;
    total += part.count;
  }
  if (all_in_place) return total;
  scratch.touching_moved.resize(total);
  scratch.contacts_moved.resize(total);
  scratch.parallel.for_chunks(pair_count, chunk_size, [&](const Chunk& chunk) {
    const ListPart& part = scratch.parts[chunk.index];
    for (std::size_t i = 0; i < part.count; ++i) {
      const bool fits = i < part.room;
      scratch.touching_moved[part.place + i] =
          fits ? scratch.touching[part.first + i] : scratch.touching_apart[chunk.begin + i];
      scratch.contacts_moved[part.place + i] =
          fits ? scratch.contacts[part.first + i] : scratch.contacts_apart[chunk.begin + i];
    }
  });
  scratch.touching.swap(scratch.touching_moved);
  scratch.contacts.swap(scratch.contacts_moved);
  return total;
}

/// In one go.
std::size_t find_all_contacts(const PairSearch& search, Scratch& scratch) {
  scratch.contacts.resize(scratch.touching.size());
  return find_contacts_of(search, 0, scratch.pairs.size(), 0, [&](std::size_t count) {
    if (scratch.touching.size() < count) {
      scratch.touching.resize(count);
      scratch.contacts.resize(count);
    }
    return ContactRoom{scratch.touching.data(), scratch.contacts.data(), scratch.touching.size(), nullptr, nullptr};
  });
}

}  // namespace

void find_contacts(const Model& model, State& state, Scratch& scratch, Real dt) {
  Kept& kept = scratch.kept;
  const bool foresees = model.scene.settings.auto_substeps.has_value();
  const PairSearch search{model,
                          state,
                          scratch,
                          fall_of_a_tick(model, state),
                          dt,
                          foresees,
                          !foresees && scratch.pairs.size() > pairs_per_contact_dense * state.contacts.size(),
                          kept.has_touching && kept.touching.size() == state.contacts.size()};
  const std::size_t pair_count = scratch.pairs.size();
  const std::size_t chunk_size = scratch.parallel.chunk_size(pair_count, pairs_per_chunk_least);
  const std::size_t count = chunk_size >= pair_count ? find_all_contacts(search, scratch)
                                                     : find_contacts_in_chunks(search, scratch, chunk_size);
  scratch.touching.resize(count);
  scratch.contacts.resize(count);
  state.contacts.swap(scratch.contacts);
  kept.has_touching = kept.pairs.is_valid;
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
