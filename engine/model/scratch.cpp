// Poisoning of scratch memory, so that a tick cannot use results of the tick before, and forgetting of caches.
// SPDX-License-Identifier: MIT
#include "engine/model/scratch.h"

#include "engine/model/poison.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr std::uint32_t poisoned_index = 0xffffffff;

void poison_batches(ContactBatches& batches) {
  poison_in_place(batches.batches);
  poison_in_place(batches.surfaces);
  poison_in_place(batches.bounces);
  batches.batch_count = 0;
  poison_rows(batches.slots);
  poison_rows(batches.runs);
  poison_rows(batches.saved);
}

}  // namespace

void poison(TickLists& tick) {
  poison_all(tick.force, tick.torque, tick.removed_touching, tick.removed_sensors, tick.impacts, tick.solver_sets,
             tick.set_rows, tick.set_contacts, tick.body_solver_set, tick.island_parent, tick.island_level,
             tick.island_has_resting_impact, tick.resting_impacts, tick.load, tick.mass_factor);
  tick.proxies = {};
  tick.pairs = {};
  tick.changes = {};
  tick.contact_pairs = {};
  tick.has_solver_sets = false;
  tick.contact_generation = tick.shock_work_left = poisoned_index;
}

void poison(Scratch& scratch) {
  poison_rows(scratch.bodies);
  poison_rows(scratch.masses);
  poison_rows(scratch.constant_accelerations);
  poison_rows(scratch.accelerations);
  poison_rows(scratch.velocity_offsets);
  poison_rows(scratch.predicted);
  poison_rows(scratch.previous_accelerations);
  poison_rows(scratch.stages);
  poison_rows(scratch.springs);
  poison_rows(scratch.central_rows);
  poison_rows(scratch.spring_blocks);
  for (std::vector<Twist>& rows : scratch.newton) poison_rows(rows);
  poison_batches(scratch.contact_batches);
  for (ContactBatches& batches : scratch.block_batches) poison_batches(batches);
  poison_all(scratch.coloring.colors, scratch.coloring.uncolored, scratch.coloring.places, scratch.coloring.body_colors,
             scratch.coloring.starts, scratch.coloring.blocks.island_parent, scratch.coloring.blocks.counts);
  poison_rows(scratch.mouse_joints);
  poison_rows(scratch.paths);
  poison_rows(scratch.hit_rows);
  poison_rows(scratch.active_impacts);
  poison_rows(scratch.impact_events);
  poison_rows(scratch.impact_starts);
  poison_rows(scratch.impacts_of_bodies);
  scratch.moving_rows = {};
  scratch.set_index = scratch.unconverged = poisoned_index;
  poison_rows(scratch.is_constrained);
  poison_rows(scratch.free_rows);
  poison_rows(scratch.shock_velocities);
  ImpulseStep& step = scratch.impulse_step;
  poison_rows(step.rows);
  for (std::vector<double>* rows : {&step.full_change, &step.matrix, &step.velocity, &step.total}) poison_rows(*rows);
  for (std::vector<std::uint32_t>* rows : {&step.start, &step.neighbours, &step.place, &step.bodies, &step.first})
    poison_rows(*rows);
  poison_rows(step.is_start);
  poison_rows(step.row_start);
  poison_rows(scratch.joints);
  poison_in_place(scratch.revolutes.batches);
  poison_in_place(scratch.revolutes.arms);
  poison_in_place(scratch.driven_revolutes.batches);
  poison_rows(scratch.sorted_places);
  poison_rows(scratch.body_joints);
  poison_rows(scratch.body_levels);
  poison_rows(scratch.joint_torques);
  poison_rows(scratch.body_torques);
  poison_rows(scratch.level_starts);
}

void list_caches(Scratch& scratch, std::vector<TickCache*>& caches) {
  SolverCaches& of = scratch.caches;
  caches.insert(caches.end(), {&of.free_motion, &of.velocity_steps, &of.joints, &of.colors, &of.blocks});
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
