// Packing of contacts into batches, and impulses kept from tick to tick.
// SPDX-License-Identifier: MIT
#include "engine/contacts/contact_batch.h"

#include <algorithm>
#include <atomic>
#include <cstddef>

#include "engine/contacts/crowds.h"
#include "engine/model/bodies.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// The least number of batches per chunk for which a second thread pays.
constexpr std::size_t batches_per_chunk_least = 8;

/// Adds the batches of a colour to the runs, or to the last run if one thread solves both.
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

/// Allocates the batches.
void reserve_batches(ContactBatches& out, unsigned features) {
  const std::size_t end = out.batch_count;
  if (out.batches.size() < end) out.batches.resize(end);
  if ((features & contact_feature::bounce) != 0 && out.bounces.size() < end) out.bounces.resize(end);
  if ((features & contact_feature::surface) != 0 && out.surfaces.size() < end) out.surfaces.resize(end);
}

/// The contacts in the slots of a block.
const std::uint32_t* slots_of(const SolvedSet& solved, const ContactColors& colors, const ContactBlock& block,
                              ContactBatches& out) {
  const std::uint32_t* slots = colors.slots().data() + block.first_slot;
  if (colors.are_all()) return slots;
  const std::size_t count = block.slot_end - block.first_slot;
  const std::span<const std::uint32_t> contacts = solved.contacts();
  out.slots.resize(count);
  for (std::size_t i = 0; i < count; ++i) out.slots[i] = slots[i] != no_contact ? contacts[slots[i]] : no_contact;
  return out.slots.data();
}

void fill_surface(const SolvedSet& solved, SurfaceLanes& out, std::uint32_t lane, const ContactPair& pair) {
  const ShapeModel& a = solved.model.shapes[solved.tick.proxies[pair.proxy_a].shape];
  const ShapeModel& b = solved.model.shapes[solved.tick.proxies[pair.proxy_b].shape];
  const Real inv_inertia =
      solved.bodies.masses[pair.body_a].inv_inertia + solved.bodies.masses[pair.body_b].inv_inertia;
  out.tangent_speed.at[lane] = a.tangent_speed + b.tangent_speed;
  out.rolling_resistance.at[lane] = larger(a.rolling_resistance, b.rolling_resistance);
  out.rolling_mass.at[lane] = inv_inertia > 0 ? 1 / inv_inertia : Real(0);
}

/// The arguments of a kernel for the batches first..end-1.
ContactWork work_of(const SolvedSet& solved, ContactBatches& all, std::size_t first, std::size_t end) {
  return {all.batches.data() + first,
          end - first,
          all.surfaces.empty() ? nullptr : all.surfaces.data() + first,
          all.bounces.empty() ? nullptr : all.bounces.data() + first,
          solved.bodies.lanes(),
          solved.set.h,
          solved.set.stiffness.moving,
          solved.set.stiffness.immovable};
}

/// Runs a kernel over the batches of a set, colour by colour.
template <typename Kernel>
void for_colors(const SolvedSet& solved, ContactBatches& batches, Kernel kernel) {
  for (std::uint32_t i = solved.set.first_run; i < solved.set.run_end; ++i) {
    const BatchRun& run = batches.runs[i];
    solved.parallel().for_chunks(run.end - run.first, run.chunk_size, [&](const Chunk& chunk) {
      kernel(work_of(solved, batches, run.first + chunk.begin, run.first + chunk.end));
    });
  }
}

// The layout on which kernels rely.
static_assert(offsetof(ContactPair, body_b) == offsetof(ContactPair, body_a) + sizeof(std::uint32_t));
static_assert(offsetof(ContactPair, size) == offsetof(ContactPair, friction) + 3 * sizeof(Real));
static_assert(offsetof(Manifold, point_count) == 2 * sizeof(Real));
static_assert(offsetof(ContactPair, restitution) - offsetof(ContactPair, manifold.points[1].separation) >=
              4 * sizeof(Real));
static_assert(offsetof(ManifoldPoint, anchor_b) == offsetof(ManifoldPoint, anchor_a) + sizeof(Vec2));
static_assert(offsetof(ContactRow, tangent_force) == offsetof(ContactRow, normal_force) + 2 * sizeof(Real));
static_assert(offsetof(BodyMass, inv_inertia) == sizeof(Real) && sizeof(BodyMass) == 4 * sizeof(Real));
static_assert(offsetof(BodyMass, write) == offsetof(BodyMass, read) + sizeof(std::uint32_t));

