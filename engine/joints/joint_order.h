// The order in which joints are solved: that of the scene, or one that gives the same bits and lets eight run at once.
// SPDX-License-Identifier: MIT
//
// A joint sees of earlier ones only those that moved one of its bodies. So joints get levels, each one above the last
// joint before it that moves a body of its own: joints of a level share no moving body, and level after level gives the
// bits of the scene's order. A net has levels of many joints, a chain has as many levels as joints.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/math/vec2.h"
#include "engine/model/body_rows.h"
#include "engine/scene/joint_kinds.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Model;
struct State;
struct Scratch;

/// How a joint is solved: by kernels, in batches with others (pins also in a row), or by itself.
enum class JointWay : std::uint8_t { pin, hinge, single };
inline constexpr std::uint32_t joint_way_count = 3;

/// A joint of the group that is being solved.
struct JointPlace {
  std::uint32_t row;             // in State::joints
  std::uint32_t joint;           // in Model::joints
  std::uint32_t body_a, body_b;  // rows; no_reference: the world
  std::uint32_t level;
  JointKind kind;
  JointWay way;             // where joints are in levels; in scene order hinges are solved by themselves
  Vec2 anchor_a, anchor_b;  // as in JointModel, which is large and elsewhere
};

/// Row of a joint's body. Ids are rows as long as no body was removed. Requires: the body exists.
std::uint32_t row_of_body(const State& state, std::uint32_t id);

/// Fills the places of the plan with the group's joints in the order in which they are to be prepared: by level, in
/// each level the pins first, then the hinges; or in scene order. `may_be_woven`: looks for levels that can be
/// (weave.h). Requires: prepare_bodies, enter_solver_set.
void order_joints(const Model& model, const State& state, Scratch& scratch, bool may_be_woven);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
