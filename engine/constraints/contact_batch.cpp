// Colouring and packing of contacts, and the impulses carried from tick to tick.
// SPDX-License-Identifier: MIT
#include "engine/constraints/contact_batch.h"

#include <atomic>

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

/// So many contacts are worth another thread's while.
constexpr std::size_t contacts_per_chunk_least = 256;

/// Fills coloring.ends. True if they are those that were there.
bool find_ends(Scratch& scratch, const SolveGroup& group, ContactColoring& coloring) {
  const std::uint32_t* contacts = scratch.group_contacts.data() + group.first_contact;
  const std::uint32_t unread = unread_record(scratch);
  const std::size_t count = group.contact_end - group.first_contact;
  std::atomic<bool> changed{coloring.ends.size() != count};
  coloring.ends.resize(count);
  const auto mover = [&](std::uint32_t row) { return scratch.masses[row].write == unread ? no_body : row; };
  scratch.parallel.for_chunks(count, scratch.parallel.chunk_size(count, contacts_per_chunk_least),
                              [&](const Chunk& chunk) {
                                bool same = true;
                                for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
                                  const TouchingPair& pair = scratch.touching[contacts[i]];
                                  const ContactEnds ends{mover(pair.body_a), mover(pair.body_b)};
                                  same &= ends == coloring.ends[i];
                                  coloring.ends[i] = ends;
                                }
                                if (!same) changed.store(true, std::memory_order_relaxed);
                              });
  return !changed.load(std::memory_order_relaxed);
}

/// Colours the contacts of one round, and counts those of each colour; those of bodies that have no colour left wait
/// for the next. `body_colors`: room for as many bodies as there are. True if any do.
template <bool is_first>
bool color_round(ContactColoring& out, std::vector<BodyColors>& body_colors, std::size_t body_count,
                 std::uint32_t round) {
  bool any_left = false;
  body_colors.assign(body_count, {0, 0});
  const std::uint32_t first_color = round * round_color_count;
  out.places.resize(first_color + round_color_count, {0, 0});
  for (std::size_t i = 0; i < out.colors.size(); ++i) {
    if (!is_first && out.colors[i].color != uncolored) continue;
    const ContactEnds ends = out.ends[i];
    const bool both_move = ends.a != no_body && ends.b != no_body;
    std::uint32_t used;
    if (both_move) {
      BodyColors& a = body_colors[ends.a];
      BodyColors& b = body_colors[ends.b];
      used = a.moving | b.moving;
      const std::uint32_t bit = ~used & (used + 1);  // the lowest that is free, or none
      a.moving |= bit;
      b.moving |= bit;
    } else {
      BodyColors& mover = body_colors[ends.a != no_body ? ends.a : ends.b];
      used = mover.immovable;
      mover.immovable |= ~used & (used + 1);
    }
    const bool is_left = used == 0xffffffffu;
    any_left |= is_left;
    out.colors[i] = {uncolored, 0};
    if (is_left) continue;
    const std::uint32_t color =
        first_color + static_cast<std::uint32_t>(__builtin_ctz(~used)) + (both_move ? 0u : class_color_count);
    out.colors[i] = {color, out.places[color].count++};
  }
  return any_left;
}

/// Colours the contacts of a group.
void color_contacts(Scratch& scratch, const SolveGroup& group) {
  ContactColoring& coloring = scratch.kept.coloring;
  if (find_ends(scratch, group, coloring)) return;
  std::vector<BodyColors>& body_colors = scratch.contact_batches.body_colors;
  const std::size_t body_count = scratch.masses.size();
  coloring.colors.resize(coloring.ends.size());
  coloring.places.clear();
  coloring.round_count = 1;
  bool any_left = color_round<true>(coloring, body_colors, body_count, 0);
  while (any_left) any_left = color_round<false>(coloring, body_colors, body_count, coloring.round_count++);
}

