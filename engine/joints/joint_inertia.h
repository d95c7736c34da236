// Larger inertias against joint forces that substeps cannot follow.
// SPDX-License-Identifier: MIT
// Source: Tournier, Nesme, Gilles, Faure, "Stable Constrained Dynamics", SIGGRAPH 2015, and Andrews, Teichmann, Kry,
// "Geometric Stiffness for Real-time Constrained Multibody Dynamics", Eurographics 2017: the stiffness that constraint
// forces have by themselves because bodies turn under them.
//
// A force F at an arm r rotates with the body and acts as a spring of stiffness F r about the centre. Warm starting
// makes this spring explicit, which is stable up to h^2 F r = 4 I. Half of that is reserved for a neighbour that
// rotates the other way. Beyond the limit, constraints use the inertia that meets it. The body's own spin is
// unaffected.
#pragma once

#include "engine/math/real.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Model;
struct State;
struct Scratch;

/// Raises inertias in scratch.masses where the joint forces of the last substep require it. h: of a substep, s.
/// Requires: prepare_bodies, order_joints.
void raise_inertias(const State& state, Scratch& scratch, Real h);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
