// Packing of pins, and the passes over them.
// SPDX-License-Identifier: MIT
#include "engine/joints/batched/pin_batch.h"

#include "engine/joints/batched/weave.h"
#include "engine/model/bodies.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

PinWork work_of(Scratch& scratch, std::size_t first, std::size_t last, Real h, std::size_t line) {
  return {scratch.pins.batches.data() + first,
          scratch.pins.arms.data() + line * scratch.caches.joints.pins.size() + first,
          last - first,
          &scratch.bodies.data()->velocity.x,
          h,
          scratch.pins.soft};
}

}  // namespace

void ask_early(const State& state, const Scratch& scratch, std::size_t place) {
  constexpr std::size_t joints_ahead = 12;
  if (place + joints_ahead >= scratch.caches.joints.places.size()) return;
  __builtin_prefetch(&state.joints[scratch.caches.joints.places[place + joints_ahead].row].linear_force);
}

void empty_pins(const Scratch& scratch, PinBatch& batch) {
  batch = {};
  const std::uint32_t resting = resting_record(scratch);
  const std::uint32_t unread = unread_record(scratch);
  for (int lane = 0; lane < lane_count; ++lane) {
    batch.read_a[lane] = batch.read_b[lane] = resting;
    batch.write_a[lane] = batch.write_b[lane] = unread;
  }
}

void write_elsewhere(const Scratch& scratch, PinBatch& batch, std::size_t chunk) {
  const std::uint32_t unread = unread_record(scratch);
  for (int lane = 0; lane < lane_count; ++lane) {
    if (batch.write_a[lane] == unread) batch.write_a[lane] = unread_record(scratch, chunk);
    if (batch.write_b[lane] == unread) batch.write_b[lane] = unread_record(scratch, chunk);
  }
}

void fill_pin_lane(PinBatch& batch, std::size_t lane, std::uint32_t row, const BodyMass& a, const BodyMass& b,
                   Vec2 anchor_a, Vec2 anchor_b, Vec2 apart, Vec2 impulse) {
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
  batch.apart_x.at[lane] = apart.x;
  batch.apart_y.at[lane] = apart.y;
  batch.impulse_x.at[lane] = impulse.x;
  batch.impulse_y.at[lane] = impulse.y;
  batch.row[lane] = row;
}

namespace {

void fill_lane(const State& state, const Scratch& scratch, const JointPlace& place, PinBatch& batch, std::size_t lane,
               Real h) {
  const JointRow& row = state.joints[place.row];
  const BodyRow& b = state.bodies[place.body_b];
  const BodyMass& mass_b = scratch.masses[place.body_b];
  BodyMass mass_a{0, 0, resting_record(scratch), unread_record(scratch)};
  Vec2 anchor_a{0, 0};
  Vec2 apart = b.position - place.anchor_a;  // held to the world: from the point
  if (place.body_a != no_reference) {
    const BodyRow& a = state.bodies[place.body_a];
    mass_a = scratch.masses[place.body_a];
    anchor_a = rotate(a.rotation, place.anchor_a);
    apart = b.position - a.position;
  }
  const Vec2 anchor_b = rotate(b.rotation, place.anchor_b);
  fill_pin_lane(batch, lane, place.row, mass_a, mass_b, anchor_a, anchor_b, apart, h * row.linear_force);
}

}  // namespace

void make_room_for_pins(Scratch& scratch) {
  PinBatches& pins = scratch.pins;
  const std::size_t count = scratch.caches.joints.pins.size();
  if (pins.batches.size() < count) pins.batches.resize(count);
  const std::size_t arms_count = count * (scratch.is_woven ? woven_line_count(scratch) : 1);
  if (pins.arms.size() < arms_count) pins.arms.resize(arms_count);
}

void fill_pins(const State& state, Scratch& scratch, std::size_t first, std::size_t last, Real h) {
  for (std::size_t i = first; i < last; ++i) {
    const JointSpan& span = scratch.caches.joints.pins[i];
    PinBatch& batch = scratch.pins.batches[i];
    if (span.count < lane_count) empty_pins(scratch, batch);
    batch.count = static_cast<std::int32_t>(span.count);
    for (std::uint32_t lane = 0; lane < span.count; ++lane) {
      ask_early(state, scratch, span.first + lane);
      fill_lane(state, scratch, scratch.caches.joints.places[span.first + lane], batch, lane, h);
    }
    if (scratch.is_woven) write_elsewhere(scratch, batch, span.level);
  }
}

std::size_t share_pins(Scratch& scratch, std::uint32_t first, std::uint32_t last) {
  const std::size_t count = last - first;
  if (scratch.pins.order == PinOrder::row) return count;
  const std::size_t size = scratch.parallel.chunk_size(count, joint_batches_per_chunk_least, 1);
  for (std::size_t i = size; i < count; ++i)  // the first chunk has its record already
    write_elsewhere(scratch, scratch.pins.batches[first + i], i / size);
  return size;
}

void warm_start_pins(Scratch& scratch, const JointRange& range, Poses poses, std::size_t line) {
  const PinKernels& kernels = scratch.kernels->pins;
  const auto in_levels = poses == Poses::moved ? kernels.warm_start : kernels.warm_start_again;
  const auto kernel = scratch.pins.order == PinOrder::row ? kernels.warm_start_row : in_levels;
  scratch.parallel.for_chunks(range.last - range.first, range.chunk_size, [&](const Chunk& chunk) {
    kernel(work_of(scratch, range.first + chunk.begin, range.first + chunk.end, Real(1), line));
  });
}

void solve_pins(Scratch& scratch, const JointRange& range, Real h, Bias bias, std::size_t line) {
  const PinKernels& kernels = scratch.kernels->pins;
  const bool in_row = scratch.pins.order == PinOrder::row;
  const auto solve = in_row ? kernels.solve_row : kernels.solve;
  const auto relax = in_row ? kernels.relax_row : kernels.relax;
  const auto kernel = bias == Bias::on ? solve : relax;
  scratch.parallel.for_chunks(range.last - range.first, range.chunk_size, [&](const Chunk& chunk) {
    kernel(work_of(scratch, range.first + chunk.begin, range.first + chunk.end, h, line));
  });
}

void store_pins(const Scratch& scratch, State& state, std::size_t first, std::size_t last, Real h) {
  const Real inv_h = 1 / h;
  for (std::size_t i = first; i < last; ++i) {
    const PinBatch& batch = scratch.pins.batches[i];
    for (std::int32_t lane = 0; lane < batch.count; ++lane)
      state.joints[batch.row[lane]].linear_force =
          stored(inv_h * Vec2{batch.impulse_x.at[lane], batch.impulse_y.at[lane]});
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
