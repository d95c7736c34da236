// Pins in batches: packed from the state, solved by kernels, stored back.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "engine/contacts/contact_batch.h"
#include "engine/joints/batched/revolute_lanes.h"
#include "engine/joints/joint_order.h"
#include "engine/math/vec2.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct BodyMass;
struct JointRange;

/// How pins are solved.
enum class RevoluteOrder : std::uint8_t {
  levels,  // eight at a time: those of a batch share no moving body
  serial,  // one after the other
};

/// The joints of a batch: those of the plan's places from `first` on.
struct JointSpan {
  std::uint32_t first;
  std::uint32_t count;
  std::uint32_t level;
};

struct RevoluteBatches {
  RevoluteOrder order = RevoluteOrder::levels;
  std::vector<RevoluteBatch> batches;  // as many are in use as the plan has
  std::vector<RevoluteArms> arms;      // [line of passes, batch], so that each thread has its own (wavefront.h)
  Softness soft;
};

/// So many batches are worth another thread's while.
inline constexpr std::size_t joint_batches_per_chunk_least = 10;

/// Levels take joints from everywhere: asks for the memory of one some places later.
void prefetch_joint(const State& state, const Scratch& scratch, std::size_t place);

/// Empties a batch: lanes that hold nothing read the resting record and write to one that nobody reads.
void clear_revolutes(const Scratch& scratch, RevoluteBatch& batch);
/// Lets a batch write what nobody reads to the record of this chunk.
void redirect_to_sink(const Scratch& scratch, RevoluteBatch& batch, std::size_t chunk);

/// The point of a joint, in one lane: `anchor_a`, `anchor_b`, `center_offset` and `impulse` as in JointWork.
void fill_revolute_lane(RevoluteBatch& batch, std::size_t lane, std::uint32_t row, const BodyMass& a, const BodyMass& b,
                        Vec2 anchor_a, Vec2 anchor_b, Vec2 center_offset, Vec2 impulse);

/// Room for the batches of the plan.
void reserve_revolutes(Scratch& scratch);
/// Fills the batches first..last-1 of the plan.
void fill_revolutes(const State& state, Scratch& scratch, std::size_t first, std::size_t last, Real h);
/// Makes the batches first..last-1 ready for threads and says how many one takes. Requires: pins of one level, or one
/// thread.
std::size_t split_revolutes(Scratch& scratch, std::uint32_t first, std::uint32_t last);
void warm_start_revolutes(Scratch& scratch, const JointRange& range, Poses poses, std::size_t line);
void solve_revolutes(Scratch& scratch, const JointRange& range, Real h, Bias bias, std::size_t line);
/// Impulses of the batches first..last-1 back to state.joints, as forces.
void store_revolutes(const Scratch& scratch, State& state, std::size_t first, std::size_t last, Real h);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
