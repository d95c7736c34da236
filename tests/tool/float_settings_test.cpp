// Runs under wrong floating point settings are refused with the reason, on the calling thread and on each worker.
// SPDX-License-Identifier: MIT
#include <atomic>
#include <cfenv>
#include <string>

#include "base/parallel/jobs.h"
#include "base/parallel/workers.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "tests/support/catch.h"
#include "tests/verifier/toy_variants.h"
#include "tool/environment/arithmetic_probe.h"
#include "tool/environment/float_environment.h"
#include "tool/session/session.h"
#include "verifier/verify/verify.h"

namespace ticktrue::test {
namespace {

/// Rounds upwards during its lifetime.
class RoundingUpward {
 public:
  RoundingUpward() : before_(std::fegetround()) { std::fesetround(FE_UPWARD); }
  ~RoundingUpward() { std::fesetround(before_); }
  RoundingUpward(const RoundingUpward&) = delete;
  RoundingUpward& operator=(const RoundingUpward&) = delete;

 private:
  int before_;
};

TEST_CASE("verify: a thread that rounds upward compares nothing and says so",
          "[verifier][float_environment][analytic]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 10, 8);
  verifier::Report report;
  {
    const RoundingUpward upward;
    report = verify_bytes(trace, toy_info, verifier::VerifyMode::replay);
  }
  CHECK(report.verdict == verifier::Verdict::not_comparable);
  CHECK_THAT(report.reason, Catch::Contains("rounding upward"));
  CHECK(report.ticks_compared == 0);
}

TEST_CASE("a run of a thread that rounds upward is refused", "[verifier][float_environment][analytic]") {
  const auto scene = engine::make_builtin_scene("stack?boxes=2");
  REQUIRE(scene.has_value());
  const auto made = engine::make_engine(*scene);
  REQUIRE(made.has_value());
  replay::NoInputs inputs(scene->settings.dt);
  std::string message;
  {
    const RoundingUpward upward;
    const auto result = tool::run_session(**made, inputs, 5, {});
    if (!result) message = result.error().message;
  }
  CHECK_THAT(message, Catch::Contains("rounding upward"));
}

TEST_CASE("each worker thread looks at its own settings before it takes a job",
          "[verifier][float_environment][parallel][analytic]") {
  std::atomic<int> done{0};
  CHECK(run_jobs(20, 4, [&](std::size_t) { ++done; }).has_value());
  CHECK(done == 20);
  CHECK(run_jobs(0, 4, [&](std::size_t) { ++done; }).has_value());
  CHECK(done == 20);
  // A new thread inherits the settings of the thread that starts it, so every worker refuses.
  Status status;
  {
    const RoundingUpward upward;
    status = run_jobs(20, 4, [&](std::size_t) { ++done; });
  }
  REQUIRE_FALSE(status.has_value());
  CHECK_THAT(status.error().message, Catch::Contains("rounding upward"));
  CHECK(done == 20);
}

TEST_CASE("workers of a tick whose arithmetic is another are refused",
          "[verifier][float_environment][workers][analytic]") {
  const RoundingUpward upward;
  const auto made = make_workers(2);
  REQUIRE_FALSE(made.has_value());
  CHECK_THAT(made.error().message, Catch::Contains("rounding upward"));
}

TEST_CASE("the probe gives every part the digest of every platform, and another one under another rounding",
          "[verifier][float_environment][probe][golden]") {
  for (const tool::ProbePart& part : tool::probe_arithmetic()) {
    CAPTURE(part.name);
    CHECK(part.is_right());
  }
  std::vector<tool::ProbePart> parts;
  {
    const RoundingUpward upward;
    parts = tool::probe_arithmetic();
  }
  for (const tool::ProbePart& part : parts) {
    CAPTURE(part.name);
    CHECK_FALSE(part.is_right());
  }
}

}  // namespace
}  // namespace ticktrue::test
