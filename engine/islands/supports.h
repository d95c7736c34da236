// The supports of each body, and their compliances.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

#include "engine/islands/islands.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The number of substeps for which compliances are given.
inline constexpr int reference_substeps = 4;
inline constexpr std::uint32_t not_carried = 0xffffffff;

/// Lists, for each body of an island that is solved, the bodies that it touches or is joined to. `h`: s, of a substep
/// at reference_substeps.
void list_supports(const Model& model, const State& state, TickLists& tick, IslandWork& work, Real h);

/// Whether a joint's bodies move along an axis.
inline bool slides(const JointRow& joint) {
  return joint.body_a != no_reference && (joint.kind == static_cast<std::uint32_t>(JointKind::prismatic) ||
                                          joint.kind == static_cast<std::uint32_t>(JointKind::wheel));
}

/// Finds depths, breadth first: steps from the nearest immovable body. support_order lists carried bodies, nearest
/// first. Where loads are measured, connected bodies without an immovable support follow, with depths from the heaviest
/// of them. Requires: list_supports.
void find_depths(const Model& model, const State& state, IslandWork& work);

inline std::span<const Support> supports_of(const IslandWork& work, std::uint32_t row) {
  return {work.supports.data() + work.support_start[row], work.support_start[row + 1] - work.support_start[row]};
}

/// Calls `use` with each support of a body that is one step nearer to the ground.
template <typename Use>
void for_each_carrier(const IslandWork& work, std::uint32_t row, Use use) {
  for (const Support& support : supports_of(work, row))
    if (work.support_depth[support.other] + 1 == work.support_depth[row]) use(support);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
