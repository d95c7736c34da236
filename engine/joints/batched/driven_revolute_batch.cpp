// Packing of driven revolute joints into batches, and the passes over the batches.
// SPDX-License-Identifier: MIT
#include "engine/joints/batched/driven_revolute_batch.h"

#include "engine/joints/joint_passes.h"
#include "engine/joints/joint_rows.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

void bound_impulses(DrivenRevoluteBatch& batch) {
  for (int lane = 0; lane < batch.point.count; ++lane) {
    Real& x = batch.point.impulse_x.at[lane];
    Real& y = batch.point.impulse_y.at[lane];
    const Real share = share_within(batch.turning.at[lane], x * x + y * y);
    if (share == 1) continue;
    x *= share;
    y *= share;
    batch.spring_impulse.at[lane] *= share;
    batch.motor_impulse.at[lane] *= share;
    batch.lower_impulse.at[lane] *= share;
    batch.upper_impulse.at[lane] *= share;
  }
}

void fill_lane(DrivenRevoluteBatch& batch, std::size_t lane, const JointWork& joint) {
  const JointModel& model = *joint.model;
  fill_revolute_lane(batch.point, lane, joint.row, {joint.inv_mass_a, joint.inv_inertia_a, joint.read_a, joint.write_a},
                     {joint.inv_mass_b, joint.inv_inertia_b, joint.read_b, joint.write_b}, joint.anchor_a,
                     joint.anchor_b, joint.center_offset, joint.impulses.linear);
  if (model.spring.exists || model.has_limits) batch.needs_angle = 1;
  batch.turning.at[lane] = joint.turning;
  batch.rotation_c.at[lane] = joint.relative_rotation.c;
  batch.rotation_s.at[lane] = joint.relative_rotation.s;
  batch.has_spring.at[lane] = model.spring.exists ? Real(1) : Real(0);
  batch.has_motor.at[lane] = model.has_motor ? Real(1) : Real(0);
  batch.has_limits.at[lane] = model.has_limits ? Real(1) : Real(0);
  batch.velocity_gain.at[lane] = joint.spring.velocity_gain;
  batch.position_gain.at[lane] = joint.spring.position_gain;
  batch.change_gain.at[lane] = joint.spring.change_gain;
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
void run_kernel(const SolvedSet& solved, JointWorkspace& work, const JointRange& range, Real h, Kernel kernel) {
  solved.parallel().for_chunks(range.last - range.first, chunk_size_of(work, range), [&](const Chunk& chunk) {
    kernel({work.driven_revolutes.batches.data() + range.first + chunk.begin, chunk.end - chunk.begin,
            solved.bodies.lanes(), h, work.driven_revolutes.soft});
  });
}

}  // namespace

void fill_driven_revolutes(const SolvedSet& solved, JointWorkspace& work) {
  DrivenRevoluteBatches& driven_revolutes = work.driven_revolutes;
  const std::span<const JointSpan> spans = work.plan.driven_revolutes();
  const std::span<const JointPlace> places = work.plan.places();
  const std::size_t count = spans.size();
  if (driven_revolutes.batches.size() < count) driven_revolutes.batches.resize(count);
  solved.parallel().for_chunks(count, solved.parallel().chunk_size(count, 2, 1), [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const JointSpan& span = spans[i];
      DrivenRevoluteBatch& batch = driven_revolutes.batches[i];
      batch = {};
      clear_revolutes(solved.bodies, batch.point);
      batch.point.count = static_cast<std::int32_t>(span.count);
      for (std::uint32_t lane = 0; lane < span.count; ++lane) {
        prefetch_joint(solved.state, places, span.first + lane);
        fill_lane(batch, lane, make_joint(solved, places[span.first + lane], driven_revolutes.soft));
      }
      if (work.uses_wavefront) redirect_to_sink(solved.bodies, batch.point, span.level);
    }
  });
}

void separate_driven_revolute_sinks(const SolverBodies& bodies, const JointRange& range,
                                    DrivenRevoluteBatches& driven) {
  // The first chunk writes to the sink that the batches already have.
  for (std::size_t i = range.chunk_size; i < range.last - range.first; ++i)
    redirect_to_sink(bodies, driven.batches[range.first + i].point, i / range.chunk_size);
}

void save_driven_revolutes(const SolvedSet& solved, JointWorkspace& work, const JointRange& range) {
  run_kernel(solved, work, range, Real(1), solved.kernels().driven_revolutes.save_velocities);
}

void warm_start_driven_revolutes(const SolvedSet& solved, JointWorkspace& work, const JointRange& range) {
  solved.parallel().for_chunks(range.last - range.first, chunk_size_of(work, range), [&](const Chunk& chunk) {
    for (std::size_t i = range.first + chunk.begin; i < range.first + chunk.end; ++i)
      bound_impulses(work.driven_revolutes.batches[i]);
  });
  run_kernel(solved, work, range, Real(1), solved.kernels().driven_revolutes.warm_start);
}

void solve_driven_revolutes(const SolvedSet& solved, JointWorkspace& work, const JointRange& range, Bias bias) {
  const DrivenRevoluteKernels& kernels = solved.kernels().driven_revolutes;
  run_kernel(solved, work, range, solved.set.h, bias == Bias::on ? kernels.solve : kernels.relax);
}

void store_driven_revolutes(const SolvedSet& solved, const JointWorkspace& work, State& state) {
  const Real h = solved.set.h;
  const Real inv_h = 1 / h;
  const std::size_t count = work.plan.driven_revolutes().size();
  solved.parallel().for_chunks(count, solved.parallel().chunk_size(count, 4, 1), [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const DrivenRevoluteBatch& batch = work.driven_revolutes.batches[i];
      for (std::int32_t lane = 0; lane < batch.point.count; ++lane) {
        JointRow& row = state.joints[batch.point.row[lane]];
        const Vec2 linear{batch.point.impulse_x.at[lane], batch.point.impulse_y.at[lane]};
        row.linear_force = stored(inv_h * linear);
        row.torque =
            stored(inv_h * (h * row.torque));  // always 0, by the same operations as for a joint of the scalar path
        row.spring_force = stored(inv_h * batch.spring_impulse.at[lane]);
        row.lower_force = stored(inv_h * batch.lower_impulse.at[lane]);
        row.upper_force = stored(inv_h * batch.upper_impulse.at[lane]);
        row.motor_force = stored(inv_h * batch.motor_impulse.at[lane]);
      }
    }
  });
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
