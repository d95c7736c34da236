// Bodies and springs in the layout of integrators.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/parallel/parallel.h"
#include "engine/model/body_rows.h"
#include "engine/model/caches.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Model;

/// How velocities change over one step of a given length, without constraints: v' = decay * v + gain * acceleration.
/// Exact for constant acceleration and linear damping.
struct FreeMotion {
  Real linear_decay;
  Real linear_gain;  // s
  Real angular_decay;
  Real angular_gain;  // s
};

/// The sums of a scheme with several stages during a substep.
struct StageRow {
  MovingBody start;
  Twist velocities;     // sum over the stages so far, with their weights
  Twist accelerations;  // sum over the stages so far, with their weights
};

/// A spring of this tick, with the rows of its bodies. The dummy body stands for the world.
struct SpringRow {
  std::uint32_t body_a;   // in SolverBodies::records
  std::uint32_t body_b;   // record, read
  std::uint32_t write_b;  // record, written
  Vec2 offset;            // from A's centre of mass to B's (or the point of the world) when the tick began, m
  Vec2 arm_a;             // from A's centre of mass when the tick began, world axes, m
  Vec2 arm_b;
  Real inv_mass_a, inv_mass_b;        // 1/kg
  Real inv_inertia_a, inv_inertia_b;  // 1/(kg m^2)
  Real stiffness, damping, rest_length;
};

/// The block of one spring in the linearised equations of implicit_midpoint.
struct SpringBlock {
  std::uint32_t body_a;
  std::uint32_t body_b;
  Vec2 along;
  Vec2 arm_a, arm_b;                      // m
  Real stiff_along;                       // kg
  Real stiff_across;                      // kg
  Real stiff_angular_a, stiff_angular_b;  // kg m^2
};

/// FreeMotion with the accelerations of one body, for one substep: v' = decay * v + gain.
struct alignas(8 * sizeof(Real)) VelocityStep {
  Real gain[4];   // x, y in m/s, angular in rad/s, 0
  Real decay[4];  // x, y, angular, 0
};
static_assert(sizeof(VelocityStep) == body_record_length * sizeof(Real));

/// FreeMotion of all sources. Key: the length of a step.
class FreeMotionCache final : public TickCache {
 public:
  FreeMotionCache() : TickCache(CacheKind::free_motion) {}
  void follow(const Model& model, Real h);
  void invalidate() override { h_ = 0; }
  const FreeMotion& operator[](std::size_t source) const { return rows_[source]; }

 private:
  bool valid_for(Real h) const { return h_ == h; }
  void rebuild(const Model& model, Real h);

  Real h_ = 0;                    // s; 0: no rows
  std::vector<FreeMotion> rows_;  // [source]
};

/// The inputs of the steps of all bodies, beside the forces of a tick's inputs.
struct VelocityStepKey {
  std::uint32_t body_generation = 0;
  Vec2 gravity{0, 0};  // m/s^2
  Real h = 0;          // s

  bool operator==(const VelocityStepKey& other) const {
    return body_generation == other.body_generation && gravity.x == other.gravity.x && gravity.y == other.gravity.y &&
           h == other.h;
  }
};

/// The steps of all bodies. Key: VelocityStepKey, in ticks without forces of inputs.
class VelocitySteps final : public TickCache {
 public:
  VelocitySteps() : TickCache(CacheKind::velocity_steps) {}
  /// Makes the steps by step_of(row) unless they are valid. `may_keep`: the key determines the steps.
  template <typename StepOf>
  void follow(const VelocityStepKey& key, bool may_keep, const Parallel& parallel, std::size_t body_count,
              const StepOf& step_of) {
    const bool is_hit = may_keep && valid_for(key);
    count_use(is_hit);
    if (!is_hit) rebuild(key, may_keep, parallel, body_count, step_of);
  }
  void invalidate() override { is_valid_ = false; }
  const VelocityStep* rows() const { return rows_.data(); }

 private:
  bool valid_for(const VelocityStepKey& key) const { return is_valid_ && key_ == key; }
  template <typename StepOf>
  void rebuild(const VelocityStepKey& key, bool may_keep, const Parallel& parallel, std::size_t body_count,
               const StepOf& step_of) {
    is_valid_ = may_keep;
    key_ = key;
    rows_.resize(body_count);
    parallel.for_chunks(body_count, parallel.chunk_size(body_count, 256), [&](const Chunk& chunk) {
      for (std::size_t row = chunk.begin; row < chunk.end; ++row) rows_[row] = step_of(row);
    });
  }

  bool is_valid_ = false;
  VelocityStepKey key_;
  std::vector<VelocityStep> rows_;  // [body]
};

/// Velocities of schemes that move bodies with a velocity other than the end velocity of the substep.
struct DriftVelocities {
  std::vector<Twist> predicted;      // [body] velocity at the end of the substep, without constraints
  std::vector<Twist> offsets;        // [body] velocity at the end of the substep, less the drift velocity
  std::vector<Twist> joint_changes;  // [body] by joints since predict, with full effect on the drift; empty: none
  std::vector<Twist> velocities;     // [row of the set] while joint_changes are found
  std::vector<Twist> drifts;         // [row of the set] while joints are solved for them
};

template <typename Visit>
void list_fields(DriftVelocities& of, const Visit& visit) {
  auto& [predicted, offsets, joint_changes, velocities, drifts] = of;
  visit(predicted, offsets, joint_changes, velocities, drifts);
}

/// The workspace and the caches of integrators.
struct MotionWorkspace {
  FreeMotionCache free_motion;
  VelocitySteps velocity_steps;
  DriftVelocities drift;
  std::vector<Twist> constant_accelerations;  // [body] gravity, forces of this tick's inputs, constant elements
  std::vector<Twist> accelerations;           // [record] at the present stage
  std::vector<Twist> previous_accelerations;  // [body] of the substep before; empty unless the integrator needs them
  std::vector<StageRow> stages;               // [body]
  std::vector<SpringRow> springs;             // [spring whose bodies exist]
  std::vector<std::uint32_t> central_rows;    // [central force] row of its one body, or no_reference
  std::vector<SpringBlock> spring_blocks;
  std::array<std::vector<Twist>, 5> newton;  // [record] diagonal, solution, residual, direction, product
  std::uint32_t unconverged = 0;             // substeps whose equations were not solved
};

template <typename Visit>
void list_fields(MotionWorkspace& of, const Visit& visit) {
  auto& [free_motion, velocity_steps, drift, constant_accelerations, accelerations, previous_accelerations, stages,
         springs, central_rows, spring_blocks, newton, unconverged] = of;
  visit(free_motion, velocity_steps, drift, constant_accelerations, accelerations, previous_accelerations, stages,
        springs, central_rows, spring_blocks, newton, unconverged);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
