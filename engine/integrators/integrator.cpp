// The table of integrators.
// SPDX-License-Identifier: MIT
#include "engine/integrators/integrator.h"

#include "engine/integrators/flow.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr std::array<Integrator, integrators.size()> table{{
    {IntegratorKind::semi_implicit_euler, begin_semi_implicit_euler, predict_semi_implicit_euler,
     drift_semi_implicit_euler, 0},
    {IntegratorKind::explicit_euler, begin_explicit_euler, predict_explicit_euler, drift_on_start, share_of_start},
    {IntegratorKind::velocity_verlet, begin_velocity_verlet, predict_velocity_verlet, drift_velocity_verlet,
     share_of_mean},
    {IntegratorKind::position_verlet, begin_position_verlet, predict_position_verlet, drift_on_mean, share_of_mean},
    {IntegratorKind::rk4, begin_rk4, predict_rk4, drift_on_mean, share_of_mean},
    {IntegratorKind::yoshida4, begin_yoshida4, predict_yoshida4, drift_yoshida4, 0},
    {IntegratorKind::implicit_midpoint, begin_implicit_midpoint, predict_implicit_midpoint, drift_on_mean,
     share_of_mean},
    {IntegratorKind::thesis_verlet, begin_thesis_verlet, predict_thesis_verlet, drift_on_mean, share_of_mean},
    {IntegratorKind::thesis_rk4, begin_thesis_rk4, predict_thesis_rk4, drift_on_mean, share_of_mean},
}};

}  // namespace

const Integrator& integrator(IntegratorKind kind) {
  return info_of(table, kind);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
