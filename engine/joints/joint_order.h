// The order in which joints are solved: the scene's order, or one with the same bits that allows batches of eight.
// SPDX-License-Identifier: MIT
//
// A joint depends only on earlier joints that move one of its bodies. Its level is one above the last such joint.
// Joints of a level share no dynamic body, and level after level gives the bits of the scene's order. A net has levels
// of many joints; a chain has as many levels as joints.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/math/vec2.h"
#include "engine/model/body_rows.h"
#include "engine/scene/joint_kinds.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct SolvedSet;
struct State;

/// The path of a joint: kernels in batches (for plain revolutes also one at a time), or the scalar path.
enum class JointPath : std::uint8_t { revolute, driven_revolute, scalar };
inline constexpr std::uint32_t joint_path_count = 3;

/// A joint of the present set.
struct JointPlace {
  std::uint32_t row;             // in State::joints
  std::uint32_t joint;           // in Model::joints
  std::uint32_t body_a, body_b;  // rows; no_reference: the world
  std::uint32_t level;
  JointKind kind;
  JointPath path;           // in levels; in scene order driven revolutes take the scalar path
  Vec2 anchor_a, anchor_b;  // as in JointModel; copied, since JointModel is large
};

/// Levels in which the joints of a body are close together, for a wavefront sweep (wavefront.h).
struct LevelSchedule {
  bool exists = false;
  std::uint32_t distance = 0;               // two joints of one body are less than this many levels apart
  std::vector<std::uint32_t> body_rows;     // dynamic bodies of joints, by the level of their first joint
  std::vector<std::uint32_t> level_bodies;  // [level] in `body_rows`, and the end
};

struct JointOrder {
  std::vector<JointPlace> places;  // in solving order
  bool in_levels = false;          // otherwise in scene order
  std::uint32_t level_count = 0;
  LevelSchedule schedule;
};

/// The first and the last joint that moves a body, in JointOrder::places before they are sorted.
struct BodyJoints {
  std::uint32_t first = 0;
  std::uint32_t last = 0;
  std::uint32_t count = 0;  // of its joints
};

/// The workspace of the ordering.
struct JointOrderWork {
  std::vector<JointPlace> sorted_places;
  std::vector<BodyJoints> body_joints;      // [body]
  std::vector<std::uint32_t> body_levels;   // [body] level of the next joint that moves it
  std::vector<std::uint32_t> level_starts;  // [level and path] in JointOrder::places
};

template <typename Visit>
void list_fields(JointOrderWork& of, const Visit& visit) {
  auto& [sorted_places, body_joints, body_levels, level_starts] = of;
  visit(sorted_places, body_joints, body_levels, level_starts);
}

/// Row of a joint's body. An id is its row as long as no body was removed. Requires: the body exists.
std::uint32_t row_of_body(const State& state, std::uint32_t id);

/// Orders the joints of the set for preparation: by level and path, or in scene order. `may_use_wavefront`: tries to
/// schedule levels for a wavefront sweep (wavefront.h). `left_out`: [row of a joint] 1 if another solver has the joint;
/// empty: no joint is left out. Gears are always left out. Requires: prepare_bodies, enter_solver_set.
void order_joints(const SolvedSet& solved, bool may_use_wavefront, std::span<const std::uint8_t> left_out,
                  JointOrderWork& work, JointOrder& out);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
