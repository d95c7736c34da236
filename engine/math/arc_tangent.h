// The arc tangent of two doubles, one or several at a time.
// SPDX-License-Identifier: MIT
#pragma once

namespace ticktrue::engine {

inline constexpr double half_pi_near = 0x1.921fb54442d18p+0;   // the double nearest to pi/2
inline constexpr double half_pi_rest = 0x1.1a62633145c07p-54;  // pi/2 - half_pi_near

/// atan(i / 8)
inline constexpr double atan_of_eighths[9] = {
    0,
    0x1.fd5ba9aac2f6ep-4,
    0x1.f5b75f92c80ddp-3,
    0x1.6f61941e4def1p-2,
    0x1.dac670561bb4fp-2,
    0x1.1e00babdefeb4p-1,
    0x1.4978fa3269ee1p-1,
    0x1.700a7c5784634p-1,
    0x1.921fb54442d18p-1,
};

/// The angle of (x, y), rad, -pi..pi; 0 for (0, 0); NaN if a number is a NaN or infinite. `V`: double, or a vector of
/// doubles; each lane does the same operations.
template <typename V>
[[gnu::always_inline]] inline V arc_tangent_of(V y, V x) {
  const V zero{};
  const auto all = [](double value) __attribute__((always_inline)) {
    return value - V{};
  };
  V abs_y = y < zero ? -y : y;
  V abs_x = x < zero ? -x : x;
  const V high = abs_y > abs_x ? abs_y : abs_x;
  const auto is_number = (abs_y + abs_x >= zero) & (high <= all(0x1.fffffffffffffp1023));
  // A common power of two changes no quotient, but keeps products and sums in range.
  const V scale = high > all(0x1p1000) ? all(0x1p-100) : (high < all(0x1p-900) ? all(0x1p100) : all(1));
  abs_y *= scale;
  abs_x *= scale;
  const auto is_steep = abs_y > abs_x;
  const V below = is_steep ? abs_x : abs_y;
  V above = is_steep ? abs_y : abs_x;
  above = above > zero ? above : all(1);
  // atan(below / above) = atan(c) + atan((t - c) / (1 + c t)) with c the nearest eighth: the code adds a half and
  // truncates.
  const V share = below / above * all(8) + all(0.5);
  const V round = all(0x1p52);
  const V nearest = (share + round) - round;
  const V eighths = nearest > share ? nearest - all(1) : nearest;
  const V c = eighths * all(0.125);
  const V u = (below - c * above) / (above + c * below);  // |u| <= 1/16
  const V z = u * u;
  V p = all(1.0 / 13.0);
  p = p * z - all(1.0 / 11.0);
  p = p * z + all(1.0 / 9.0);
  p = p * z - all(1.0 / 7.0);
  p = p * z + all(1.0 / 5.0);
  p = p * z - all(1.0 / 3.0);
  V base = zero;
  for (int i = 1; i < 9; ++i) base = eighths >= all(i) ? all(atan_of_eighths[i]) : base;
  const V octant = base + (u + u * z * p);
  V angle = is_steep ? all(half_pi_near) - (octant - all(half_pi_rest)) : octant;
  angle = x < zero ? all(2 * half_pi_near) - (angle - all(2 * half_pi_rest)) : angle;
  angle = y < zero ? -angle : angle;
  angle = high == zero ? zero : angle;
  return is_number ? angle : all(__builtin_nan(""));
}

}  // namespace ticktrue::engine
