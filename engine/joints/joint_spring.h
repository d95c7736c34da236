// Springs of joints over one substep: exact damping, no gain or loss of amplitude, stable however stiff.
// SPDX-License-Identifier: MIT
// Source: derived here, from the exact solution of x'' + 2 a x' + w^2 x = f (any text on linear oscillators) and the
// secant series (Abramowitz and Stegun, 4.3.69).
//
// A substep of semi-implicit Euler is v' = v + (change), x' = x + h v'. Let the spring choose its impulse so that
//   v' = D v - (A / h) (x - f / w^2),
// f the acceleration that everything else gives, (x, h v) relative to the anchors. The map (x, h v) -> (x', h v') has
// determinant D and trace 1 + D - A. The exact flow over h has determinant e^(-2 a h) and trace 2 e^(-a h) cos(y),
// y = h sqrt(w^2 - a^2). Hence, with s = e^(-a h),
//   D = s^2,   A = (1 - s)^2 + 2 s (1 - cos(y))                               a < w
//   D = e^(-h p) e^(-h q),   A = (1 - e^(-h p)) (1 - e^(-h q))                 a >= w; p, q = a +- sqrt(a^2 - w^2)
// The second has eigenvalues in 0..1: whatever is damped at least critically comes to rest without turning back.
// cos(y) repeats for y > pi: a spring too stiff for the substep would pass for a soft one. So cos(y) is taken as
//   1 / (1 + y^2 / 2 + 5 y^4 / 24),
// the series of the secant: off by 61 y^6 / 720, and in 0..1 for every y: no spring swings faster than a quarter
// turn per substep. Without damping D = 1 and 0 < A < 2: the map keeps areas and is a turn, so the amplitude is kept
// for ever. Velocities belong half a substep before the positions (as everywhere in this scheme), so a swing from rest
// at x0 has the amplitude x0 / cos(y / 2), at most sqrt(2) x0. x = f / w^2, v = 0 is a fixed point: the sag under a
// load is exact.
#pragma once

#include "engine/math/real.h"
#include "engine/math/vec2.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// impulse = -mass (loss v + pull x + give (u - v)): v the velocity before the substep, u with all impulses but this.
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
