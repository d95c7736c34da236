// Soft constraints: a spring and damper in terms of the time step, so that any stiffness is stable.
// SPDX-License-Identifier: MIT
// Source: Catto, "Soft Constraints", GDC 2011; Catto, "Solver2D", 2024 (bias rate, mass scale, impulse scale).
#pragma once

#include "engine/math/trig.h"
#include "engine/math/vec2.h"
#include "engine/simd/lanes.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// With w = 2 pi hertz: a1 = 2 zeta + h w, a2 = h w a1, a3 = 1 / (1 + a2);
/// bias rate = w / a1, mass scale = a2 a3, impulse scale = a3.
inline Softness make_soft(Real hertz, Real damping_ratio, Real h) {
  const Real omega = Real(2 * pi) * hertz;
  const Real a1 = 2 * damping_ratio + h * omega;
  const Real a2 = h * omega * a1;
  const Real a3 = 1 / (1 + a2);
  return {omega / a1, a2 * a3, a3};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