/// The sources from which a kernel fills batches.
ContactSource source_of(const SolvedSet& solved, const std::uint32_t* slots, const std::uint8_t* is_serial,
                        std::uint32_t sink) {
  const ContactPair& pair = solved.tick.contact_pairs[0];
  const ManifoldPoint(&points)[2] = pair.manifold.points;
  return {slots,
          is_serial,
          sizeof(ContactPair),
          &pair.body_a,
          &pair.friction,
          &pair.manifold.normal.x,
          {&points[0].anchor_a.x, &points[1].anchor_a.x},
          {&points[0].separation, &points[1].separation},
          &pair.manifold.point_count,
          sizeof(ContactRow),
          solved.state.contacts[0].normal_force,
          sizeof(BodyMass),
          &solved.bodies.masses[0].inv_mass,
          &solved.bodies.masses[0].read,
          dummy_sink(solved.bodies),
          sink,
          dummy_body(solved.bodies),
          solved.set.stiffness.slop};
}

/// Fills the lanes of restitution and surfaces, where the scene has them.
void fill_extras(const SolvedSet& solved, ContactBatches& out, std::size_t i) {
  const bool bounces = (solved.model.contact_features & contact_feature::bounce) != 0;
  const bool has_surfaces = (solved.model.contact_features & contact_feature::surface) != 0;
  ContactBatch& batch = out.batches[i];
  if (bounces) out.bounces[i] = {};
  if (has_surfaces) out.surfaces[i] = {};
  for (std::uint32_t lane = 0; lane < static_cast<std::uint32_t>(batch.count); ++lane) {
    const ContactPair& pair = solved.tick.contact_pairs[batch.contact[lane]];
    if (bounces) out.bounces[i].restitution.at[lane] = pair.restitution;
    batch.bounces |= pair.restitution > 0 ? 1 : 0;
    if (has_surfaces) fill_surface(solved, out.surfaces[i], lane, pair);
  }
}

/// Fills and prepares the batches first..end-1 from the contacts in `slots`. `is_serial`: [batch].
void make_batches(const SolvedSet& solved, const std::uint32_t* slots, const std::uint8_t* is_serial,
                  ContactBatches& out, std::size_t first, std::size_t end, std::uint32_t sink) {
  if (first == end) return;
  constexpr std::size_t group_size = 8;  // batches: points stay in the nearest cache until they are prepared
  FoundPoints found[group_size];
  const bool has_extras = (solved.model.contact_features & (contact_feature::bounce | contact_feature::surface)) != 0;
  ContactSource source = source_of(solved, slots, is_serial, sink);
  for (std::size_t i = first; i < end; i += group_size) {
    const std::size_t count = end - i < group_size ? end - i : group_size;
    solved.kernels().filling.fill(source, out.batches.data() + i, found, count, end - i);
    if (has_extras)
      for (std::size_t k = i; k < i + count; ++k) fill_extras(solved, out, k);
    solved.kernels().contacts.prepare(work_of(solved, out, i, i + count), found);
    source.slots += count * contact_lane_count;
    source.is_serial += count;
  }
}

/// Stores the impulses of the batches first..end-1 in the contacts, as forces.
void store_batches(const SolvedSet& solved, const ContactBatches& batches, std::size_t first, std::size_t end,
                   State& state) {
  if (first == end) return;
  solved.kernels().filling.store(batches.batches.data() + first, end - first, state.contacts[0].normal_force,
                                 sizeof(ContactRow), 1 / solved.set.h);
}

/// Calls use(pushing) for the batches of a list, colour by colour.
template <typename Use>
void for_listed(const SolvedSet& solved, const ContactBatches& batches, std::vector<PushingBatch>& list,
                const Use& use) {
  if (list.empty()) return;
  for (std::uint32_t i = solved.set.first_run; i < solved.set.run_end; ++i) {
    const BatchRun& run = batches.runs[i];
    solved.parallel().for_chunks(run.end - run.first, run.chunk_size, [&](const Chunk& chunk) {
      const auto is_before = [](const PushingBatch& of, std::size_t batch) { return of.batch < batch; };
      auto at = std::lower_bound(list.begin(), list.end(), run.first + chunk.begin, is_before);
      for (; at != list.end() && at->batch < run.first + chunk.end; ++at) use(*at);
    });
  }
}

/// Lists the batches of a set with contacts of crowds.
void find_crowded(const SolvedSet& solved, ContactBatches& out) {
  out.pushing.clear();
  if (solved.tick.deep_counts.empty()) return;
  for (std::uint32_t i = solved.set.first_batch; i < solved.set.batch_end; ++i) {
    PushingBatch pushing{i, 0, {}, {}};
    for (int lane = 0; lane < out.batches[i].count; ++lane)
      if (is_crowded(solved.tick, out.batches[i].contact[lane])) pushing.lanes |= 1u << lane;
    if (pushing.lanes != 0) out.pushing.push_back(pushing);
  }
}

