// Plain revolute joints (no spring, limits or motor) in batches: packed from the state, solved by kernels, stored back.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "engine/joints/batched/revolute_lanes.h"
#include "engine/joints/joint_order.h"
#include "engine/math/vec2.h"
#include "engine/model/poison.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct BodyMass;
struct JointRange;
struct JointWorkspace;
struct SolvedSet;
struct SolverBodies;
struct State;

/// The order in which plain revolute joints are solved.
enum class RevoluteOrder : std::uint8_t {
  levels,  // eight at a time: the joints of a batch share no moving body
  serial,  // in the order of the scene, one at a time
};

/// The joints of a batch: `count` places of the plan from `first` on.
struct JointSpan {
  std::uint32_t first;
  std::uint32_t count;
  std::uint32_t level;
};

struct RevoluteBatches {
  RevoluteOrder order = RevoluteOrder::levels;
  std::vector<RevoluteBatch> batches;  // the plan says how many batches are in use
  std::vector<RevoluteArms> arms;      // [front, batch]; each thread of a wavefront sweep has its own
  Softness soft;
};

template <typename Visit>
void list_fields(RevoluteBatches& of, const Visit& visit) {
  auto& [order, batches, arms, soft] = of;
  visit(order, in_place(batches), in_place(arms), soft);
}

/// The least number of batches per chunk for which a second thread pays.
inline constexpr std::size_t joint_batches_per_chunk_least = 10;

/// Prefetches the state row of a joint several places ahead: joints of a level are scattered in memory.
void prefetch_joint(const State& state, std::span<const JointPlace> places, std::size_t place);

/// Clears a batch: empty lanes read the dummy body and write to a sink.
void clear_revolutes(const SolverBodies& bodies, RevoluteBatch& batch);
/// Gives a batch the sink of this chunk.
void redirect_to_sink(const SolverBodies& bodies, RevoluteBatch& batch, std::size_t chunk);

/// The point constraint of a joint, in one lane. `anchor_a`, `anchor_b`, `center_offset` and `impulse` as in JointWork.
void fill_revolute_lane(RevoluteBatch& batch, std::size_t lane, std::uint32_t row, const BodyMass& a, const BodyMass& b,
                        Vec2 anchor_a, Vec2 anchor_b, Vec2 center_offset, Vec2 impulse);

/// Allocates the batches of the plan.
void reserve_revolutes(const SolvedSet& solved, JointWorkspace& work);
/// Fills the batches first..last-1 of the plan.
void fill_revolutes(const SolvedSet& solved, JointWorkspace& work, std::size_t first, std::size_t last);
/// Gives each chunk of a range a sink of its own.
void separate_revolute_sinks(const SolverBodies& bodies, const JointRange& range, RevoluteBatches& revolutes);
/// Batches per chunk of a range. A wavefront sweep does not share ranges.
std::size_t chunk_size_of(const JointWorkspace& work, const JointRange& range);
void warm_start_revolutes(const SolvedSet& solved, JointWorkspace& work, const JointRange& range, Poses poses,
                          std::size_t front);
void solve_revolutes(const SolvedSet& solved, JointWorkspace& work, const JointRange& range, Bias bias,
                     std::size_t front);
/// Stores the impulses of the batches first..last-1 in state.joints, as forces.
void store_revolutes(const RevoluteBatches& revolutes, std::size_t first, std::size_t last, Real h, State& state);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
