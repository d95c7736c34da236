// A whole tick for each block of contacts.
// SPDX-License-Identifier: MIT
#include "engine/contacts/contact_blocks.h"

#include "engine/integrators/flow.h"
#include "engine/model/bodies.h"
#include "engine/model/model.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

bool allows_blocks(const Model& model, const State& state, const Scratch& scratch, const SolverSet& set) {
  if (!bodies_step_alone(model) || (model.contact_features & contact_feature::bounce) != 0 || scratch.injected ||
      !state.joints.empty() || !scratch.mouse_joints.empty() || !scratch.impacts.empty() || set.has_resting_impacts ||
      scratch.solver_sets.size() != 1)
    return false;
  // A kinematic body moves in each substep, for all blocks.
  const std::uint32_t sink = dummy_sink(scratch);
  for (std::uint32_t i = set.first_row; i < set.row_end; ++i)
    if (scratch.masses[scratch.set_rows[i]].write == sink) return false;
  return true;
}

void solve_blocks(const Model& model, State& state, Scratch& scratch, const SolverSet& set) {
  const std::span<const ContactBlock> blocks = scratch.caches.colors.blocks();
  const ContactKernels& contacts = scratch.kernels->contacts;
  const MotionKernels& motion = scratch.kernels->motion;
  Real* bodies = &scratch.bodies.data()->velocity.x;
  const std::size_t count = blocks.size();
  const std::size_t chunk_size = scratch.parallel.chunk_size(count, 1, 1);
  scratch.block_batches.resize(Parallel::chunk_count(count, chunk_size));
  scratch.parallel.for_chunks(count, chunk_size, [&](const Chunk& chunk) {
    ContactBatches& batches = scratch.block_batches[chunk.index];
    const std::uint32_t sink = dummy_sink(scratch, chunk.index);
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const std::span<const std::uint32_t> rows = scratch.caches.blocks.rows(i);
      prepare_block(model, state, scratch, set, blocks[i], sink, batches);
      const ContactWork work = work_of_block(scratch, set, batches);
      for (int substep = 0; substep < set.substeps; ++substep) {
        motion.step_velocities(bodies, scratch.caches.velocity_steps.rows()->gain, rows.data(), rows.size());
        contacts.warm_start(work);
        contacts.solve_again(work);
        motion.move_bodies(bodies, rows.data(), rows.size(), dummy_body(scratch), sink, set.h);
        contacts.relax(work);
      }
      store_block(scratch, set, batches, state);
    }
  });
  scratch.moving_rows = scratch.caches.blocks.free_rows();
  integrate_freely(scratch, set.h, set.substeps);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
