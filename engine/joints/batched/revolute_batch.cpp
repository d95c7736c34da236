// Packing of plain revolute joints into batches, and the passes over the batches.
// SPDX-License-Identifier: MIT
#include "engine/joints/batched/revolute_batch.h"

#include "engine/joints/batched/wavefront.h"
#include "engine/model/bodies.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

RevoluteWork work_of(Scratch& scratch, std::size_t first, std::size_t last, Real h, std::size_t front) {
  return {scratch.revolutes.batches.data() + first,
          scratch.revolutes.arms.data() + front * scratch.caches.joints.revolutes().size() + first,
          last - first,
          &scratch.bodies.data()->velocity.x,
          h,
          scratch.revolutes.soft};
}

}  // namespace

void prefetch_joint(const State& state, const Scratch& scratch, std::size_t place) {
  constexpr std::size_t prefetch_distance = 12;
  if (place + prefetch_distance >= scratch.caches.joints.places().size()) return;
  __builtin_prefetch(&state.joints[scratch.caches.joints.places()[place + prefetch_distance].row].linear_force);
}

void clear_revolutes(const Scratch& scratch, RevoluteBatch& batch) {
  batch = {};
  const std::uint32_t dummy = dummy_body(scratch);
  const std::uint32_t sink = dummy_sink(scratch);
  for (int lane = 0; lane < lane_count; ++lane) {
    batch.read_a[lane] = batch.read_b[lane] = dummy;
    batch.write_a[lane] = batch.write_b[lane] = sink;
  }
}

void redirect_to_sink(const Scratch& scratch, RevoluteBatch& batch, std::size_t chunk) {
  const std::uint32_t sink = dummy_sink(scratch);
  for (int lane = 0; lane < lane_count; ++lane) {
    if (batch.write_a[lane] == sink) batch.write_a[lane] = dummy_sink(scratch, chunk);
    if (batch.write_b[lane] == sink) batch.write_b[lane] = dummy_sink(scratch, chunk);
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

void fill_lane(const State& state, const Scratch& scratch, const JointPlace& place, RevoluteBatch& batch,
               std::size_t lane, Real h) {
  const JointRow& row = state.joints[place.row];
  const BodyRow& b = state.bodies[place.body_b];
  const BodyMass& mass_b = scratch.masses[place.body_b];
  BodyMass mass_a{0, 0, dummy_body(scratch), dummy_sink(scratch)};
  Vec2 anchor_a{0, 0};
  Vec2 center_offset = b.position - place.anchor_a;  // without body A: from the point of the world
  if (place.body_a != no_reference) {
    const BodyRow& a = state.bodies[place.body_a];
    mass_a = scratch.masses[place.body_a];
    anchor_a = rotate(a.rotation, place.anchor_a);
    center_offset = b.position - a.position;
  }
  const Vec2 anchor_b = rotate(b.rotation, place.anchor_b);
  fill_revolute_lane(batch, lane, place.row, mass_a, mass_b, anchor_a, anchor_b, center_offset, h * row.linear_force);
}

}  // namespace

void reserve_revolutes(Scratch& scratch) {
  RevoluteBatches& revolutes = scratch.revolutes;
  const std::size_t count = scratch.caches.joints.revolutes().size();
  if (revolutes.batches.size() < count) revolutes.batches.resize(count);
  const std::size_t arms_count = count * (scratch.uses_wavefront ? front_count(scratch) : 1);
  if (revolutes.arms.size() < arms_count) revolutes.arms.resize(arms_count);
}

void fill_revolutes(const State& state, Scratch& scratch, std::size_t first, std::size_t last, Real h) {
  for (std::size_t i = first; i < last; ++i) {
    const JointSpan& span = scratch.caches.joints.revolutes()[i];
    RevoluteBatch& batch = scratch.revolutes.batches[i];
    if (span.count < lane_count) clear_revolutes(scratch, batch);
    batch.count = static_cast<std::int32_t>(span.count);
    for (std::uint32_t lane = 0; lane < span.count; ++lane) {
      prefetch_joint(state, scratch, span.first + lane);
      fill_lane(state, scratch, scratch.caches.joints.places()[span.first + lane], batch, lane, h);
    }
    if (scratch.uses_wavefront) redirect_to_sink(scratch, batch, span.level);
  }
}

std::size_t chunk_size_of(const Scratch& scratch, const JointRange& range) {
  return scratch.uses_wavefront ? range.last - range.first : range.chunk_size;
}

void separate_revolute_sinks(Scratch& scratch, const JointRange& range) {
  // The first chunk writes to the sink that the batches have already.
  for (std::size_t i = range.chunk_size; i < range.last - range.first; ++i)
    redirect_to_sink(scratch, scratch.revolutes.batches[range.first + i], i / range.chunk_size);
}

void warm_start_revolutes(Scratch& scratch, const JointRange& range, Poses poses, std::size_t front) {
  const RevoluteKernels& kernels = scratch.kernels->revolutes;
  const auto in_levels = poses == Poses::moved ? kernels.warm_start : kernels.warm_start_again;
  const auto kernel = scratch.revolutes.order == RevoluteOrder::serial ? kernels.warm_start_serial : in_levels;
  scratch.parallel.for_chunks(range.last - range.first, chunk_size_of(scratch, range), [&](const Chunk& chunk) {
    kernel(work_of(scratch, range.first + chunk.begin, range.first + chunk.end, Real(1), front));
  });
}

void solve_revolutes(Scratch& scratch, const JointRange& range, Real h, Bias bias, std::size_t front) {
  const RevoluteKernels& kernels = scratch.kernels->revolutes;
  const bool is_serial = scratch.revolutes.order == RevoluteOrder::serial;
  const auto solve = is_serial ? kernels.solve_serial : kernels.solve;
  const auto relax = is_serial ? kernels.relax_serial : kernels.relax;
  const auto kernel = bias == Bias::on ? solve : relax;
  scratch.parallel.for_chunks(range.last - range.first, chunk_size_of(scratch, range), [&](const Chunk& chunk) {
    kernel(work_of(scratch, range.first + chunk.begin, range.first + chunk.end, h, front));
  });
}

void store_revolutes(const Scratch& scratch, State& state, std::size_t first, std::size_t last, Real h) {
  const Real inv_h = 1 / h;
  for (std::size_t i = first; i < last; ++i) {
    const RevoluteBatch& batch = scratch.revolutes.batches[i];
    for (std::int32_t lane = 0; lane < batch.count; ++lane)
      state.joints[batch.row[lane]].linear_force =
          stored(inv_h * Vec2{batch.impulse_x.at[lane], batch.impulse_y.at[lane]});
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