/// The impulses of the lanes become those of before the push. The others stay.
void take_back(const SolvedSet& solved, ContactBatches& batches, PushingBatch& pushing) {
  ContactBatch& batch = batches.batches[pushing.batch];
  const auto for_each_lane = [&](auto use) {
    for (int point = 0; point < 2; ++point)
      for (int lane = 0; lane < contact_lane_count; ++lane) {
        const bool is_taken_back = (pushing.lanes >> lane & 1) != 0;
        use(is_taken_back, batch.points[point].normal_impulse.at[lane], pushing.normal[point].at[lane]);
        use(is_taken_back, batch.points[point].tangent_impulse.at[lane], pushing.tangent[point].at[lane]);
      }
  };
  for_each_lane([](bool is_taken_back, Real& impulse, Real& after) {
    const Real change = is_taken_back ? after - impulse : Real(0);
    after = is_taken_back ? after : impulse;
    impulse = change;
  });
  solved.kernels().contacts.warm_start(work_of(solved, batches, pushing.batch, pushing.batch + 1));
  for_each_lane([](bool, Real& impulse, Real& after) { impulse = after; });
}

}  // namespace

void clear_contacts(ContactBatches& batches) {
  batches.batch_count = 0;
  batches.runs.clear();
}

void color_contacts(const SolvedSet& solved, bool may_split, ContactWorkspace& work) {
  const ContactsOfSet contacts{solved.tick.contact_pairs, solved.contacts(), solved.bodies.masses,
                               dummy_sink(solved.bodies), solved.tick.contact_generation};
  color_contacts(contacts, solved.all_rows(), may_split, solved.parallel(), work.colors, work.blocks, work.coloring);
}

void prepare_contacts(const SolvedSet& solved, const ContactColors& colors, ContactBatches& out) {
  SolverSet& set = solved.set;
  set.first_batch = static_cast<std::uint32_t>(out.batch_count);
  set.first_run = static_cast<std::uint32_t>(out.runs.size());
  for (const BatchRange& color : colors.color_batches())
    add_run(solved.parallel(), out.runs, out.runs.size() == set.first_run, set.first_batch + color.first,
            set.first_batch + color.end);
  set.run_end = static_cast<std::uint32_t>(out.runs.size());
  out.batch_count += colors.slots().size() / contact_lane_count;
  set.batch_end = static_cast<std::uint32_t>(out.batch_count);
  reserve_batches(out, solved.model.contact_features);
  const std::uint32_t* slots = slots_of(solved, colors, colors.blocks()[0], out);
  for (std::uint32_t i = set.first_run; i < set.run_end; ++i) {
    const BatchRun& run = out.runs[i];
    solved.parallel().for_chunks(run.end - run.first, run.chunk_size, [&](const Chunk& chunk) {
      const std::size_t first = run.first + chunk.begin;
      const std::size_t end = run.first + chunk.end;
      const std::size_t of_set = first - set.first_batch;
      make_batches(solved, slots + of_set * contact_lane_count, colors.is_serial() + of_set, out, first, end,
                   dummy_sink(solved.bodies, chunk.index));
    });
  }
  find_crowded(solved, out);
}

void warm_start_contacts(const SolvedSet& solved, ContactBatches& batches) {
  for_colors(solved, batches, solved.kernels().contacts.warm_start);
}

void solve_contacts(const SolvedSet& solved, ContactBatches& batches) {
  for_colors(solved, batches, solved.kernels().contacts.solve);
}

void take_push_back_of(ContactBatches& batches, std::uint32_t batch, std::uint32_t lane) {
  std::vector<PushingBatch>& pushing = batches.pushing;
  const auto is_before = [](const PushingBatch& of, std::uint32_t number) { return of.batch < number; };
  auto at = std::lower_bound(pushing.begin(), pushing.end(), batch, is_before);
  if (at == pushing.end() || at->batch != batch) at = pushing.insert(at, PushingBatch{batch, 0, {}, {}});
  at->lanes |= 1u << lane;
}

void save_before_push(ContactBatches& out) {
  for (std::vector<PushingBatch>* list : {&out.pushing, &out.jointed})
    for (PushingBatch& pushing : *list)
      for (int point = 0; point < 2; ++point) {
        pushing.normal[point] = out.batches[pushing.batch].points[point].normal_impulse;
        pushing.tangent[point] = out.batches[pushing.batch].points[point].tangent_impulse;
      }
}

void take_back_pushes(const SolvedSet& solved, ContactBatches& batches) {
  for_listed(solved, batches, batches.pushing, [&](PushingBatch& pushing) { take_back(solved, batches, pushing); });
}

