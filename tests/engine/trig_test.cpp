// Sine, cosine and arc tangent against the C library, their symmetries and their exact bits.
// SPDX-License-Identifier: MIT
#include "engine/math/trig.h"

#include <cmath>
#include <limits>

#include "base/bytes.h"
#include "tests/support/catch.h"

using namespace ticktrue;
using namespace ticktrue::engine;

namespace {
constexpr double infinite = std::numeric_limits<double>::infinity();

double ulps(double got, double expected) {
  const double magnitude = std::fabs(expected);
  return std::fabs(got - expected) / (std::nextafter(magnitude, infinite) - magnitude);
}
}  // namespace

TEST_CASE("sine and cosine are within 2 ulp of 1 of the exact value", "[engine][trig][analytic]") {
  double worst = 0;
  const auto check = [&](double x) {
    const SinCos got = sin_cos(x);
    const double error = std::fmax(std::fabs(got.sin - std::sin(x)), std::fabs(got.cos - std::cos(x)));
    if (error > worst) worst = error;
  };
  for (int i = -200000; i <= 200000; ++i) check(i * 1e-4);
  for (int i = 0; i < 200000; ++i) check(-1e6 + i * 10.00004321);
  for (int i = 0; i < 60000; ++i) check(i * (pi / 4) + 1e-9 * (i % 7 - 3));
  CHECK(worst <= 2 * 0x1p-52);
}

TEST_CASE("sine and cosine keep the symmetries of the functions to the last bit", "[engine][trig][analytic]") {
  for (int i = 0; i < 100000; ++i) {
    const double x = i * 0.00731 * (1 + i % 13);
    const SinCos right = sin_cos(x), left = sin_cos(-x);
    if (left.sin != -right.sin || left.cos != right.cos) FAIL("asymmetric at " << x);
  }
  CHECK(bits_of(sin_cos(0.0).sin) == bits_of(0.0));
  CHECK(bits_of(sin_cos(-0.0).sin) == bits_of(-0.0));
  CHECK(sin_cos(0.0).cos == 1.0);
}

TEST_CASE("what is turned by quarters stands exactly upright, and nothing else is moved", "[engine][trig][analytic]") {
  for (int quarters = -4000; quarters <= 4000; ++quarters) {
    const SinCos rotation = pose_sin_cos(quarters * (pi / 2));
    const int rest = ((quarters % 4) + 4) % 4;
    CAPTURE(quarters);
    REQUIRE(rotation.cos == (rest == 0 ? 1 : rest == 2 ? -1 : 0));
    REQUIRE(rotation.sin == (rest == 1 ? 1 : rest == 3 ? -1 : 0));
  }
  for (int i = -200000; i <= 200000; ++i) {
    const double x = i * 1.00001e-4;
    if (bits_of(pose_sin_cos(x).sin) != bits_of(sin_cos(x).sin) ||
        bits_of(pose_sin_cos(x).cos) != bits_of(sin_cos(x).cos))
      FAIL("moved at " << x);
  }
  CHECK(bits_of(pose_sin_cos(-0.0).sin) == bits_of(-0.0));
  CHECK(pose_sin_cos(1e-9).sin == 1e-9);
  CHECK(std::isnan(pose_sin_cos(infinite).sin));
}

TEST_CASE("sine and cosine stay on the unit circle for any finite angle and are NaN for others",
          "[engine][trig][analytic]") {
  for (double x = 1e6; x < 1e308; x *= 7.3) {
    const SinCos s = sin_cos(x);
    CAPTURE(x);
    REQUIRE(std::fabs(s.sin * s.sin + s.cos * s.cos - 1) < 1e-15);
  }
  CHECK(std::fabs(sin_cos(3e6).sin - std::sin(3e6)) < 1e-9);
  CHECK(std::fabs(sin_cos(-1e9).cos - std::cos(1e9)) < 1e-6);
  for (const double x : {infinite, -infinite, std::numeric_limits<double>::quiet_NaN()}) {
    CHECK(std::isnan(sin_cos(x).sin));
    CHECK(std::isnan(sin_cos(x).cos));
  }
  const double largest = std::numeric_limits<double>::max();
  CHECK(std::fabs(sin_cos(largest).sin) <= 1);
}

TEST_CASE("arc tangent is within 4 ulp of the exact value in all directions", "[engine][trig][analytic]") {
  double worst = 0;
  const auto check = [&](double y, double x) {
    const double error = ulps(arc_tangent(y, x), std::atan2(y, x));
    if (error > worst) worst = error;
  };
  for (int i = -700; i <= 700; ++i)
    for (int j = -300; j <= 300; ++j)
      if (i != 0 || j != 0) check(i * 0.0137, j * 0.031);
  for (int i = -1000; i <= 1000; ++i) {
    check(1, std::ldexp(1.0, i / 2));
    check(std::ldexp(1.37, i), std::ldexp(-1.11, i));
  }
  for (int i = 1; i < 100000; ++i) check(i * 1e-5, 1);
  CHECK(worst <= 4);
}

TEST_CASE("arc tangent keeps its symmetries, its corners and its range", "[engine][trig][analytic]") {
  CHECK(arc_tangent(0, 0) == 0);
  CHECK(arc_tangent(0, 2) == 0);
  CHECK(arc_tangent(0, -2) == pi);
  CHECK(arc_tangent(3, 0) == pi / 2);
  CHECK(arc_tangent(-3, 0) == -pi / 2);
  CHECK(arc_tangent(1, 1) == pi / 4);
  CHECK(arc_tangent(1e308, 1e308) == pi / 4);
  CHECK(arc_tangent(5e-324, 5e-324) == pi / 4);
  CHECK(arc_tangent(5e-324, 1e308) == 0);
  CHECK(std::isnan(arc_tangent(infinite, 1)));
  CHECK(std::isnan(arc_tangent(1, std::numeric_limits<double>::quiet_NaN())));
  for (int i = 1; i < 2000; ++i) {
    const double y = i * 0.37, x = 200 - i * 0.21;
    if (arc_tangent(-y, x) != -arc_tangent(y, x)) FAIL("asymmetric at " << y << ", " << x);
  }
  for (int i = -1000; i <= 1000; ++i) {
    const SinCos s = sin_cos(i * 0.003);
    CHECK(std::fabs(arc_tangent(s.sin, s.cos) - i * 0.003) < 1e-15 * (1 + std::fabs(i * 0.003)));
  }
}

TEST_CASE("trigonometry has the pinned bits that every platform must give", "[engine][trig][golden]") {
  CHECK(bits_of(sin_cos(1.0).sin) == 0x3feaed548f090ceeu);
  CHECK(bits_of(sin_cos(1.0).cos) == 0x3fe14a280fb5068cu);
  CHECK(bits_of(sin_cos(-2.5).sin) == 0xbfe326af0dcfcab0u);
  CHECK(bits_of(sin_cos(123456.789).sin) == 0xbfeff50e60ab53f9u);
  CHECK(bits_of(sin_cos(123456.789).cos) == 0x3faa74d27c41b22au);
  CHECK(bits_of(sin_cos(1e22).sin) == 0x3febf809b25497f6u);
  CHECK(bits_of(sin_cos(pi).sin) == 0x3ca1a62633145c07u);
  CHECK(bits_of(arc_tangent(1, 3)) == 0x3fd4978fa3269ee2u);
  CHECK(bits_of(arc_tangent(-2, -0.3)) == 0xbffb83d5c13f26b9u);
  CHECK(bits_of(arc_tangent(0.7, -0.1)) == 0x3ffb67312cd2f434u);
}
