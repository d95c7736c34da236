// Scratch: the workspace of a tick, and caches. Derived from Model and State alone; never hashed, never saved.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/limits.h"
#include "base/parallel/parallel.h"
#include "engine/broad_phase/pair_rows.h"
#include "engine/caches.h"
#include "engine/contacts/contact_batch.h"
#include "engine/contacts/solver_kernels.h"
#include "engine/impacts/impacts.h"
#include "engine/impacts/impulse_rows.h"
#include "engine/integrators/motion_rows.h"
#include "engine/islands/island_rows.h"
#include "engine/joints/batched/driven_revolute_batch.h"
#include "engine/joints/batched/revolute_batch.h"
#include "engine/joints/joint.h"
#include "engine/joints/joint_plan.h"
#include "engine/joints/mouse_joint.h"
#include "engine/model/body_rows.h"
#include "engine/model/state.h"
#include "engine/narrow_phase/manifold.h"
#include "engine/narrow_phase/pair_block.h"
#include "engine/scene/input.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Caches from tick to tick. Each has a key with which it is checked. A tick gives the same bits with it, without it,
/// and with the cache of any other run of the same model (docs/decisions/0014).
struct TickCaches {
  PairCache pairs;
  std::vector<ContactPair> contact_pairs;  // of the tick before; parallel to State::contacts
  bool has_contact_pairs = false;          // valid: no contact, body or margin has changed since
  bool is_settled = false;                 // none of them was new: the next tick probably has the same
  std::uint32_t contact_set = 0;           // changes with the set of contacts
  std::vector<PairBlock> pair_blocks;      // of the pairs of the tick before
  std::uint32_t generation = 0;            // counts the ticks that checked the blocks
  VelocitySteps velocity_steps;
  JointPlan joints;
  ContactColoring coloring;
  CacheReport report{};
};

struct Scratch {
  TickCaches caches;
  Parallel parallel;                                                            // the engine's
  std::size_t pair_count_max = limits::pair_count_max(limits::body_count_max);  // of this tick

  // A chunk writes its part of a list at the beginning of its part of the range. The parts are put together afterwards.
  std::vector<std::uint32_t> part_counts;  // [chunk]
  std::vector<ListPart> parts;             // [chunk]

  // inputs
  std::vector<Input> inputs;
  std::vector<Vec2> force;   // [body] N, from this tick's inputs; empty if none act
  std::vector<Real> torque;  // [body] N m

  // broad_phase
  std::span<const Proxy> proxies;  // cached ones, or `proxy_rows`
  std::vector<Proxy> proxy_rows;
  std::vector<Box> boxes;           // [proxy] m, enclose the shapes with their margins; not filled by aabb_tree
  std::vector<Circle> circles;      // [proxy], bounding_circle
  std::span<const Pair> pairs;      // by (first, second)
  std::vector<Pair> pair_rows;      // used by broad phases without a cache
  bool has_too_many_pairs = false;  // more than pair_count_max boxes overlap: the tick cannot be done
  std::vector<Pair> unsorted_pairs;
  std::vector<std::vector<Pair>> pair_parts;  // [chunk] aabb_tree, neighbour_cells
  std::vector<PairSorter> pair_sorters;       // [part]
  std::vector<std::uint32_t> counts;
  std::vector<SortEntry> sort_entries;  // sweep_and_prune, aabb_tree
  std::vector<SortEntry> sort_buffer;
  std::vector<Box> swept_boxes;                  // sweep_and_prune: in sweep order; neighbour_cells: by cell
  std::vector<SweptPlace> swept_places;          // neighbour_cells: the proxies of swept_boxes
  std::vector<CellRange> cell_ranges;            // uniform_grid, [proxy]
  std::vector<CellEntry> cell_entries;           // uniform_grid, by bucket, dynamic ones first
  std::vector<std::uint32_t> cell_starts;        // uniform_grid, [bucket]; neighbour_cells, [cell]
  std::vector<std::uint32_t> large;              // uniform_grid, neighbour_cells: proxies in no cell, ascending
  std::vector<Box> inner_boxes;                  // neighbour_cells, [proxy] boxes without CCD margin
  std::vector<BoxOutline> outlines;              // neighbour_cells, [chunk]
  std::vector<std::uint32_t> ccd_target_starts;  // neighbour_cells: [cell]
  std::vector<std::uint32_t> ccd_target_places;  // neighbour_cells: CCD targets, by cell

  // narrow_phase
  std::vector<ContactPair> contact_pairs;
  std::vector<ContactRow> contacts;                // the rows that replace State::contacts
  std::vector<ContactPair> contact_pairs_spilled;  // the contacts of a chunk that do not fit in place
  std::vector<ContactPair> contact_pairs_merged;
  std::vector<ContactRow> contacts_spilled;
  std::vector<ContactRow> contacts_merged;

  // impacts
  std::vector<ImpactPair> impacts;                    // possible in this tick
  std::vector<std::vector<ImpactPair>> impact_parts;  // [chunk]
  std::vector<std::uint8_t> is_fast;                  // [body] may pass through another in this tick
  std::vector<ImpactPath> paths;                      // [body], of those in `impacts`
  std::vector<std::uint32_t> hit_rows;                // rows of bodies hit in the present substep
  std::vector<std::uint32_t> active_impacts;          // of the set that is being solved
  std::vector<ImpactEvent> impact_events;             // a heap, earliest first
  std::vector<std::uint32_t> impact_starts;           // [body] in impacts_of_bodies
  std::vector<std::uint32_t> impacts_of_bodies;
  bool offsets_in_use = false;  // the integrator fills velocity_offsets

