// Coefficients of a spring over one substep.
// SPDX-License-Identifier: MIT
// Source: joint_spring.h.
#include "engine/joints/joint_spring.h"

#include "engine/math/exponential.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

SpringStep make_spring_step(double stiffness_per_mass, double damping_per_mass, double h) {
  constexpr double exponent_max = 1e18;  // e^-1e18 is 0 as well
  const double w2 = stiffness_per_mass;
  const double a = 0.5 * damping_per_mass;
  const double discriminant = a * a - w2;
  if (discriminant >= 0) {
    const double fast = a + __builtin_sqrt(discriminant);
    const double slow = w2 / fast;  // a - sqrt(...) would cancel digits
    const double x = h * fast < exponent_max ? h * fast : exponent_max;
    const double y = h * slow;
    const Decay p = decay_over(x);
    const Decay q = decay_over(y);
    return {static_cast<Real>(x * p.mean + p.factor * (y * q.mean)), static_cast<Real>((x * p.mean) * (y * q.mean) / h),
            static_cast<Real>(1 - p.mean * q.mean)};
  }
  const Decay p = decay_over(h * a);
  const double y2 = h * h * -discriminant;
  const double beyond = y2 * (0.5 + y2 * (5.0 / 24));  // secant - 1
  const double gone = h * a * p.mean;                  // 1 - s
  const double swing = 2 * p.factor * (beyond / (1 + beyond));
  const double full = gone * gone + swing;  // A
  return {static_cast<Real>(gone * (1 + p.factor)), static_cast<Real>(full / h),
          static_cast<Real>(1 - full / (h * h * w2))};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
