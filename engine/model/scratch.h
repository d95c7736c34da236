// Scratch: what the solver works with in a tick, and what it caches. Derived from Model and State alone; never hashed,
// never saved.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "engine/contacts/contact_batch.h"
#include "engine/contacts/contact_coloring.h"
#include "engine/contacts/island_blocks.h"
#include "engine/contacts/solver_kernels.h"
#include "engine/impacts/impulse_rows.h"
#include "engine/integrators/motion_rows.h"
#include "engine/joints/batched/driven_revolute_batch.h"
#include "engine/joints/batched/revolute_batch.h"
#include "engine/joints/joint.h"
#include "engine/joints/joint_plan.h"
#include "engine/joints/mouse_joint.h"
#include "engine/model/body_rows.h"
#include "engine/model/caches.h"
#include "engine/model/state.h"
#include "engine/model/tick_lists.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// What ticks keep for the next one. Each part says of itself for what it holds, so that a tick gives the same bits
/// with it, without it, and with that of any other run of the same model (docs/decisions/0014).
/// What the solver caches from tick to tick.
struct SolverCaches {
  FreeMotionCache free_motion;
  VelocitySteps velocity_steps;
  JointPlan joints;
  ContactColors colors;
  IslandBlocks blocks;
};

struct Scratch : TickLists {
  SolverCaches caches;

  // impacts
  std::vector<ImpactPath> paths;              // [body], of those in `impacts`
  std::vector<std::uint32_t> hit_rows;        // in the present substep
  std::vector<std::uint32_t> active_impacts;  // those of the set that is being solved
  std::vector<ImpactEvent> impact_events;     // a heap, earliest first
  std::vector<std::uint32_t> impact_starts;   // [body] in impacts_of_bodies
  std::vector<std::uint32_t> impacts_of_bodies;
  std::vector<Twist> shock_velocities;  // [body] before the last passes
  ImpulseStep impulse_step;

  // sets
  std::span<const std::uint32_t> moving_rows;  // of the set that is being solved
  std::uint32_t set_index = 0;                 // of that set
  std::vector<std::uint8_t> is_constrained;    // [body] something touches it in this tick, or may
  std::vector<std::uint32_t> free_rows;        // of the set that is being solved

  // solver
  const SolverKernels* kernels = nullptr;  // the model's
  std::vector<MovingBody> bodies;
  std::vector<BodyMass> masses;               // [body]
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
  ColoringWork coloring;
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

/// The solver's caches.
void list_caches(Scratch& scratch, std::vector<TickCache*>& caches);

/// Fills everything that a tick must write before reading with bytes that make errors visible (NaN, huge indices).
/// Builds with TICKTRUE_POISON call it before each tick.
void poison(Scratch& scratch);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