/// So many batches are worth another thread's while.
constexpr std::size_t batches_per_chunk_least = 8;

/// Adds the batches of a colour to the runs: to the last one, if neither is for several threads.
void add_run(const Parallel& parallel, std::vector<BatchRun>& runs, bool is_first, std::uint32_t first,
             std::uint32_t end) {
  const std::size_t count = end - first;
  if (count == 0) return;
  const std::size_t size = parallel.chunk_size(count, batches_per_chunk_least, 1);
  const bool is_alone = size >= count;
  if (is_alone && !is_first && runs.back().chunk_size >= runs.back().end - runs.back().first) {
    runs.back().end = end;
    runs.back().chunk_size = end - runs.back().first;
    return;
  }
  runs.push_back({first, end, is_alone ? count : size});
}

/// Deals the contacts out to batches, colour by colour, notes them in `group`, and makes room for them.
void place_batches(Scratch& scratch, SolveGroup& group, unsigned features) {
  ContactBatches& out = scratch.contact_batches;
  ContactColoring& coloring = scratch.kept.coloring;
  auto next = static_cast<std::uint32_t>(out.batch_count);
  group.first_batch = next;
  group.first_run = static_cast<std::uint32_t>(out.runs.size());
  for (const std::uint32_t first : {0u, class_color_count})
    for (std::uint32_t round = 0; round < coloring.round_count; ++round)
      for (std::uint32_t color = 0; color < class_color_count; ++color) {
        ColorPlace& place = coloring.places[round * round_color_count + first + color];
        const std::uint32_t begin = next;
        place.first_slot = begin * contact_lane_count;
        next += (place.count + contact_lane_count - 1) / contact_lane_count;
        add_run(scratch.parallel, out.runs, out.runs.size() == group.first_run, begin, next);
      }
  out.batch_count = next;
  group.batch_end = next;
  group.run_end = static_cast<std::uint32_t>(out.runs.size());
  if (out.batches.size() < next) out.batches.resize(next);
  if ((features & contact_feature::bounce) != 0 && out.bounces.size() < next) out.bounces.resize(next);
  if ((features & contact_feature::surface) != 0 && out.surfaces.size() < next) out.surfaces.resize(next);
  if (out.slots.size() < std::size_t{next} * contact_lane_count)
    out.slots.resize(std::size_t{next} * contact_lane_count);
  for (const ColorPlace& place : coloring.places)
    for (std::uint32_t slot = place.first_slot + place.count; slot % contact_lane_count != 0; ++slot)
      out.slots[slot] = no_contact;
  const std::uint32_t* contacts = scratch.group_contacts.data() + group.first_contact;
  const std::size_t count = coloring.colors.size();
  scratch.parallel.for_chunks(
      count, scratch.parallel.chunk_size(count, contacts_per_chunk_least), [&](const Chunk& chunk) {
        for (std::size_t i = chunk.begin; i < chunk.end; ++i)
          out.slots[coloring.places[coloring.colors[i].color].first_slot + coloring.colors[i].rank] = contacts[i];
      });
}

void empty_point(ContactPointLanes& out, std::uint32_t lane) {
  for (ContactLanes* lanes :
       {&out.normal_arm_a, &out.normal_arm_b, &out.tangent_arm_a, &out.tangent_arm_b, &out.separation, &out.normal_mass,
        &out.normal_impulse, &out.tangent_mass, &out.tangent_impulse})
    lanes->at[lane] = 0;
}

