// All substeps of a tick for each block of contacts.
// SPDX-License-Identifier: MIT
#include "engine/contacts/contact_blocks.h"

#include "engine/integrators/flow.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

bool allows_blocks(const SolvedSet& solved) {
  const State& state = solved.state;
  const TickLists& tick = solved.tick;
  if (!bodies_step_alone(solved.model) || (solved.model.contact_features & contact_feature::bounce) != 0 ||
      tick.injected || !state.joints.empty() || !state.pointers.empty() || !tick.impacts.empty() ||
      solved.set.has_resting_impacts || tick.solver_sets.size() != 1)
    return false;
  // A kinematic body moves in each substep, before all blocks.
  const std::uint32_t sink = dummy_sink(solved.bodies);
  for (const std::uint32_t row : solved.all_rows())
    if (solved.bodies.masses[row].write == sink) return false;
  return true;
}

void solve_blocks(SolvedSet& solved, ContactWorkspace& work, const MotionWorkspace& motion, State& state) {
  const std::span<const ContactBlock> blocks = work.colors.blocks();
  const ContactKernels& contacts = solved.kernels().contacts;
  const MotionKernels& steps = solved.kernels().motion;
  Real* bodies = solved.bodies.lanes();
  const Real* gains = motion.velocity_steps.rows()->gain;
  const std::size_t count = blocks.size();
  const std::size_t chunk_size = solved.parallel().chunk_size(count, 1, 1);
  work.block_batches.resize(Parallel::chunk_count(count, chunk_size));
  solved.parallel().for_chunks(count, chunk_size, [&](const Chunk& chunk) {
    ContactBatches& batches = work.block_batches[chunk.index];
    const std::uint32_t sink = dummy_sink(solved.bodies, chunk.index);
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const std::span<const std::uint32_t> rows = work.blocks.rows(i);
      prepare_block(solved, work.colors, blocks[i], sink, batches);
      const ContactWork of_block = work_of_block(solved, batches);
      for (int substep = 0; substep < solved.set.substeps; ++substep) {
        steps.step_velocities(bodies, gains, rows.data(), rows.size());
        contacts.warm_start(of_block);
        contacts.solve(of_block);
        steps.move_bodies(bodies, rows.data(), rows.size(), dummy_body(solved.bodies), sink, solved.set.h);
        contacts.relax(of_block);
      }
      store_block(solved, batches, state);
    }
  });
  solved.rows = work.blocks.free_rows();
  integrate_freely(solved, motion);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
