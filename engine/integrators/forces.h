// Force elements: their parts of a body's constants; accelerations and exact flows of elements that depend on positions
// or velocities.
// SPDX-License-Identifier: MIT
// Constant forces and linear drags are constants of a body (Model::body_forces, BodyModel::linear_damping). Each scheme
// with exact damping therefore treats them exactly. Central forces and springs depend on positions, quadratic drags and
// dampers on velocities. Schemes evaluate these elements at each of their stages.
#pragma once

#include "engine/integrators/motion_rows.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Fills the fields of the model for force elements. Requires: model.scene and model.bodies.
void add_forces(Model& model);

/// Finds the rows of the bodies on which elements act. Call at the start of a tick. Elements whose bodies were removed
/// are left out. Requires: prepare_bodies.
void prepare_forces(const SolvedSet& solved, MotionWorkspace& work);

/// Adds the accelerations of quadratic drags and dampers at the present velocities to work.accelerations. A drag
/// removes at most `drag_rate_max` of a velocity, 1/s. Explicit schemes need this limit to stay stable.
void add_velocity_forces(const SolvedSet& solved, MotionWorkspace& work, Real drag_rate_max);

enum class FlowOrder : std::uint8_t { forward, backward };

/// Velocities after time h under quadratic drags and dampers alone. Each element acts exactly, one after the other, so
/// that no velocity is ever reversed, however large the coefficient. Backward order gives the mirror image, which
/// symmetric schemes need.
void flow_velocity_forces(const SolvedSet& solved, MotionWorkspace& work, Real h, FlowOrder order);

/// r^exponent, -3 <= exponent <= 3.
Real power(Real r, int exponent);

/// The present line and tension of a spring.
struct SpringLine {
  bool exists = false;  // false: the two points coincide, so that no line exists
  Vec2 along;           // from A to B
  Vec2 arm_a, arm_b;    // m
  Real length = 0;      // m
  Real tension = 0;     // N, > 0 pulls
  Real inv_mass = 0;    // 1/kg, of the relative velocity along the line
};
SpringLine line_of(const SpringRow& spring, const SolverBodies& bodies);

/// Velocity of B's anchor relative to A's along the line, m/s.
Real speed_along(const SpringRow& spring, const SpringLine& line, const SolverBodies& bodies);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
