// Packing of pins, and the passes over them.
// SPDX-License-Identifier: MIT
#include "engine/constraints/pin_batch.h"

#include "engine/constraints/bodies.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

void begin_batch(Scratch& scratch) {
  PinBatches& pins = scratch.pins;
  if (pins.batches.size() == pins.batch_count) {
    pins.batches.emplace_back();
    pins.arms.emplace_back();
  }
  PinBatch& batch = pins.batches[pins.batch_count++];
  batch = {};
  const std::uint32_t resting = resting_record(scratch);
  const std::uint32_t unread = unread_record(scratch);
  for (int lane = 0; lane < lane_count; ++lane) {
    batch.read_a[lane] = batch.read_b[lane] = resting;
    batch.write_a[lane] = batch.write_b[lane] = unread;
  }
}

PinWork work_of(Scratch& scratch, std::uint32_t first, std::uint32_t last, Real h) {
  return {scratch.pins.batches.data() + first,
          scratch.pins.arms.data() + first,
          last - first,
          &scratch.bodies.data()->velocity.x,
          h,
          scratch.pins.soft};
}

}  // namespace

void add_pin(const Model& model, const State& state, Scratch& scratch, const JointPlace& place, bool begins_run,
             Real h) {
  PinBatches& pins = scratch.pins;
  const bool begins_level = pins.order == PinOrder::levels && pins.last_level != place.level;
  if (begins_run || begins_level || pins.batches[pins.batch_count - 1].count == lane_count) begin_batch(scratch);
  pins.last_level = place.level;
  PinBatch& batch = pins.batches[pins.batch_count - 1];
  const auto lane = static_cast<std::size_t>(batch.count++);
  const JointRow& row = state.joints[place.row];
  const JointModel& joint = model.joints[place.joint];
  const BodyRow& b = state.bodies[place.body_b];
  const BodyMass& mass_b = scratch.masses[place.body_b];
  BodyMass mass_a{0, 0, resting_record(scratch), unread_record(scratch)};
  Vec2 anchor_a{0, 0};
  Vec2 apart = b.position - joint.anchor_a;  // held to the world: from the point
  if (place.body_a != no_reference) {
    const BodyRow& a = state.bodies[place.body_a];
    mass_a = scratch.masses[place.body_a];
    anchor_a = rotate(a.rotation, joint.anchor_a);
    apart = b.position - a.position;
  }
  const Vec2 anchor_b = rotate(b.rotation, joint.anchor_b);
  batch.read_a[lane] = mass_a.read;
  batch.read_b[lane] = mass_b.read;
  batch.write_a[lane] = mass_a.write;
  batch.write_b[lane] = mass_b.write;
  batch.inv_mass_a.at[lane] = mass_a.inv_mass;
  batch.inv_mass_b.at[lane] = mass_b.inv_mass;
  batch.inv_inertia_a.at[lane] = mass_a.inv_inertia;
  batch.inv_inertia_b.at[lane] = mass_b.inv_inertia;
  batch.anchor_a_x.at[lane] = anchor_a.x;
  batch.anchor_a_y.at[lane] = anchor_a.y;
  batch.anchor_b_x.at[lane] = anchor_b.x;
  batch.anchor_b_y.at[lane] = anchor_b.y;
  batch.apart_x.at[lane] = apart.x;
  batch.apart_y.at[lane] = apart.y;
  batch.impulse_x.at[lane] = h * row.linear_force.x;
  batch.impulse_y.at[lane] = h * row.linear_force.y;
  batch.row[lane] = place.row;
}

void warm_start_pins(Scratch& scratch, std::uint32_t first, std::uint32_t last) {
  const PinKernels& kernels = scratch.kernels->pins;
  (scratch.pins.order == PinOrder::row ? kernels.warm_start_row
                                       : kernels.warm_start)(work_of(scratch, first, last, Real(1)));
}

void solve_pins(Scratch& scratch, std::uint32_t first, std::uint32_t last, Real h, Bias bias) {
  const PinKernels& kernels = scratch.kernels->pins;
  const PinWork work = work_of(scratch, first, last, h);
  if (scratch.pins.order == PinOrder::row)
    (bias == Bias::on ? kernels.solve_row : kernels.relax_row)(work);
  else
    (bias == Bias::on ? kernels.solve : kernels.relax)(work);
}

void store_pins(const Scratch& scratch, State& state, Real h) {
  const Real inv_h = 1 / h;
  for (std::uint32_t i = 0; i < scratch.pins.batch_count; ++i) {
    const PinBatch& batch = scratch.pins.batches[i];
    for (std::int32_t lane = 0; lane < batch.count; ++lane) {
      const Vec2 impulse{batch.impulse_x.at[lane], batch.impulse_y.at[lane]};
      state.joints[batch.row[lane]].linear_force = inv_h * impulse;
    }
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