  // islands
  bool has_solver_sets = false;                // by islands; else there will be one set
  std::vector<SolverSet> solver_sets;          // ascending by substeps; sleeping islands are in none
  std::span<const std::uint32_t> moving_rows;  // of the set that is being solved
  std::uint32_t set_index = 0;                 // index of that set
  std::vector<std::uint8_t> is_constrained;    // [body] has a contact or impact in this tick
  std::vector<std::uint32_t> free_rows;        // of the set that is being solved
  std::vector<std::uint32_t> set_rows;         // rows of moving bodies, by set; kinematic ones are in each set
  std::vector<std::uint32_t> set_contacts;     // in `contact_pairs`
  std::vector<std::uint32_t> set_keys;         // [body] islands: key of its set
  std::vector<std::uint32_t> body_solver_set;  // [body] index in `solver_sets`; no_solver_set: asleep or static
  std::vector<BodyType> body_types;            // [body] islands
  std::vector<std::uint32_t> island_parent;    // [body] union-find
  std::vector<std::uint32_t> island_level;     // [body] at the island's first row: substeps
  std::vector<std::uint8_t> island_awake;      // [body] at the island's first row
  std::vector<std::uint8_t> island_has_resting_impact;  // [body] at the island's first row
  std::vector<RestingImpact> resting_impacts;
  std::vector<Twist> shock_velocities;  // [body] before the last passes
  std::uint32_t shock_work_left = 0;    // contacts that may still be solved for resting impacts in this tick
  ImpulseStep impulse_step;
  std::vector<Support> supports;
  std::vector<std::uint32_t> support_start;  // [body] in `supports`
  std::vector<std::uint32_t> support_depth;  // [body] steps from the ground
  std::vector<std::uint32_t> support_order;  // bodies by depth
  std::vector<Real> load;                    // [body] N
  std::vector<Real> joint_acceleration;      // [body] m/s^2, by which joints hold a spinning body
  std::vector<Real> position_error;          // [body] m, estimated at four substeps
  std::vector<Vec2> load_moment;             // [body] N m, load times position
  std::vector<Real> load_passed_on;          // [body] N, of the load from other bodies
  std::vector<TiltError> tilt_errors;        // [body] expected at four substeps
  std::vector<Real> local_error;             // [body] the same relative to its support alone and the smaller size
  std::vector<IslandError> island_errors;    // [body] at the island's first row
  std::vector<Real> mass_factor;             // [body] factor of its mass in constraints; with automatic substeps

  // events
  std::vector<TouchRow> now_touching;      // replaces State::touching, then State::sensors
  std::vector<TouchRow> removed_touching;  // rows of bodies that were removed in this tick
  std::vector<TouchRow> removed_sensors;
  std::vector<TouchRow> touch_buffer;

  // solver
  const SolverKernels* kernels = nullptr;  // the model's
  std::optional<InjectedFault> injected;   // for this tick
  std::vector<MovingBody> bodies;
  std::vector<BodyMass> masses;               // [body]
  std::vector<FreeMotion> free_motion;        // [source], for steps of free_motion_step
  Real free_motion_step = 0;                  // s; 0: not computed yet
  std::vector<Twist> constant_accelerations;  // [body] gravity, forces of this tick's inputs, constant elements
  std::vector<Twist> accelerations;           // [record] at the present stage
  std::vector<Twist> velocity_offsets;        // [body] velocity at the end of the substep, less the drift velocity
  std::vector<Twist> predicted;               // [body] velocity at the end of the substep, without constraints
  std::vector<Twist> previous_accelerations;  // [body] of the substep before; empty unless the integrator needs them
  std::vector<StageRow> stages;               // [body]
  std::vector<SpringRow> springs;             // [spring whose bodies are there]
  std::vector<std::uint32_t> central_rows;    // [central force] row of its one body, or no_reference
  std::vector<SpringBlock> spring_blocks;
  std::vector<Twist> newton[5];   // [record] diagonal, solution, residual, direction, product
  std::uint32_t unconverged = 0;  // substeps whose equations were not solved
  ContactBatches contact_batches;
  std::vector<ContactBatches> block_batches;  // [chunk] of the block that is being solved
  std::vector<MouseJoint> mouse_joints;
  std::vector<JointWork> joints;  // of the scalar path
  RevoluteBatches revolutes;
  DrivenRevoluteBatches driven_revolutes;
  bool uses_wavefront = false;  // joints are solved by a wavefront sweep
  std::vector<JointPlace> sorted_places;
  std::vector<BodyJoints> body_joints;      // [body]
  std::vector<std::uint32_t> body_levels;   // [body] level of the next joint that moves it
  std::vector<JointTorques> joint_torques;  // [place of the plan]
  std::vector<Real> body_torques;           // [body] sum of the torques of its joints, N m
  std::vector<std::uint32_t> level_starts;  // [level and path] in the plan's places
};

/// Makes the next tick build these structures anew.
void forget(Scratch& scratch, CacheSet caches);

/// Fills everything that a tick must write before reading with bytes that make errors visible (NaN, huge indices).
/// Builds with TICKTRUE_POISON call it before each tick.
void poison(Scratch& scratch);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
