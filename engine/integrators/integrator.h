// Integrators: the change of velocities and positions over one step of length h, without constraints.
// SPDX-License-Identifier: MIT
//
// A solver calls begin once per tick, then predict and drift once per substep. predict computes the velocities at the
// end of the substep, constraints correct them, and drift moves bodies. Most schemes move bodies with a velocity other
// than the end velocity. Constraints change that velocity as a force would (flow.h).
#pragma once

#include "engine/integrators/motion_rows.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Integrator {
  IntegratorKind kind;
  void (*begin)(const SolvedSet& solved, MotionWorkspace& work, Real h);
  void (*predict)(const SolvedSet& solved, MotionWorkspace& work, Real h);
  void (*drift)(const SolvedSet& solved, MotionWorkspace& work, Real h);
  Real drift_share;  // of move_bodies_by_drift; 0: bodies move with the end velocity
};

const Integrator& integrator(IntegratorKind kind);

void begin_semi_implicit_euler(const SolvedSet& solved, MotionWorkspace& work, Real h);
void predict_semi_implicit_euler(const SolvedSet& solved, MotionWorkspace& work, Real h);
void drift_semi_implicit_euler(const SolvedSet& solved, MotionWorkspace& work, Real h);
void begin_explicit_euler(const SolvedSet& solved, MotionWorkspace& work, Real h);
void predict_explicit_euler(const SolvedSet& solved, MotionWorkspace& work, Real h);
void begin_velocity_verlet(const SolvedSet& solved, MotionWorkspace& work, Real h);
void predict_velocity_verlet(const SolvedSet& solved, MotionWorkspace& work, Real h);
void drift_velocity_verlet(const SolvedSet& solved, MotionWorkspace& work, Real h);
void begin_position_verlet(const SolvedSet& solved, MotionWorkspace& work, Real h);
void predict_position_verlet(const SolvedSet& solved, MotionWorkspace& work, Real h);
void begin_rk4(const SolvedSet& solved, MotionWorkspace& work, Real h);
void predict_rk4(const SolvedSet& solved, MotionWorkspace& work, Real h);
void begin_yoshida4(const SolvedSet& solved, MotionWorkspace& work, Real h);
void predict_yoshida4(const SolvedSet& solved, MotionWorkspace& work, Real h);
void drift_yoshida4(const SolvedSet& solved, MotionWorkspace& work, Real h);
void begin_implicit_midpoint(const SolvedSet& solved, MotionWorkspace& work, Real h);
void predict_implicit_midpoint(const SolvedSet& solved, MotionWorkspace& work, Real h);
void begin_thesis_verlet(const SolvedSet& solved, MotionWorkspace& work, Real h);
void predict_thesis_verlet(const SolvedSet& solved, MotionWorkspace& work, Real h);
void begin_thesis_rk4(const SolvedSet& solved, MotionWorkspace& work, Real h);
void predict_thesis_rk4(const SolvedSet& solved, MotionWorkspace& work, Real h);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
