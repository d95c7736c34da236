// Colouring and packing of contacts, and the impulses carried from tick to tick.
// SPDX-License-Identifier: MIT
#include "engine/constraints/contact_batch.h"

#include "engine/constraints/bodies.h"
#include "engine/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

// One bit each in a body's colour set. Contacts between two moving bodies come first, those with something immovable
// last: the last ones solved are met best, and nothing may sink into the ground.
constexpr std::uint32_t class_color_count = 32;
constexpr std::uint32_t round_color_count = 2 * class_color_count;
constexpr std::uint32_t uncolored = 0xffffffff;

/// Stiffness against the substep rate 1/h. Not a fixed frequency: with it the error falls as substeps^-2.
constexpr Real hertz_per_rate = Real(0.125);
constexpr Real contact_damping_ratio = 10;

/// Share of an overlap taken back per step. Source: Baumgarte, "Stabilization of Constraints", 1972.
constexpr Real baumgarte = Real(0.2);

/// Colours the contacts of one round; those of bodies that have no colour left wait for the next. True if any do.
template <bool is_first>
bool color_round(const State& state, Scratch& scratch, const SolveGroup& group, std::uint32_t round) {
  ContactBatches& out = scratch.contact_batches;
  const std::uint32_t* contacts = scratch.group_contacts.data() + group.first_contact;
  const std::uint32_t unread = unread_record(scratch);
  bool any_left = false;
  out.body_colors.assign(state.bodies.size(), {0, 0});
  for (std::size_t i = 0; i < out.colors.size(); ++i) {
    if (!is_first && out.colors[i] != uncolored) continue;
    const TouchingPair& pair = scratch.touching[contacts[i]];
    const bool a_moves = scratch.masses[pair.body_a].write != unread;
    const bool b_moves = scratch.masses[pair.body_b].write != unread;
    BodyColors& a = out.body_colors[pair.body_a];
    BodyColors& b = out.body_colors[pair.body_b];
    std::uint32_t used;
    if (a_moves && b_moves) {
      used = a.moving | b.moving;
      const std::uint32_t bit = ~used & (used + 1);  // the lowest that is free, or none
      a.moving |= bit;
      b.moving |= bit;
    } else {
      BodyColors& mover = a_moves ? a : b;
      used = mover.immovable;
      mover.immovable |= ~used & (used + 1);
    }
    const bool is_left = used == 0xffffffffu;
    any_left |= is_left;
    const std::uint32_t color = is_left ? 0u : static_cast<std::uint32_t>(__builtin_ctz(~used));
    out.colors[i] =
        is_left ? uncolored : round * round_color_count + color + (a_moves && b_moves ? 0u : class_color_count);
  }
  return any_left;
}

/// colors[i]: of the i-th contact of the group. Returns the number of rounds.
std::uint32_t color_contacts(const State& state, Scratch& scratch, const SolveGroup& group) {
  scratch.contact_batches.colors.resize(group.contact_end - group.first_contact);
  std::uint32_t round_count = 1;
  bool any_left = color_round<true>(state, scratch, group, 0);
  while (any_left) any_left = color_round<false>(state, scratch, group, round_count++);
  return round_count;
}

/// Counts batches, notes them in `group`, and makes room for them.
void place_batches(Scratch& scratch, SolveGroup& group, unsigned features, std::uint32_t round_count) {
  ContactBatches& out = scratch.contact_batches;
  out.places.assign(std::size_t{round_count} * round_color_count, {0, 0});
  for (const std::uint32_t color : out.colors) ++out.places[color].lane;  // counts for now
  std::size_t next = out.batch_count;
  group.first_batch = static_cast<std::uint32_t>(next);
  for (const std::uint32_t first : {0u, class_color_count}) {
    for (std::uint32_t round = 0; round < round_count; ++round) {
      for (std::uint32_t color = 0; color < class_color_count; ++color) {
        ColorPlace& place = out.places[round * round_color_count + first + color];
        const std::uint32_t count = place.lane;
        place = {static_cast<std::uint32_t>(next), 0};
        next += (count + lane_count - 1) / lane_count;
      }
    }
  }
  out.batch_count = next;
  group.batch_end = static_cast<std::uint32_t>(next);
  if (out.batches.size() < next) out.batches.resize(next);
  if ((features & contact_feature::bounce) != 0 && out.bounces.size() < next) out.bounces.resize(next);
  if ((features & contact_feature::surface) != 0 && out.surfaces.size() < next) out.surfaces.resize(next);
}

void empty_point(ContactPointLanes& out, std::uint32_t lane) {
  for (Lanes* lanes : {&out.normal_arm_a, &out.normal_arm_b, &out.tangent_arm_a, &out.tangent_arm_b, &out.separation,
                       &out.normal_mass, &out.normal_impulse, &out.tangent_mass, &out.tangent_impulse})
    lanes->at[lane] = 0;
}

