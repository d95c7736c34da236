// The mouse joint: a soft constraint between a point of a body and the pointer that has pressed it.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "engine/contacts/soft.h"
#include "engine/math/vec2.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct SolvedSet;
struct SolverBodies;
struct State;

/// A PointerRow prepared for one tick.
struct MouseJoint {
  std::uint32_t pointer;  // row
  std::uint32_t body;     // row
  Real inv_mass;
  Real inv_inertia;
  Vec2 anchor;  // from the centre of mass, world axes at the start of the tick, m
  Vec2 offset;  // from the target to the held point at the start of the tick, m
  Softness soft;
  Real impulse_max;  // N s
  Vec2 impulse;      // N s, accumulated
};

/// Prepares the mouse joints of the pointers that hold bodies of a set.
void prepare_mouse_joints(const SolvedSet& solved, std::vector<MouseJoint>& joints);
void warm_start_mouse_joints(const std::vector<MouseJoint>& joints, SolverBodies& bodies);
void solve_mouse_joints(std::vector<MouseJoint>& joints, SolverBodies& bodies);
/// Stores the impulses in state.pointers, as forces.
void store_mouse_joints(const std::vector<MouseJoint>& joints, State& state, Real h);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
