// Pictures appear at the requested rate, however long single pictures take.
// SPDX-License-Identifier: MIT
#include "tool/play/window/pacing.h"

#include <cmath>

#include "tests/support/catch.h"

namespace ticktrue {
namespace {

using play::Pacer;

Pacer::Clock::duration seconds(double value) {
  return std::chrono::duration_cast<Pacer::Clock::duration>(std::chrono::duration<double>(value));
}

/// The time of `count` pictures on a simulated clock, s. A wait ends `oversleep_s` late. `work_s` is the time of the
/// n-th picture.
template <typename Work>
double time_of(int count, double oversleep_s, Work work_s) {
  Pacer pacer;
  const Pacer::Clock::time_point start;
  Pacer::Clock::time_point now = start, first = start;
  for (int i = 0; i <= count; ++i) {
    now += seconds(work_s(i));
    const Pacer::Clock::time_point due = pacer.next(now);
    if (due > now) now = due + seconds(oversleep_s);
    if (i == 0) first = now;
  }
  return std::chrono::duration<double>(now - first).count();
}

TEST_CASE("1200 pictures take 20 s, also where waits end late and some pictures are slow", "[play][pacing]") {
  const auto even = [](int) { return 0.004; };
  const auto uneven = [](int i) { return 0.002 + 0.011 * std::abs(std::sin(i)); };
  const auto some_slow = [](int i) { return i % 50 == 49 ? 0.045 : 0.004; };
  for (const double oversleep_s : {0.0, 0.0011}) {
    CAPTURE(oversleep_s);
    // The error is at most one late wait, plus one late picture at the end.
    CHECK(std::abs(time_of(1200, oversleep_s, even) - 20) < 0.0012);
    CHECK(std::abs(time_of(1200, oversleep_s, uneven) - 20) < 0.0012);
    CHECK(std::abs(time_of(1200, oversleep_s, some_slow) - 20) < 0.045);
  }
}

TEST_CASE("a long halt is forgotten but for a twentieth of a second", "[play][pacing]") {
  const auto one_halt = [](int i) { return i == 600 ? 3.0 : 0.001; };
  const double seconds_taken = time_of(1200, 0, one_halt);
  CHECK(seconds_taken > 20 + 3 - play::picture_s_max - 2 * play::picture_s);
  CHECK(seconds_taken < 20 + 3);
}

TEST_CASE("time passes evenly although pictures come unevenly, and a halt counts as a twentieth of a second",
          "[play][pacing]") {
  Pacer pacer;
  Pacer::Clock::time_point now;
  double sum_s = 0;
  for (int i = 0; i < 600; ++i) {
    now += seconds(i == 300 ? 2.0 : i % 7 == 3 ? 0.03 : 0.004);
    now = std::max(now, pacer.next(now)) + seconds(0.0005);
    CAPTURE(i);
    CHECK(pacer.passed_s() == Approx(i == 300 ? play::picture_s_max : play::picture_s).margin(1e-8));
    sum_s += pacer.passed_s();
  }
  CHECK(sum_s == Approx(599 * play::picture_s + play::picture_s_max).epsilon(1e-6));
}

TEST_CASE("pictures that take longer than their time follow each other without a wait", "[play][pacing]") {
  CHECK(time_of(100, 0, [](int) { return 0.03; }) == Approx(3.0));
}

}  // namespace
}  // namespace ticktrue
