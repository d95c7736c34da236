// Springs of joints over one substep: exact damping, no gain or loss of amplitude, stable however stiff.
// SPDX-License-Identifier: MIT
// Source: derived here, from the exact solution of x'' + 2 a x' + w^2 x = f (any text on linear oscillators) and the
// secant series (Abramowitz and Stegun, 4.3.69).
//
// A substep of semi-implicit Euler is v' = v + (change), x' = x + h v'. The spring chooses its impulse so that
//   v' = D v - (A / h) (x - f / w^2),
// with f the acceleration by everything else and (x, h v) relative to the anchors. The map (x, h v) -> (x', h v') has
// determinant D and trace 1 + D - A. The exact flow over h has determinant e^(-2 a h) and trace 2 e^(-a h) cos(y), y =
// h sqrt(w^2 - a^2). Hence, with s = e^(-a h),
//   D = s^2,   A = (1 - s)^2 + 2 s (1 - cos(y))                               a < w
//   D = e^(-h p) e^(-h q),   A = (1 - e^(-h p)) (1 - e^(-h q))                 a >= w; p, q = a +- sqrt(a^2 - w^2)
// The second map has eigenvalues in 0..1: with at least critical damping, the spring comes to rest without overshoot.
// cos(y) repeats for y > pi, so that a spring too stiff for the substep would act like a soft one. cos(y) is therefore
// replaced by
//   1 / (1 + y^2 / 2 + 5 y^4 / 24),
// the series of the secant. Its error is 61 y^6 / 720, and its value is in 0..1 for every y. No spring swings faster
// than a quarter period per substep. Without damping D = 1 and 0 < A < 2: the map preserves areas and is a rotation, so
// the amplitude is constant. Velocities are half a substep before the positions (as everywhere in this scheme). A swing
// from rest at x0 therefore has the amplitude x0 / cos(y / 2), at most sqrt(2) x0. x = f / w^2, v = 0 is a fixed point:
// the deflection under a load is exact.
#pragma once

#include "engine/math/real.h"
#include "engine/math/vec2.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// impulse = -mass (velocity_gain v + position_gain x + change_gain (u - v)), with v the velocity before the substep
/// and u the velocity with all other impulses.
struct SpringStep {
  Real velocity_gain = 0;  // 1 - D
  Real position_gain = 0;  // A / h, 1/s
  Real change_gain = 0;    // 1 - A / (h w)^2
};

/// For a spring with angular frequency w (`stiffness_per_mass` = w^2) and x' coefficient 2 a (`damping_per_mass`).
/// Requires: both >= 0, one > 0; h > 0.
SpringStep make_spring_step(double stiffness_per_mass, double damping_per_mass, double h);

/// The total impulse of a spring row. `speed`: with `old_impulse` in it; inv_mass > 0: of the row.
inline Real spring_impulse(const SpringStep& step, Real inv_mass, Real error, Real start_speed, Real speed,
                           Real old_impulse) {
  const Real others = (speed - inv_mass * old_impulse) - start_speed;
  return -(step.velocity_gain * start_speed + step.position_gain * error + step.change_gain * others) / inv_mass;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
