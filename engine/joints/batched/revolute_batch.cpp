// Packing of plain revolute joints into batches, and the passes over the batches.
// SPDX-License-Identifier: MIT
#include "engine/joints/batched/revolute_batch.h"

#include "engine/joints/batched/wavefront.h"
#include "engine/joints/joint_passes.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

RevoluteWork work_of(const SolvedSet& solved, JointWorkspace& work, std::size_t first, std::size_t last, Real h,
                     std::size_t front) {
  return {work.revolutes.batches.data() + first,
          work.revolutes.arms.data() + front * work.plan.revolutes().size() + first,
          last - first,
          solved.bodies.lanes(),
          h,
          work.revolutes.soft};
}

}  // namespace

void prefetch_joint(const State& state, std::span<const JointPlace> places, std::size_t place) {
  constexpr std::size_t prefetch_distance = 12;
  if (place + prefetch_distance >= places.size()) return;
  __builtin_prefetch(&state.joints[places[place + prefetch_distance].row].linear_force);
}

void clear_revolutes(const SolverBodies& bodies, RevoluteBatch& batch) {
  batch = {};
  const std::uint32_t dummy = dummy_body(bodies);
  const std::uint32_t sink = dummy_sink(bodies);
  for (int lane = 0; lane < lane_count; ++lane) {
    batch.read_a[lane] = batch.read_b[lane] = dummy;
    batch.write_a[lane] = batch.write_b[lane] = sink;
  }
}

void redirect_to_sink(const SolverBodies& bodies, RevoluteBatch& batch, std::size_t chunk) {
  const std::uint32_t sink = dummy_sink(bodies);
  for (int lane = 0; lane < lane_count; ++lane) {
    if (batch.write_a[lane] == sink) batch.write_a[lane] = dummy_sink(bodies, chunk);
    if (batch.write_b[lane] == sink) batch.write_b[lane] = dummy_sink(bodies, chunk);
  }
}

void fill_revolute_lane(RevoluteBatch& batch, std::size_t lane, std::uint32_t row, const BodyMass& a, const BodyMass& b,
                        Vec2 anchor_a, Vec2 anchor_b, Vec2 center_offset, Vec2 impulse) {
  batch.read_a[lane] = a.read;
  batch.read_b[lane] = b.read;
  batch.write_a[lane] = a.write;
  batch.write_b[lane] = b.write;
  batch.inv_mass_a.at[lane] = a.inv_mass;
  batch.inv_mass_b.at[lane] = b.inv_mass;
  batch.inv_inertia_a.at[lane] = a.inv_inertia;
  batch.inv_inertia_b.at[lane] = b.inv_inertia;
  batch.anchor_a_x.at[lane] = anchor_a.x;
  batch.anchor_a_y.at[lane] = anchor_a.y;
  batch.anchor_b_x.at[lane] = anchor_b.x;
  batch.anchor_b_y.at[lane] = anchor_b.y;
  batch.center_offset_x.at[lane] = center_offset.x;
  batch.center_offset_y.at[lane] = center_offset.y;
  batch.impulse_x.at[lane] = impulse.x;
  batch.impulse_y.at[lane] = impulse.y;
  batch.row[lane] = row;
}

namespace {

void fill_lane(const SolvedSet& solved, const JointPlace& place, RevoluteBatch& batch, std::size_t lane) {
  const State& state = solved.state;
  const SolverBodies& bodies = solved.bodies;
  const JointRow& row = state.joints[place.row];
  const BodyRow& b = state.bodies[place.body_b];
  const BodyMass& mass_b = bodies.masses[place.body_b];
  BodyMass mass_a{0, 0, dummy_body(bodies), dummy_sink(bodies)};
  Vec2 anchor_a{0, 0};
  Vec2 center_offset = b.position - place.anchor_a;  // without body A: from the point of the world
  if (place.body_a != no_reference) {
    const BodyRow& a = state.bodies[place.body_a];
    mass_a = bodies.masses[place.body_a];
    anchor_a = rotate(a.rotation, place.anchor_a);
    center_offset = b.position - a.position;
  }
  const Vec2 anchor_b = rotate(b.rotation, place.anchor_b);
  fill_revolute_lane(batch, lane, place.row, mass_a, mass_b, anchor_a, anchor_b, center_offset,
                     solved.set.h * row.linear_force);
}

}  // namespace

