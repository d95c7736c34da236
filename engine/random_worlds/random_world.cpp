// Random worlds: a plan, bodies, joints, forces and inputs, in this order.
// SPDX-License-Identifier: MIT
#include "engine/random_worlds/random_world.h"

#include "base/assert.h"
#include "engine/random_worlds/world_builder.h"

namespace ticktrue::engine {
namespace {

// Separate streams: a world without these choices does not depend on them.
constexpr std::uint64_t joint_solver_stream = 0x6a6f696e74735f31;
constexpr std::uint64_t loads_stream = 0x6c6f6164735f5f31;
constexpr std::uint64_t budget_stream = 0x6275646765745f31;
constexpr std::uint64_t structure_stream = 0x7374727563745f31;

/// Without a budget, a tick in which something hits a large pile takes a second.
constexpr std::size_t unlimited_body_count_max = 128;

}  // namespace

RandomWorld random_world(std::uint64_t seed, const RandomWorldOptions& options) {
  Draw draw(seed);
  WorldPlan plan = draw_plan(draw, options);
  draw_structures(Draw(seed ^ structure_stream), options, plan);
  WorldBuilder builder(draw, plan);
  builder.build();
  RandomWorld world;
  world.scene = std::move(builder.scene);
  world.scene.name = "random_" + std::to_string(seed);
  add_joints(draw, plan, builder.size, world.scene);
  if (!world.scene.joints.empty() && info_of(solvers, world.scene.settings.solver).chooses_joints &&
      Draw(seed ^ joint_solver_stream).half())
    world.scene.settings.joints = JointSolverKind::direct;
  if (world.scene.settings.auto_substeps && Draw(seed ^ loads_stream).half())
    world.scene.settings.substep_loads = SubstepLoads::measured;
  Draw budget(seed ^ budget_stream);
  const bool is_limited = budget.half() || world.scene.bodies.size() > unlimited_body_count_max;
  if (world.scene.settings.auto_substeps && is_limited) world.scene.settings.substep_budget = 1 << budget.below(8);
  add_forces(draw, plan, world.scene);
  world.inputs = add_inputs(draw, plan, world.scene);
  world.tick_count = plan.tick_count;
  world.rows = rows_of_world(world);
  return world;
}

}  // namespace ticktrue::engine
