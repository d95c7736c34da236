// Packing of hinges, and the passes over them.
// SPDX-License-Identifier: MIT
#include "engine/joints/batched/hinge_batch.h"

#include "engine/model/bodies.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

void fill_lane(HingeBatch& batch, std::size_t lane, const JointWork& joint) {
  const JointModel& model = *joint.model;
  fill_pin_lane(batch.pin, lane, joint.row, {joint.inv_mass_a, joint.inv_inertia_a, joint.read_a, joint.write_a},
                {joint.inv_mass_b, joint.inv_inertia_b, joint.read_b, joint.write_b}, joint.anchor_a, joint.anchor_b,
                joint.apart, joint.impulses.linear);
  if (model.spring.exists || model.has_limits) batch.needs_angle = 1;
  batch.turn_c.at[lane] = joint.turn.c;
  batch.turn_s.at[lane] = joint.turn.s;
  batch.is_sprung.at[lane] = model.spring.exists ? Real(1) : Real(0);
  batch.is_driven.at[lane] = model.has_motor ? Real(1) : Real(0);
  batch.is_limited.at[lane] = model.has_limits ? Real(1) : Real(0);
  batch.loss.at[lane] = joint.spring.loss;
  batch.pull.at[lane] = joint.spring.pull;
  batch.give.at[lane] = joint.spring.give;
  batch.motor_speed.at[lane] = joint.motor_speed;
  batch.motor_impulse_max.at[lane] = joint.motor_impulse_max;
  batch.lower.at[lane] = model.lower;
  batch.upper.at[lane] = model.upper;
  batch.spring_impulse.at[lane] = joint.impulses.spring;
  batch.motor_impulse.at[lane] = joint.impulses.motor;
  batch.lower_impulse.at[lane] = joint.impulses.lower;
  batch.upper_impulse.at[lane] = joint.impulses.upper;
}

template <typename Kernel>
void run_kernel(Scratch& scratch, const JointRange& range, Real h, Kernel kernel) {
  scratch.parallel.for_chunks(range.last - range.first, range.chunk_size, [&](const Chunk& chunk) {
    kernel({scratch.hinges.batches.data() + range.first + chunk.begin, chunk.end - chunk.begin,
            &scratch.bodies.data()->velocity.x, h, scratch.hinges.soft});
  });
}

}  // namespace

void fill_hinges(const Model& model, const State& state, Scratch& scratch, const Softness& soft, Real h) {
  HingeBatches& hinges = scratch.hinges;
  const std::vector<JointSpan>& spans = scratch.caches.joints.hinges;
  const std::size_t count = spans.size();
  if (hinges.batches.size() < count) hinges.batches.resize(count);
  scratch.parallel.for_chunks(count, scratch.parallel.chunk_size(count, 2, 1), [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const JointSpan& span = spans[i];
      HingeBatch& batch = hinges.batches[i];
      batch = {};
      empty_pins(scratch, batch.pin);
      batch.pin.count = static_cast<std::int32_t>(span.count);
      for (std::uint32_t lane = 0; lane < span.count; ++lane) {
        ask_early(state, scratch, span.first + lane);
        fill_lane(batch, lane,
                  make_joint(model, state, scratch, scratch.caches.joints.places[span.first + lane], soft, h));
      }
      if (scratch.is_woven) write_elsewhere(scratch, batch.pin, span.level);
    }
  });
}

std::size_t share_hinges(Scratch& scratch, std::uint32_t first, std::uint32_t last) {
  const std::size_t count = last - first;
  const std::size_t size = scratch.parallel.chunk_size(count, joint_batches_per_chunk_least, 1);
  for (std::size_t i = size; i < count; ++i)  // the first chunk has its record already
    write_elsewhere(scratch, scratch.hinges.batches[first + i].pin, i / size);
  return size;
}

void note_hinges(Scratch& scratch, const JointRange& range) {
  run_kernel(scratch, range, Real(1), scratch.kernels->hinges.note);
}

void warm_start_hinges(Scratch& scratch, const JointRange& range) {
  run_kernel(scratch, range, Real(1), scratch.kernels->hinges.warm_start);
}

void solve_hinges(Scratch& scratch, const JointRange& range, Real h, Bias bias) {
  const HingeKernels& kernels = scratch.kernels->hinges;
  run_kernel(scratch, range, h, bias == Bias::on ? kernels.solve : kernels.relax);
}

void store_hinges(const Scratch& scratch, State& state, Real h) {
  const Real inv_h = 1 / h;
  const std::size_t count = scratch.caches.joints.hinges.size();
  scratch.parallel.for_chunks(count, scratch.parallel.chunk_size(count, 4, 1), [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const HingeBatch& batch = scratch.hinges.batches[i];
      for (std::int32_t lane = 0; lane < batch.pin.count; ++lane) {
        JointRow& row = state.joints[batch.pin.row[lane]];
        const Vec2 linear{batch.pin.impulse_x.at[lane], batch.pin.impulse_y.at[lane]};
        row.linear_force = stored(inv_h * linear);
        row.torque = stored(inv_h * (h * row.torque));  // none of a hinge's; as joints by themselves treat it
        row.spring_force = stored(inv_h * batch.spring_impulse.at[lane]);
        row.lower_force = stored(inv_h * batch.lower_impulse.at[lane]);
        row.upper_force = stored(inv_h * batch.upper_impulse.at[lane]);
        row.motor_force = stored(inv_h * batch.motor_impulse.at[lane]);
      }
    }
  });
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
