// Dispatch over shape kinds, and the stage that turns pairs into contacts.
// SPDX-License-Identifier: MIT
#include "engine/narrow_phase/narrow_phase.h"

#include <new>

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

bool comes_before(const ContactRow& a, const ContactRow& b) {
  if (a.body_a != b.body_a) return a.body_a < b.body_a;
  if (a.child_a != b.child_a) return a.child_a < b.child_a;
  if (a.body_b != b.body_b) return a.body_b < b.body_b;
  return a.child_b < b.child_b;
}

/// Forces of the last tick for the points that are still the same ones.
void carry_forces(const ContactRow& old_row, ContactRow& row) {
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t j = 0; j < 2; ++j)
      if (row.feature[i] != no_feature && row.feature[i] == old_row.feature[j]) {
        row.normal_force[i] = old_row.normal_force[j];
        row.tangent_force[i] = old_row.tangent_force[j];
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

/// The row of a pair without forces.
ContactRow row_of_pair(const State& state, const Proxy& a, const Proxy& b) {
  return {state.bodies[a.body].id, a.child, state.bodies[b.body].id, b.child, {no_feature, no_feature}, {0, 0}, {0, 0}};
}

/// What a pair is beside its manifold.
void fill_constants(const Model& model, const Proxy& proxy_a, const Proxy& proxy_b, const ShapeModel& a,
                    const ShapeModel& b, TouchingPair& pair) {
  const MixedMaterial mixed = mixed_material(model, a, b);
  pair.body_a = proxy_a.body;
  pair.body_b = proxy_b.body;
  pair.friction = mixed.friction;
  pair.restitution = mixed.restitution;
  pair.size = pair_size(a, b);
  pair.radius_a = a.radius;
  pair.radius_b = b.radius;
  pair.tangent_speed = a.tangent_speed + b.tangent_speed;
  pair.rolling_resistance = larger(a.rolling_resistance, b.rolling_resistance);
}

}  // namespace

void find_contacts(const Model& model, State& state, Scratch& scratch, Real dt) {
  const bool foresees = model.scene.settings.auto_substeps.has_value();
  const Real fall = fall_of_a_tick(model, state);
  // Two shapes whose bodies have the bits they had a tick ago, as far as they count, touch as they did then.
  Kept& kept = scratch.kept;
  const bool may_reuse = kept.has_touching && kept.touching.size() == state.contacts.size();
  // Rows are written in their places: manifolds are large.
  scratch.touching.resize(scratch.pairs.size());
  scratch.contacts.resize(scratch.pairs.size());
  std::size_t count = 0;
  std::size_t old_index = 0;
  for (const Pair& pair : scratch.pairs) {
    const Proxy& proxy_a = scratch.proxies[pair.first];
    const Proxy& proxy_b = scratch.proxies[pair.second];
    if (proxy_a.is_sensor || proxy_b.is_sensor) continue;  // the events stage has those
    const BodyRow& body_a = state.bodies[proxy_a.body];
    const BodyRow& body_b = state.bodies[proxy_b.body];
    if (!model.separated.empty() && are_separated(model.separated, body_a.id, body_b.id)) continue;
    ContactRow row = row_of_pair(state, proxy_a, proxy_b);
    const bool is_still = may_reuse && kept.pairs.is_still[proxy_a.body] != 0 && kept.pairs.is_still[proxy_b.body] != 0;
    const ShapeModel& shape_a = model.shapes[proxy_a.shape];
    const ShapeModel& shape_b = model.shapes[proxy_b.shape];
    TouchingPair& touching = scratch.touching[count];
    if (!is_still) {
      new (&touching.manifold) Manifold(collide(model, shape_a, shape_b, body_a, body_b, fall));
      if (foresees && touching.manifold.point_count == 0)
        touching.manifold = foresee(model, shape_a, shape_b, body_a, body_b, fall, dt);
      if (touching.manifold.point_count == 0) continue;
      fill_constants(model, proxy_a, proxy_b, shape_a, shape_b, touching);
    }
    while (old_index < state.contacts.size() && comes_before(state.contacts[old_index], row)) ++old_index;
    const bool has_old = old_index < state.contacts.size() && !comes_before(row, state.contacts[old_index]);
    if (is_still) {
      if (!has_old) continue;
      touching = kept.touching[old_index];
    }
    for (int i = 0; i < touching.manifold.point_count; ++i) row.feature[i] = touching.manifold.points[i].feature;
    if (has_old) carry_forces(state.contacts[old_index], row);
    scratch.contacts[count++] = row;
  }
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
