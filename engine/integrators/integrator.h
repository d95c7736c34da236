// Integrators: how velocities and positions advance over one step of length h, apart from constraints.
// SPDX-License-Identifier: MIT
//
// A solver calls begin once per tick, then predict and drift once per substep: predict gives the velocity with which
// bodies drift, constraints correct it, drift moves them by it.
#pragma once

#include "engine/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Integrator {
  IntegratorKind kind;
  void (*begin)(const Model& model, const State& state, Scratch& scratch, Real h);
  void (*predict)(const Model& model, const State& state, Scratch& scratch, Real h);
  void (*drift)(const Model& model, const State& state, Scratch& scratch, Real h);
};

const Integrator& integrator(IntegratorKind kind);

void begin_semi_implicit_euler(const Model& model, const State& state, Scratch& scratch, Real h);
void predict_semi_implicit_euler(const Model& model, const State& state, Scratch& scratch, Real h);
void drift_semi_implicit_euler(const Model& model, const State& state, Scratch& scratch, Real h);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