void reserve_revolutes(const SolvedSet& solved, JointWorkspace& work) {
  RevoluteBatches& revolutes = work.revolutes;
  const std::size_t count = work.plan.revolutes().size();
  if (revolutes.batches.size() < count) revolutes.batches.resize(count);
  const std::size_t arms_count = count * (work.uses_wavefront ? front_count(solved.parallel()) : 1);
  if (revolutes.arms.size() < arms_count) revolutes.arms.resize(arms_count);
}

void fill_revolutes(const SolvedSet& solved, JointWorkspace& work, std::size_t first, std::size_t last) {
  const std::span<const JointPlace> places = work.plan.places();
  for (std::size_t i = first; i < last; ++i) {
    const JointSpan& span = work.plan.revolutes()[i];
    RevoluteBatch& batch = work.revolutes.batches[i];
    if (span.count < lane_count) clear_revolutes(solved.bodies, batch);
    batch.count = static_cast<std::int32_t>(span.count);
    for (std::uint32_t lane = 0; lane < span.count; ++lane) {
      prefetch_joint(solved.state, places, span.first + lane);
      fill_lane(solved, places[span.first + lane], batch, lane);
    }
    if (work.uses_wavefront) redirect_to_sink(solved.bodies, batch, span.level);
  }
}

std::size_t chunk_size_of(const JointWorkspace& work, const JointRange& range) {
  return work.uses_wavefront ? range.last - range.first : range.chunk_size;
}

void separate_revolute_sinks(const SolverBodies& bodies, const JointRange& range, RevoluteBatches& revolutes) {
  // The first chunk writes to the sink that the batches already have.
  for (std::size_t i = range.chunk_size; i < range.last - range.first; ++i)
    redirect_to_sink(bodies, revolutes.batches[range.first + i], i / range.chunk_size);
}

void warm_start_revolutes(const SolvedSet& solved, JointWorkspace& work, const JointRange& range, Poses poses,
                          std::size_t front) {
  const RevoluteKernels& kernels = solved.kernels().revolutes;
  const auto in_levels = poses == Poses::moved ? kernels.warm_start : kernels.warm_start_again;
  const auto kernel = work.revolutes.order == RevoluteOrder::serial ? kernels.warm_start_serial : in_levels;
  solved.parallel().for_chunks(range.last - range.first, chunk_size_of(work, range), [&](const Chunk& chunk) {
    kernel(work_of(solved, work, range.first + chunk.begin, range.first + chunk.end, Real(1), front));
  });
}

void solve_revolutes(const SolvedSet& solved, JointWorkspace& work, const JointRange& range, Bias bias,
                     std::size_t front) {
  const RevoluteKernels& kernels = solved.kernels().revolutes;
  const bool is_serial = work.revolutes.order == RevoluteOrder::serial;
  const auto solve = is_serial ? kernels.solve_serial : kernels.solve;
  const auto relax = is_serial ? kernels.relax_serial : kernels.relax;
  const auto kernel = corrects(bias) ? solve : relax;
  solved.parallel().for_chunks(range.last - range.first, chunk_size_of(work, range), [&](const Chunk& chunk) {
    kernel(work_of(solved, work, range.first + chunk.begin, range.first + chunk.end, solved.set.h, front));
  });
}

void store_revolutes(const RevoluteBatches& revolutes, std::size_t first, std::size_t last, Real h, State& state) {
  const Real inv_h = 1 / h;
  for (std::size_t i = first; i < last; ++i) {
    const RevoluteBatch& batch = revolutes.batches[i];
    for (std::int32_t lane = 0; lane < batch.count; ++lane)
      state.joints[batch.row[lane]].linear_force =
          stored(inv_h * Vec2{batch.impulse_x.at[lane], batch.impulse_y.at[lane]});
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
