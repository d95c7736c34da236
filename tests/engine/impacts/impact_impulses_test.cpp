// Impulses on islands: Newton's law, Coulomb's bound, and no energy from nowhere.
// SPDX-License-Identifier: MIT
#define TICKTRUE_PRECISION f64
#include "engine/impacts/impact_impulses.h"

#include <cmath>

#include "base/random.h"
#include "tests/support/catch.h"

namespace ticktrue::test {

namespace f64 = engine::f64;

TEST_CASE("impulses on islands follow Newton and Coulomb", "[engine][impacts][arms][property]") {
  int stuck = 0, slid = 0;
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    Random random(seed);
    CAPTURE(seed);
    f64::ImpactMobility k;
    k.normal = std::exp(random.real(-3, 3));
    k.tangent = std::exp(random.real(-3, 3));
    k.coupling = random.real(-0.99, 0.99) * std::sqrt(k.normal * k.tangent);
    const f64::ImpactSpeeds speeds = {random.real(0.1, 10), random.real(-10, 10), random.real(0, 2), random.real(0, 1)};
    const auto [normal, tangent] = f64::impulses_on_islands(k, speeds);
    const double scale = 1 + speeds.restitution;
    const double limit = speeds.friction * normal;
    CHECK(normal > 0);
    CHECK(std::fabs(tangent) <= limit * (1 + 1e-12));
    const double leaving = -speeds.closing + k.normal * normal + k.coupling * tangent;
    CHECK_THAT(leaving, Catch::Matchers::WithinAbs(speeds.restitution * speeds.closing, 1e-9 * speeds.closing));
    // Of the impulses that stop the point: it sticks, or friction at its bound acts against the slip that is left.
    const double slip = speeds.tangent + (k.coupling * normal + k.tangent * tangent) / scale;
    const bool sticks = std::fabs(slip) < 1e-9;
    if (!sticks) {
      CHECK_THAT(std::fabs(tangent), Catch::Matchers::WithinAbs(limit, 1e-9 * (limit + 1e-9)));
      CHECK(slip * tangent <= 0);
    }
    ++(sticks ? stuck : slid);
    const double work = normal * (-speeds.closing + (k.normal * normal + k.coupling * tangent) / 2) +
                        tangent * (speeds.tangent + (k.coupling * normal + k.tangent * tangent) / 2);
    CHECK(work <= 1e-12);
  }
  CHECK(stuck > 200);
  CHECK(slid > 200);
}

TEST_CASE("where the normal holds the tangent, friction is left out", "[engine][impacts][arms]") {
  // A body that can only turn about (0, 0), hit at (1, .5) along y: both rows move the same degree of freedom.
  const f64::ImpactMobility k = {1, 0.25, -0.5};
  const auto [normal, tangent] = f64::impulses_on_islands(k, {2, 1, 0.8, 0.5});
  CHECK(tangent == 0);
  CHECK(normal == 3);
}

TEST_CASE("points that part get no impulse", "[engine][impacts][arms]") {
  const auto [normal, tangent] = f64::impulses_on_islands({1, 1, 0}, {-1, 2, 0.5, 0.5});
  CHECK(normal == 0);
  CHECK(tangent == 0);
}

}  // namespace ticktrue::test