/// Lanes without a contact push nothing and are written to a record nobody reads.
void empty_lane(const Scratch& scratch, ContactBatch& batch, std::uint32_t lane, std::uint32_t unread) {
  batch.read_a[lane] = batch.read_b[lane] = resting_record(scratch);
  batch.write_a[lane] = batch.write_b[lane] = unread;
  batch.contact[lane] = 0;
  for (ContactLanes* lanes : {&batch.inv_mass_a, &batch.inv_mass_b, &batch.inv_inertia_a, &batch.inv_inertia_b,
                              &batch.normal_x, &batch.normal_y, &batch.friction, &batch.radius_a, &batch.radius_b})
    lanes->at[lane] = 0;
  for (ContactPointLanes& point : batch.points) empty_point(point, lane);
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
               const ContactRow& row, Real slop, std::uint32_t unread) {
  const TouchingPair& pair = scratch.touching[contact];
  const BodyMass& a = scratch.masses[pair.body_a];
  const BodyMass& b = scratch.masses[pair.body_b];
  batch.contact[lane] = contact;
  batch.read_a[lane] = a.read;
  batch.read_b[lane] = b.read;
  batch.write_a[lane] = a.write == unread_record(scratch) ? unread : a.write;
  batch.write_b[lane] = b.write == unread_record(scratch) ? unread : b.write;
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

/// What a kernel needs for the batches first..end-1.
ContactWork work_of(Scratch& scratch, const SolveGroup& group, std::size_t first, std::size_t end) {
  ContactBatches& all = scratch.contact_batches;
  return {all.batches.data() + first,
          end - first,
          all.surfaces.empty() ? nullptr : all.surfaces.data() + first,
          all.bounces.empty() ? nullptr : all.bounces.data() + first,
          &scratch.bodies.data()->velocity.x,
          group.h,
          group.stiffness.moving,
          group.stiffness.immovable};
}

/// Runs a kernel over the batches of a group, colour by colour.
template <typename Kernel>
void for_colors(Scratch& scratch, const SolveGroup& group, Kernel kernel) {
  for (std::uint32_t i = group.first_run; i < group.run_end; ++i) {
    const BatchRun& run = scratch.contact_batches.runs[i];
    scratch.parallel.for_chunks(run.end - run.first, run.chunk_size, [&](const Chunk& chunk) {
      kernel(work_of(scratch, group, run.first + chunk.begin, run.first + chunk.end));
    });
  }
}

/// Whether impulses move only one of the pair.
bool is_immovable(const Scratch& scratch, const TouchingPair& pair) {
  const std::uint32_t unread = unread_record(scratch);
  return scratch.masses[pair.body_a].write == unread || scratch.masses[pair.body_b].write == unread;
}

constexpr std::size_t slots_ahead = 12;

/// Fills the batches first..end-1 of a colour.
void fill_batches(const Model& model, const State& state, Scratch& scratch, const SolveGroup& group, std::size_t first,
                  std::size_t end, std::uint32_t unread) {
  ContactBatches& out = scratch.contact_batches;
  const bool bounces = (model.contact_features & contact_feature::bounce) != 0;
  const bool has_surfaces = (model.contact_features & contact_feature::surface) != 0;
  const std::size_t slot_end = end * contact_lane_count;
  for (std::size_t i = first; i < end; ++i) {
    const std::uint32_t* slots = out.slots.data() + i * contact_lane_count;
    ContactBatch& batch = out.batches[i];
    batch.immovable = is_immovable(scratch, scratch.touching[slots[0]]) ? 1 : 0;
    batch.bounces = 0;
    batch.count = 0;
    if (bounces) out.bounces[i] = {};
    if (has_surfaces) out.surfaces[i] = {};
    for (std::uint32_t lane = 0; lane < contact_lane_count; ++lane) {
      const std::uint32_t contact = slots[lane];
      if (contact == no_contact) break;
      if (const std::size_t later = i * contact_lane_count + lane + slots_ahead;
          later < slot_end)  // a colour skips over memory
        if (out.slots[later] != no_contact) {
          __builtin_prefetch(&scratch.touching[out.slots[later]]);
          __builtin_prefetch(&scratch.touching[out.slots[later]].manifold.points[1]);
        }
      const TouchingPair& pair = scratch.touching[contact];
      fill_lane(scratch, batch, lane, contact, state.contacts[contact], group.stiffness.slop, unread);
      if (bounces) out.bounces[i].restitution.at[lane] = pair.restitution;
      batch.bounces |= pair.restitution > 0 ? 1 : 0;
      if (has_surfaces) fill_surface(scratch, out.surfaces[i], lane, pair);
      ++batch.count;
    }
    // Kernels take one that is alone by itself, but where it may bounce; else so many lanes at a time.
    const auto count = static_cast<std::uint32_t>(batch.count);
    const std::uint32_t read = count == 1 && !bounces ? 1 : (count + lane_count - 1) / lane_count * lane_count;
    for (std::uint32_t lane = count; lane < read; ++lane) empty_lane(scratch, batch, lane, unread);
  }
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
  scratch.contact_batches.runs.clear();
}

void prepare_contacts(const Model& model, const State& state, Scratch& scratch, SolveGroup& group,
                      const ContactStiffness& stiffness) {
  group.stiffness = stiffness;
  color_contacts(scratch, group);
  place_batches(scratch, group, model.contact_features);
  for (std::uint32_t i = group.first_run; i < group.run_end; ++i) {
    const BatchRun& run = scratch.contact_batches.runs[i];
    scratch.parallel.for_chunks(run.end - run.first, run.chunk_size, [&](const Chunk& chunk) {
      const std::size_t first = run.first + chunk.begin;
      const std::size_t end = run.first + chunk.end;
      fill_batches(model, state, scratch, group, first, end, unread_record(scratch, chunk.index));
      scratch.kernels->contacts.prepare(work_of(scratch, group, first, end));
    });
  }
}

void warm_start_contacts(Scratch& scratch, const SolveGroup& group) {
  for_colors(scratch, group, scratch.kernels->contacts.warm_start);
}

void solve_contacts(Scratch& scratch, const SolveGroup& group, Poses poses) {
  const ContactKernels& kernels = scratch.kernels->contacts;
  for_colors(scratch, group, poses == Poses::moved ? kernels.solve : kernels.solve_again);
}

void relax_contacts(Scratch& scratch, const SolveGroup& group) {
  for_colors(scratch, group, scratch.kernels->contacts.relax);
}

bool bounce_contacts(Scratch& scratch, const SolveGroup& group, Real threshold) {
  std::atomic<bool> any{false};
  for_colors(scratch, group, [&](const ContactWork& work) {
    if (scratch.kernels->contacts.bounce(work, threshold)) any.store(true, std::memory_order_relaxed);
  });
  return any.load(std::memory_order_relaxed);
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
      const ContactLanes& saved = out.saved[next++];
      for (int lane = 0; lane < contact_lane_count; ++lane) {
        point.normal_impulse.at[lane] = smaller(point.normal_impulse.at[lane], saved.at[lane]);
        const Real limit = out.batches[i].friction.at[lane] * point.normal_impulse.at[lane];
        point.tangent_impulse.at[lane] = larger(smaller(point.tangent_impulse.at[lane], limit), -limit);
      }
    }
}

void store_contacts(const Scratch& scratch, const SolveGroup& group, State& state) {
  const Real inv_h = 1 / group.h;
  const std::size_t count = group.batch_end - group.first_batch;
  scratch.parallel.for_chunks(
      count, scratch.parallel.chunk_size(count, batches_per_chunk_least, 1), [&](const Chunk& chunk) {
        for (std::size_t i = group.first_batch + chunk.begin; i < group.first_batch + chunk.end; ++i) {
          const ContactBatch& batch = scratch.contact_batches.batches[i];
          for (int lane = 0; lane < batch.count; ++lane) {
            ContactRow& row = state.contacts[batch.contact[lane]];
            for (int p = 0; p < 2; ++p) {
              row.normal_force[p] = inv_h * batch.points[p].normal_impulse.at[lane];
              row.tangent_force[p] = inv_h * batch.points[p].tangent_impulse.at[lane];
            }
          }
        }
      });
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
