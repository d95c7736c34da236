// Inertia against joints that pull harder than substeps can follow.
// SPDX-License-Identifier: MIT
// Source: Tournier, Nesme, Gilles, Faure, "Stable Constrained Dynamics", SIGGRAPH 2015, and Andrews, Teichmann, Kry,
// "Geometric Stiffness for Real-time Constrained Multibody Dynamics", Eurographics 2017: the stiffness that constraint
// forces have by themselves because bodies turn under them.
//
// A force F at an arm r turns with the body: it is a spring of F r about the centre. Impulses kept from one substep to
// the next make it an explicit one, which is stable up to h^2 F r = 4 I; half of that is left to neighbours that
// turn the other way. Beyond it constraints see the inertia that meets the limit. The body's own spin is not touched.
#pragma once

#include "engine/math/real.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Model;
struct State;
struct Scratch;

/// Raises inertias in scratch.masses, where the joints' forces of the last substep ask for it. h: of a substep, s.
/// Requires: prepare_bodies, order_joints.
void raise_inertias(const State& state, Scratch& scratch, Real h);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