void find_jointed_contacts(const SolvedSet& solved, std::span<const std::uint8_t> is_jointed, ContactBatches& out) {
  out.jointed.clear();
  if (is_jointed.empty()) return;
  for (std::uint32_t i = solved.set.first_batch; i < solved.set.batch_end; ++i) {
    PushingBatch jointed{i, 0, {}, {}};
    for (int lane = 0; lane < out.batches[i].count; ++lane) {
      const ContactPair& pair = solved.tick.contact_pairs[out.batches[i].contact[lane]];
      if (is_jointed[pair.body_a] != 0 || is_jointed[pair.body_b] != 0) jointed.lanes |= 1u << lane;
    }
    if (jointed.lanes != 0) out.jointed.push_back(jointed);
  }
}

void limit_push_friction(const SolvedSet& solved, ContactBatches& batches) {
  for_listed(solved, batches, batches.jointed, [&](const PushingBatch& jointed) {
    const ContactBatch& batch = batches.batches[jointed.batch];
    PushingBatch limited{jointed.batch, jointed.lanes, {}, {}};
    bool any = false;
    for (int point = 0; point < 2; ++point) {
      limited.normal[point] = batch.points[point].normal_impulse;
      for (int lane = 0; lane < contact_lane_count; ++lane) {
        const Real limit = batch.friction.at[lane] * jointed.normal[point].at[lane];
        const Real impulse = batch.points[point].tangent_impulse.at[lane];
        limited.tangent[point].at[lane] = larger(smaller(impulse, limit), -limit);
        any |= (jointed.lanes >> lane & 1) != 0 && limited.tangent[point].at[lane] != impulse;
      }
    }
    if (any) take_back(solved, batches, limited);
  });
}

void relax_contacts(const SolvedSet& solved, ContactBatches& batches) {
  for_colors(solved, batches, solved.kernels().contacts.relax);
}

bool bounce_contacts(const SolvedSet& solved, ContactBatches& batches, Real threshold) {
  std::atomic<bool> any{false};
  for_colors(solved, batches, [&](const ContactWork& work) {
    if (solved.kernels().contacts.bounce(work, threshold)) any.store(true, std::memory_order_relaxed);
  });
  return any.load(std::memory_order_relaxed);
}

void save_impulses(const SolverSet& set, ContactBatches& out) {
  out.saved.clear();
  for (std::uint32_t i = set.first_batch; i < set.batch_end; ++i)
    for (const ContactPointLanes& point : out.batches[i].points) out.saved.push_back(point.normal_impulse);
}

void limit_impulses(const SolverSet& set, ContactBatches& out) {
  std::size_t next = 0;
  for (std::uint32_t i = set.first_batch; i < set.batch_end; ++i)
    for (ContactPointLanes& point : out.batches[i].points) {
      const ContactLanes& saved = out.saved[next++];
      for (int lane = 0; lane < contact_lane_count; ++lane) {
        point.normal_impulse.at[lane] = smaller(point.normal_impulse.at[lane], saved.at[lane]);
        const Real limit = out.batches[i].friction.at[lane] * point.normal_impulse.at[lane];
        point.tangent_impulse.at[lane] = larger(smaller(point.tangent_impulse.at[lane], limit), -limit);
      }
    }
}

void store_contacts(const SolvedSet& solved, const ContactBatches& batches, State& state) {
  const SolverSet& set = solved.set;
  const std::size_t count = set.batch_end - set.first_batch;
  solved.parallel().for_chunks(
      count, solved.parallel().chunk_size(count, batches_per_chunk_least, 1), [&](const Chunk& chunk) {
        store_batches(solved, batches, set.first_batch + chunk.begin, set.first_batch + chunk.end, state);
      });
}

void prepare_block(const SolvedSet& solved, const ContactColors& colors, const ContactBlock& block, std::uint32_t sink,
                   ContactBatches& out) {
  const std::span<const std::uint32_t> contacts = solved.contacts();
  for (std::uint32_t i = block.first; i < block.end; ++i) {  // prefetches the whole block, front to back
    const std::uint32_t contact = contacts[colors.contacts()[i]];
    __builtin_prefetch(&solved.tick.contact_pairs[contact]);
    __builtin_prefetch(&solved.tick.contact_pairs[contact].friction);
    __builtin_prefetch(&solved.state.contacts[contact]);
  }
  out.batch_count = (block.slot_end - block.first_slot) / contact_lane_count;
  reserve_batches(out, solved.model.contact_features);
  make_batches(solved, slots_of(solved, colors, block, out), colors.is_serial() + block.first_slot / contact_lane_count,
               out, 0, out.batch_count, sink);
}

ContactWork work_of_block(const SolvedSet& solved, ContactBatches& batches) {
  return work_of(solved, batches, 0, batches.batch_count);
}

void store_block(const SolvedSet& solved, const ContactBatches& batches, State& state) {
  store_batches(solved, batches, 0, batches.batch_count, state);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
