// Makes tool/study/reference_numbers.h: double pendulums and rolling polygons, integrated in long double.
// SPDX-License-Identifier: MIT
// Source: Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I", 1993, II.1 (the classical scheme);
// McGeer, "Passive Dynamic Walking", 1990 (the rimless wheel: impacts of a rolling polygon).
//
// The target is not part of `all`:
//   cmake --build build/release --target reference_numbers
//   build/release/reference_numbers > tool/study/reference_numbers.h
// The program computes each number with a step and with half of that step. It fails if the two results differ by more
// than 1e-13.
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace {

using Real = long double;
const Real pi = 3.14159265358979323846264338327950288L;
constexpr int sample_count = 20;

template <std::size_t n, typename Rate>
std::array<Real, n> stepped(const std::array<Real, n>& x, Real h, Rate rate) {
  const auto moved = [&](const std::array<Real, n>& k, Real t) {
    std::array<Real, n> out;
    for (std::size_t i = 0; i < n; ++i) out[i] = x[i] + t * k[i];
    return out;
  };
  const auto k1 = rate(x);
  const auto k2 = rate(moved(k1, h / 2));
  const auto k3 = rate(moved(k2, h / 2));
  const auto k4 = rate(moved(k3, h));
  std::array<Real, n> out;
  for (std::size_t i = 0; i < n; ++i) out[i] = x[i] + h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  return out;
}

// Two points of 1 kg on rods of 1 m, g = 10, from rest. Angles are measured from hanging down; both begin at `start`.
std::vector<Real> double_pendulum(Real start, Real seconds, long steps_per_sample) {
  const auto rate = [](const std::array<Real, 4>& s) {
    const Real a = s[0], b = s[1], wa = s[2], wb = s[3], g = 10;
    const Real d = a - b, c = std::cos(d), n = std::sin(d);
    // 2 a'' + c b'' = -n wb^2 - 2 g sin a;  c a'' + b'' = n wa^2 - g sin b
    const Real p = -n * wb * wb - 2 * g * std::sin(a);
    const Real q = n * wa * wa - g * std::sin(b);
    const Real det = 2 - c * c;
    return std::array<Real, 4>{wa, wb, (p - c * q) / det, (2 * q - c * p) / det};
  };
  std::array<Real, 4> s{start, start, 0, 0};
  std::vector<Real> out;
  const Real h = seconds / sample_count / static_cast<Real>(steps_per_sample);
  for (int sample = 0; sample < sample_count; ++sample) {
    for (long i = 0; i < steps_per_sample; ++i) s = stepped(s, h, rate);
    out.push_back(s[0]);
    out.push_back(s[1]);
  }
  return out;
}

// A regular polygon (1 kg, circumradius 0.5 m, uniform) rolls to the right over a level floor, g = 10. The polygon
// neither slips nor bounces. It starts on a flat side and turns about its right corner at `spin` rad/s. Returns the
// angle turned so far.
// About the corner: (I + m R^2) phi'' = m g R sin phi, phi from upright. When an edge lands, the next corner becomes
// the pivot. The spin is then multiplied by (I + m R^2 cos(2 pi / n)) / (I + m R^2), or set to 0 if that factor is
// negative.
std::vector<Real> rolling(int n, Real spin, Real seconds, long steps_per_sample) {
  const Real radius = 0.5L, g = 10, half = pi / n;
  const Real inertia = radius * radius / 6 * (2 + std::cos(2 * half));  // of 1 kg
  const Real total = inertia + radius * radius;
  const Real kept = std::fmax(Real(0), (inertia + radius * radius * std::cos(2 * half)) / total);
  const auto rate = [&](const std::array<Real, 2>& s) {
    return std::array<Real, 2>{s[1], g * radius / total * std::sin(s[0])};
  };
  std::array<Real, 2> s{-half, spin};  // phi, phi'
  Real base = half;                    // turned = base + phi
  bool rests = false;
  std::vector<Real> out;
  const Real h = seconds / sample_count / static_cast<Real>(steps_per_sample);
  for (int sample = 0; sample < sample_count; ++sample) {
    for (long i = 0; i < steps_per_sample && !rests; ++i) {
      Real left = h;
      while (left > 0 && !rests) {
        const std::array<Real, 2> next = stepped(s, left, rate);
        if (std::fabs(next[0]) <= half) {
          s = next;
          break;
        }
        // Finds the time of landing within this step by bisection.
        Real low = 0, high = left;
        for (int k = 0; k < 80; ++k) {
          const Real middle = (low + high) / 2;
          (std::fabs(stepped(s, middle, rate)[0]) <= half ? low : high) = middle;
        }
        s = stepped(s, low, rate);
        left -= high;
        const Real side = s[0] > 0 ? 1 : -1;
        base += side * 2 * half;
        s = {-side * half, s[1] * kept};
        if (std::fabs(s[1]) < 1e-9L) rests = true;
      }
    }
    out.push_back(base + s[0]);
  }
  return out;
}

void print(const char* name, const std::vector<Real>& coarse, const std::vector<Real>& fine, Real tolerance,
           const char* indent) {
  for (std::size_t i = 0; i < fine.size(); ++i)
    if (std::fabs(coarse[i] - fine[i]) > tolerance) {
      std::fprintf(stderr, "%s: sample %zu: found a change of %Lg, expected at most %Lg\n", name, i,
                   std::fabs(coarse[i] - fine[i]), tolerance);
      std::exit(1);
    }
  for (std::size_t i = 0; i < fine.size(); ++i)
    std::printf("%s%.17Lg,%s", i % 5 == 0 ? indent : " ", fine[i], i % 5 == 4 || i + 1 == fine.size() ? "\n" : "");
}

void pendulum(const char* name, Real start) {
  std::printf("inline constexpr double %s[]{\n", name);
  print(name, double_pendulum(start, 2, 20000), double_pendulum(start, 2, 40000), 1e-13L, "    ");
  std::printf("};\n");
}

}  // namespace

int main() {
  std::printf(
      "// Reference numbers, made by tool/study/generator/reference_numbers.cpp; see there.\n"
      "// SPDX-License-Identifier: MIT\n#pragma once\n\n// clang-format off\n\nnamespace ticktrue::tool {\n\n"
      "// Angles of a double pendulum from hanging down, rad: upper, lower at 2 s / 20, 4 s / 20, ... 2 s.\n");
  pendulum("double_pendulum_90", pi / 2);
  pendulum("double_pendulum_120", 2 * pi / 3);
  std::printf(
      "\n// Angle by which a polygon of n = 3..16 corners has rolled, rad, at 2 s / 20 .. 2 s: [n - 3][sample].\n"
      "inline constexpr double rolling_spin = 3.1;  // rad/s at the start: fast enough to pass a square, too slow to "
      "take off\n"
      "inline constexpr double rolled_angle[14][20]{\n");
  for (int n = 3; n <= 16; ++n) {
    std::printf("    {\n");
    print("rolling", rolling(n, 3.1L, 2, 4000), rolling(n, 3.1L, 2, 8000), 1e-11L, "        ");
    std::printf("    },\n");
  }
  std::printf("};\n\n}  // namespace ticktrue::tool\n");
}