/// Lanes without a contact push nothing and are written to a record nobody reads.
void empty_lane(const Scratch& scratch, ContactBatch& batch, std::uint32_t lane) {
  batch.read_a[lane] = batch.read_b[lane] = resting_record(scratch);
  batch.write_a[lane] = batch.write_b[lane] = unread_record(scratch);
  batch.contact[lane] = 0;
  for (Lanes* lanes : {&batch.inv_mass_a, &batch.inv_mass_b, &batch.inv_inertia_a, &batch.inv_inertia_b,
                       &batch.normal_x, &batch.normal_y, &batch.friction, &batch.radius_a, &batch.radius_b})
    lanes->at[lane] = 0;
  for (ContactPointLanes& point : batch.points) empty_point(point, lane);
}

/// Ends a batch that is not full: what a full one does not need of the first `count` lanes, and the others.
void end_batch(const Scratch& scratch, ContactBatch& batch, std::uint32_t count) {
  for (std::uint32_t lane = 0; lane < count && batch.immovable == 0; ++lane) {
    batch.write_a[lane] = batch.read_a[lane];
    batch.write_b[lane] = batch.read_b[lane];
  }
  for (std::uint32_t lane = count; lane < lane_count; ++lane) empty_lane(scratch, batch, lane);
}

void fill_point(ContactPointLanes& out, std::uint32_t lane, const ManifoldPoint& point, Real slop, Real normal_force,
                Real tangent_force) {
  out.normal_arm_a.at[lane] = point.anchor_a.x;
  out.normal_arm_b.at[lane] = point.anchor_a.y;
  out.tangent_arm_a.at[lane] = point.anchor_b.x;
  out.tangent_arm_b.at[lane] = point.anchor_b.y;
  out.separation.at[lane] = point.separation + slop;
  out.normal_mass.at[lane] = 1;
  out.normal_impulse.at[lane] = normal_force;
  out.tangent_impulse.at[lane] = tangent_force;
}

void fill_lane(const Scratch& scratch, ContactBatch& batch, std::uint32_t lane, std::uint32_t contact,
               const ContactRow& row, Real slop) {
  const TouchingPair& pair = scratch.touching[contact];
  const BodyMass& a = scratch.masses[pair.body_a];
  const BodyMass& b = scratch.masses[pair.body_b];
  batch.contact[lane] = contact;
  batch.read_a[lane] = a.read;
  batch.read_b[lane] = b.read;
  if (batch.immovable != 0) {
    batch.write_a[lane] = a.write;
    batch.write_b[lane] = b.write;
  }
  batch.inv_mass_a.at[lane] = a.inv_mass;
  batch.inv_mass_b.at[lane] = b.inv_mass;
  batch.inv_inertia_a.at[lane] = a.inv_inertia;
  batch.inv_inertia_b.at[lane] = b.inv_inertia;
  batch.normal_x.at[lane] = pair.manifold.normal.x;
  batch.normal_y.at[lane] = pair.manifold.normal.y;
  batch.friction.at[lane] = pair.friction;
  batch.radius_a.at[lane] = pair.radius_a;
  batch.radius_b.at[lane] = pair.radius_b;
  for (int i = 0; i < 2; ++i)
    if (i < pair.manifold.point_count)
      fill_point(batch.points[i], lane, pair.manifold.points[i], slop * pair.size, row.normal_force[i],
                 row.tangent_force[i]);
    else
      empty_point(batch.points[i], lane);
}

void fill_surface(const Scratch& scratch, SurfaceLanes& out, std::uint32_t lane, const TouchingPair& pair) {
  const Real inv_inertia = scratch.masses[pair.body_a].inv_inertia + scratch.masses[pair.body_b].inv_inertia;
  out.tangent_speed.at[lane] = pair.tangent_speed;
  out.rolling_resistance.at[lane] = pair.rolling_resistance;
  out.rolling_mass.at[lane] = inv_inertia > 0 ? 1 / inv_inertia : Real(0);
}

ContactWork work_of(Scratch& scratch, const SolveGroup& group) {
  ContactBatches& all = scratch.contact_batches;
  const std::size_t first = group.first_batch;
  return {all.batches.data() + first,
          group.batch_end - first,
          all.surfaces.empty() ? nullptr : all.surfaces.data() + first,
          all.bounces.empty() ? nullptr : all.bounces.data() + first,
          &scratch.bodies.data()->velocity.x,
          group.h,
          group.stiffness.moving,
          group.stiffness.immovable};
}

}  // namespace

Real soft_contact_stiffness(Real h) {
  const Real omega = Real(2 * pi) * hertz_per_rate / h;
  return omega * omega;
}

