// Poisoning of scratch memory, so that a tick cannot use results of the tick before, and forgetting of caches.
// SPDX-License-Identifier: MIT
#include "engine/model/scratch.h"

#include <cstring>

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

template <typename T>
void poison_rows(std::vector<T>& rows) {
  rows.resize(rows.capacity());
  if (!rows.empty()) std::memset(static_cast<void*>(rows.data()), 0xff, rows.size() * sizeof(T));
  rows.clear();
}

/// Rows that only grow: a tick may read none that it has not written.
template <typename T>
void poison_in_place(std::vector<T>& rows) {
  if (!rows.empty()) std::memset(static_cast<void*>(rows.data()), 0xff, rows.size() * sizeof(T));
}

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

void poison(Scratch& scratch) {
  // Not poisoned: inputs, which the caller decodes, and caches, which have keys.
  poison_rows(scratch.force);
  poison_rows(scratch.torque);
  scratch.proxies = {};
  poison_rows(scratch.proxy_rows);
  poison_rows(scratch.boxes);
  poison_rows(scratch.circles);
  poison_rows(scratch.pair_rows);
  poison_rows(scratch.unsorted_pairs);
  for (PairSorter& sorter : scratch.pair_sorters) {
    poison_rows(sorter.pairs);
    poison_rows(sorter.by_second);
    poison_rows(sorter.start);
  }
  poison_rows(scratch.counts);
  poison_rows(scratch.sort_entries);
  poison_rows(scratch.sort_buffer);
  poison_rows(scratch.swept_boxes);
  poison_rows(scratch.swept_places);
  poison_rows(scratch.cell_ranges);
  poison_rows(scratch.cell_entries);
  poison_rows(scratch.cell_starts);
  poison_rows(scratch.large);
  poison_rows(scratch.inner_boxes);
  poison_rows(scratch.outlines);
  poison_rows(scratch.ccd_target_starts);
  poison_rows(scratch.ccd_target_places);
  poison_rows(scratch.contact_pairs);
  poison_rows(scratch.contacts);
  poison_rows(scratch.part_counts);
  poison_rows(scratch.parts);
  poison_rows(scratch.contact_pairs_spilled);
  poison_rows(scratch.contact_pairs_merged);
  poison_rows(scratch.contacts_spilled);
  poison_rows(scratch.contacts_merged);
  poison_rows(scratch.now_touching);
  poison_rows(scratch.removed_touching);
  poison_rows(scratch.removed_sensors);
  poison_rows(scratch.touch_buffer);
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
  poison_rows(scratch.mouse_joints);
  poison_rows(scratch.impacts);
  poison_rows(scratch.paths);
  poison_rows(scratch.hit_rows);
  poison_rows(scratch.active_impacts);
  poison_rows(scratch.impact_events);
  poison_rows(scratch.impact_starts);
  poison_rows(scratch.impacts_of_bodies);
  poison_rows(scratch.solver_sets);
  scratch.moving_rows = {};
  poison_rows(scratch.is_fast);
  poison_rows(scratch.is_constrained);
  poison_rows(scratch.free_rows);
  poison_rows(scratch.set_rows);
  poison_rows(scratch.set_contacts);
  poison_rows(scratch.set_keys);
  poison_rows(scratch.body_solver_set);
  poison_rows(scratch.body_types);
  poison_rows(scratch.island_parent);
  poison_rows(scratch.island_level);
  poison_rows(scratch.island_has_resting_impact);
  poison_rows(scratch.resting_impacts);
  poison_rows(scratch.shock_velocities);
  poison_rows(scratch.island_awake);
  poison_rows(scratch.supports);
  poison_rows(scratch.support_start);
  poison_rows(scratch.support_depth);
  poison_rows(scratch.support_order);
  poison_rows(scratch.load);
  poison_rows(scratch.joint_acceleration);
  poison_rows(scratch.position_error);
  poison_rows(scratch.local_error);
  poison_rows(scratch.load_moment);
  poison_rows(scratch.load_passed_on);
  poison_rows(scratch.tilt_errors);
  ImpulseStep& step = scratch.impulse_step;
  poison_rows(step.rows);
  for (std::vector<double>* rows : {&step.full_change, &step.matrix, &step.velocity, &step.total}) poison_rows(*rows);
  for (std::vector<std::uint32_t>* rows : {&step.start, &step.neighbours, &step.place, &step.bodies, &step.first})
    poison_rows(*rows);
  poison_rows(step.is_start);
  poison_rows(step.row_start);
  poison_rows(scratch.island_errors);
  poison_rows(scratch.mass_factor);
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

void forget(Scratch& scratch, CacheSet caches) {
  TickCaches& cached = scratch.caches;
  const auto is_in = [caches](CacheKind kind) { return (caches & cache_bit(kind)) != 0; };
  if (caches == all_caches) cached.pairs.is_valid = false;  // the proxies, on which all caches depend
  if (is_in(CacheKind::pair_list)) cached.pairs.has_pairs = false;
  if (is_in(CacheKind::boxes)) cached.pairs.farthest = -1;  // no tick has this
  if (is_in(CacheKind::present_pairs)) cached.pairs.has_present = false;
  if (is_in(CacheKind::manifolds)) cached.has_contact_pairs = false;
  if (is_in(CacheKind::contact_places)) cached.is_settled = false;
  if (is_in(CacheKind::pair_blocks))
    for (PairBlock& block : cached.pair_blocks) block.is_valid = false;
  if (is_in(CacheKind::velocity_steps)) cached.velocity_steps.is_valid = false;
  if (is_in(CacheKind::free_motion)) scratch.free_motion_step = 0;
  if (is_in(CacheKind::joint_plan)) cached.joints.is_of_scene = false;
  if (is_in(CacheKind::contact_colors)) {
    cached.coloring.is_whole_set = false;
    cached.coloring.body_indices.clear();
    cached.coloring.blocks.clear();
  }
  if (is_in(CacheKind::contact_blocks)) {
    cached.coloring.block_of.clear();
    cached.coloring.set_rows.clear();
    cached.coloring.ticks_unsplit = 0;
  }
  if (is_in(CacheKind::cell_side)) cached.pairs.common_side = 0;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