ContactStiffness soft_contacts(Real h) {
  const Real hertz = hertz_per_rate / h;
  return {make_soft(hertz, contact_damping_ratio, h), make_soft(2 * hertz, contact_damping_ratio, h), 0};
}

ContactStiffness baumgarte_contacts(Real h) {
  const Softness rigid{baumgarte / h, 1, 0};
  return {rigid, rigid, Real(0.005)};
}

void clear_contacts(Scratch& scratch) {
  scratch.contact_batches.batch_count = 0;
}

void prepare_contacts(const Model& model, const State& state, Scratch& scratch, SolveGroup& group,
                      const ContactStiffness& stiffness) {
  group.stiffness = stiffness;
  const std::uint32_t round_count = color_contacts(state, scratch, group);
  place_batches(scratch, group, model.contact_features, round_count);
  ContactBatches& out = scratch.contact_batches;
  const bool bounces = (model.contact_features & contact_feature::bounce) != 0;
  const bool has_surfaces = (model.contact_features & contact_feature::surface) != 0;
  const std::uint32_t* contacts = scratch.group_contacts.data() + group.first_contact;
  for (std::size_t i = 0; i < out.colors.size(); ++i) {
    const std::uint32_t color = out.colors[i];
    ColorPlace& place = out.places[color];
    const std::uint32_t contact = contacts[i];
    const TouchingPair& pair = scratch.touching[contact];
    ContactBatch& batch = out.batches[place.batch];
    if (place.lane == 0) {
      batch.immovable = color % round_color_count >= class_color_count ? 1 : 0;
      batch.bounces = 0;
      if (bounces) out.bounces[place.batch] = {};
      if (has_surfaces) out.surfaces[place.batch] = {};
    }
    fill_lane(scratch, batch, place.lane, contact, state.contacts[contact], stiffness.slop);
    if (bounces) out.bounces[place.batch].restitution.at[place.lane] = pair.restitution;
    batch.bounces |= pair.restitution > 0 ? 1 : 0;
    if (has_surfaces) fill_surface(scratch, out.surfaces[place.batch], place.lane, pair);
    batch.count = static_cast<std::int32_t>(++place.lane);
    if (place.lane < lane_count) continue;
    ++place.batch;
    place.lane = 0;
  }
  for (const ColorPlace& place : out.places)
    if (place.lane > 0) end_batch(scratch, out.batches[place.batch], place.lane);
  scratch.kernels->contacts.prepare(work_of(scratch, group));
}

void warm_start_contacts(Scratch& scratch, const SolveGroup& group) {
  scratch.kernels->contacts.warm_start(work_of(scratch, group));
}

void solve_contacts(Scratch& scratch, const SolveGroup& group, Bias bias) {
  const ContactKernels& kernels = scratch.kernels->contacts;
  (bias == Bias::on ? kernels.solve : kernels.relax)(work_of(scratch, group));
}

bool bounce_contacts(Scratch& scratch, const SolveGroup& group, Real threshold) {
  return scratch.kernels->contacts.bounce(work_of(scratch, group), threshold);
}

void save_impulses(Scratch& scratch, const SolveGroup& group) {
  ContactBatches& out = scratch.contact_batches;
  out.saved.clear();
  for (std::uint32_t i = group.first_batch; i < group.batch_end; ++i)
    for (const ContactPointLanes& point : out.batches[i].points) out.saved.push_back(point.normal_impulse);
}

void limit_impulses(Scratch& scratch, const SolveGroup& group) {
  ContactBatches& out = scratch.contact_batches;
  std::size_t next = 0;
  for (std::uint32_t i = group.first_batch; i < group.batch_end; ++i)
    for (ContactPointLanes& point : out.batches[i].points) {
      const Lanes& saved = out.saved[next++];
      for (int lane = 0; lane < lane_count; ++lane) {
        point.normal_impulse.at[lane] = smaller(point.normal_impulse.at[lane], saved.at[lane]);
        const Real limit = out.batches[i].friction.at[lane] * point.normal_impulse.at[lane];
        point.tangent_impulse.at[lane] = larger(smaller(point.tangent_impulse.at[lane], limit), -limit);
      }
    }
}

void store_contacts(const Scratch& scratch, const SolveGroup& group, State& state) {
  const Real inv_h = 1 / group.h;
  for (std::uint32_t i = group.first_batch; i < group.batch_end; ++i) {
    const ContactBatch& batch = scratch.contact_batches.batches[i];
    for (int lane = 0; lane < batch.count; ++lane) {
      ContactRow& row = state.contacts[batch.contact[lane]];
      for (int p = 0; p < 2; ++p) {
        row.normal_force[p] = inv_h * batch.points[p].normal_impulse.at[lane];
        row.tangent_force[p] = inv_h * batch.points[p].tangent_impulse.at[lane];
      }
    }
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
