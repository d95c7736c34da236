// Clocks: the ticks that follow from the frames of a host, and exact replay with every kind of clock.
// SPDX-License-Identifier: MIT
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <variant>
#include <vector>

#include "replay/trace_reader.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/scenes.h"
#include "tool/session/clocked_inputs.h"
#include "tool/session/session.h"
#include "verifier/verify/verify.h"

namespace ticktrue::test {
namespace {

using engine::ClockKind;
using engine::ClockReport;
using engine::ClockSettings;
using engine::IntegratorKind;
using engine::TickClock;
using tool::ClockedInputs;

/// A file in the temporary directory, removed with this object.
struct TemporaryFile {
  explicit TemporaryFile(const std::string& name)
      : path((std::filesystem::temp_directory_path() / ("ticktrue_clocks_" + std::to_string(::getpid()) + "_" + name))
                 .string()) {}
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
  std::string path;
};

Scene clocked(Scene scene, ClockKind kind) {
  scene.settings.clock.kind = kind;
  return scene;
}

std::unique_ptr<ClockedInputs> inputs_for(engine::Engine& engine, const std::string& host, std::uint64_t seed) {
  auto frames = tool::open_host(host, seed);
  INFO((frames ? "" : frames.error().message));
  REQUIRE(frames.has_value());
  return std::make_unique<ClockedInputs>(engine, std::make_unique<replay::NoInputs>(engine.scene().settings.dt),
                                         *std::move(frames));
}

std::vector<std::uint64_t> hashes_under(const Scene& scene, const std::string& host, std::uint64_t tick_count) {
  const auto engine = make_engine_or_fail(scene);
  const auto inputs = inputs_for(*engine, host, 1);
  std::vector<std::uint64_t> hashes;
  for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
    const auto input = inputs->next(tick);
    REQUIRE(input.has_value());
    REQUIRE(input->has_value());
    REQUIRE(engine->step(**input, nullptr));
    hashes.push_back(root_hash(engine->state()));
  }
  return hashes;
}

struct Recorded {
  std::vector<double> dts;
  ClockReport report;
  std::uint64_t root_hash = 0;
};

/// Records, verifies the trace, and reads its ticks back.
Recorded record_clocked(const Scene& scene, const std::string& host, std::uint64_t seed, std::uint64_t tick_count) {
  const TemporaryFile file("trace.ttr");
  const auto engine = make_engine_or_fail(scene);
  const auto inputs = inputs_for(*engine, host, seed);
  replay::RecordOptions options;
  options.tick_count = tick_count;
  options.writer.overwrite = true;
  tool::TraceChoices choices;
  choices.checkpoint_interval = 50;
  const auto result = replay::record(*engine, *inputs, file.path, tool::make_trace_setup(*engine, choices),
                                     tool::make_build_facts(), options);
  INFO((result ? "" : result.error().message));
  REQUIRE(result.has_value());
  auto reader = replay::TraceReader::open(file.path);
  REQUIRE(reader.has_value());
  Recorded recorded;
  recorded.report = inputs->report();
  recorded.root_hash = result->root_hash;
  while (true) {
    const replay::TraceReader::Item& item = reader->next();
    if (std::holds_alternative<std::monostate>(item)) break;
    if (const auto* tick = std::get_if<replay::TickRecord>(&item)) recorded.dts.push_back(tick->dt);
  }
  for (const verifier::VerifyMode mode : {verifier::VerifyMode::replay, verifier::VerifyMode::restore}) {
    reader->rewind();
    verifier::VerifyOptions verify_options;
    verify_options.simulation = &engine::engine_info();
    verify_options.mode = mode;
    const verifier::Report report = verifier::verify(*reader, verify_options);
    CHECK(report.verdict == verifier::Verdict::match);
    CHECK(report.ticks_compared == recorded.dts.size());
  }
  return recorded;
}

/// A disc of 1 kg on a spring of 100 N/m along the x axis, f64, one substep.
Scene oscillator_scene(IntegratorKind integrator, double tolerance) {
  Scene scene = flight_scene(Precision::f64, body_of(disc_shape(0.1), {1, 0}));
  scene.gravity = {0, 0};
  scene.bodies[0].mass = engine::ExplicitMass{1, {}, {}};
  scene.settings.integrator = integrator;
  engine::Force spring;
  spring.kind = engine::ForceKind::spring;
  spring.body = 0;
  spring.point = {-5, 0};
  spring.rest_length = 5;
  spring.stiffness = 100;
  scene.forces.push_back(spring);
  scene.settings.clock = ClockSettings{ClockKind::adaptive, 5, tolerance, 1e-8, 1};
  return scene;
}

TEST_CASE("a fixed clock gives the same states at equal simulated time under every host",
          "[verifier][clocks][determinism]") {
  const Scene scene = stack_scene(4, 0.05, Precision::f32);
  const std::vector<std::uint64_t> expected = hashes_under(scene, "steady_60", 240);
  for (const tool::HostInfo& host : tool::hosts) {
    if (host.kind == tool::HostKind::wall) continue;
    CAPTURE(host.name);
    CHECK(hashes_under(scene, std::string(host.name), 240) == expected);
  }
  const std::vector<std::uint64_t> first(expected.begin(), expected.begin() + 12);
  CHECK(hashes_under(scene, "wall", 12) == first);
}

TEST_CASE("a variable clock gives other states under other frames, and both traces verify",
          "[verifier][clocks][determinism]") {
  const Scene scene = clocked(stack_scene(4, 0.05), ClockKind::variable);
  const Recorded one = record_clocked(scene, "jitter_60", 1, 240);
  const Recorded other = record_clocked(scene, "jitter_60", 2, 240);
  CHECK(one.root_hash != other.root_hash);
  CHECK(one.root_hash == record_clocked(scene, "jitter_60", 1, 240).root_hash);
  const auto frames = tool::open_host("jitter_60", 1);
  REQUIRE(frames.has_value());
  REQUIRE(one.dts.size() == 240);
  for (const double dt : one.dts) {
    const auto frame = (*frames)->next();
    REQUIRE(frame.has_value());
    CHECK(dt == **frame);  // bit for bit the length from the clock
    CHECK(std::fabs(dt - 1.0 / 60) <= 0.004);
  }
}

TEST_CASE("a variable clock cuts long frames and says so", "[verifier][clocks][analytic]") {
  Scene scene = clocked(stack_scene(1), ClockKind::variable);
  scene.settings.clock.dt_max = 0.06;
  const Recorded recorded = record_clocked(scene, "stutter", 3, 300);
  CHECK(recorded.report.frame_count == 300);
  CHECK(recorded.report.cut_s > 0);
  for (const double dt : recorded.dts) CHECK(dt <= 0.06);
  CHECK(recorded.report.tick_time_s + recorded.report.cut_s == Approx(recorded.report.frame_time_s).epsilon(1e-12));
}

TEST_CASE("a semi-fixed clock drops what is beyond its cap and says so", "[verifier][clocks][analytic]") {
  TickClock clock(ClockSettings{ClockKind::semi_fixed, 5, 1e-4, 1e-6, 0.1}, 0.01);
  const auto ticks_of = [&clock](double frame_s) {
    clock.add_frame(frame_s);
    int count = 0;
    while (clock.next_tick()) ++count;
    return count;
  };
  CHECK(ticks_of(0.025) == 2);
  CHECK(ticks_of(0.0251) == 3);
  CHECK(clock.report.dropped_s == 0);
  CHECK(ticks_of(0.2004) == 5);
  CHECK(clock.report.dropped_s == Approx(0.15));
  CHECK(clock.due_s() == Approx(0.0005));
  CHECK(ticks_of(0.0096) == 1);
  CHECK(clock.report.tick_count == 11);

  const Recorded recorded = record_clocked(clocked(stack_scene(1), ClockKind::semi_fixed), "stutter", 3, 600);
  CHECK(recorded.report.dropped_s > 0);
  for (const double dt : recorded.dts) CHECK(dt == 1.0 / 60);
}

TEST_CASE("the error of an adaptive clock's ticks follows its tolerance", "[verifier][clocks][analytic]") {
  const TemporaryFile frames("frames.txt");
  std::ofstream(frames.path) << "1\n1\n1\n1\n";  // long frames, whose ends do not shorten ticks
  for (const IntegratorKind kind : {IntegratorKind::semi_implicit_euler, IntegratorKind::velocity_verlet}) {
    for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8}) {
      CAPTURE(kind, tolerance);
      const auto engine = make_engine_or_fail(oscillator_scene(kind, tolerance));
      const auto inputs = inputs_for(*engine, frames.path, 1);
      double sum = 0, worst = 0;
      int count = 0;
      for (std::uint64_t tick = 0; tick < 2000; ++tick) {
        const engine::BodyReport before = engine->bodies()[0];
        const auto input = inputs->next(tick);
        REQUIRE(input.has_value());
        if (!*input) break;
        REQUIRE(engine->step(**input, nullptr));
        const double angle = 10 * (*input)->dt;
        const double exact = before.center.x * std::cos(angle) + before.velocity.x / 10 * std::sin(angle);
        const double error = std::fabs(engine->bodies()[0].center.x - exact);
        sum += error;
        worst = std::fmax(worst, error);
        ++count;
      }
      CAPTURE(count, sum / count, worst);
      CHECK(count > 20);
      CHECK(sum / count < 3 * tolerance);
      CHECK(sum / count > tolerance / 3);
      // At 1e-2 the steps have w h of 0.5 and more. Where the leading error term passes zero, the next term is as
      // large, and step doubling underestimates it.
      if (tolerance < 1e-2) CHECK(worst < 3 * tolerance);
      CHECK(inputs->report().inaccurate_count == 0);
    }
  }
}

TEST_CASE("a session under an adaptive clock replays and restores bit for bit", "[verifier][clocks][determinism]") {
  Scene scene = clocked(stack_scene(3, 0.2), ClockKind::adaptive);
  const Recorded recorded = record_clocked(scene, "steady_30", 1, 200);
  CHECK(recorded.report.trial_count >= 200);
  double shortest = 1, longest = 0;
  for (const double dt : recorded.dts) {
    shortest = std::fmin(shortest, dt);
    longest = std::fmax(longest, dt);
  }
  CHECK(shortest < longest);
  CHECK(longest <= 1.0 / 30 * (1 + 1e-12));
}

TEST_CASE("a file of frames ends the session, and a wrong line is refused with its place",
          "[verifier][clocks][corruption]") {
  const Scene scene = clocked(stack_scene(1), ClockKind::variable);
  const TemporaryFile file("frames.txt");
  std::ofstream(file.path) << "0.02\n\n0.03\n0.01\n";
  CHECK(record_clocked(scene, file.path, 1, 100).dts == std::vector<double>{0.02, 0.03, 0.01});

  for (const std::string bad : {"x", "-0.1", "0", "nan", "1e9", "0.01 0.02"}) {
    CAPTURE(bad);
    std::ofstream(file.path) << "0.02\n" << bad << "\n";
    const auto engine = make_engine_or_fail(scene);
    const auto inputs = inputs_for(*engine, file.path, 1);
    CHECK(inputs->next(0).has_value());
    const auto refused = inputs->next(1);
    REQUIRE(!refused.has_value());
    CHECK(refused.error().code == ErrorCode::invalid_input);
    CHECK(refused.error().message.find(":2: frame time: found \"" + bad + "\"") != std::string::npos);
    CHECK(inputs->frames_failed());
  }
  CHECK(!tool::open_host("no_such_host", 1).has_value());
}

TEST_CASE("settings of clocks out of range are refused", "[verifier][clocks][scene]") {
  const auto refusal = [](const ClockSettings& clock) {
    Scene scene = stack_scene(1);
    scene.settings.clock = clock;
    const Status status = engine::check_scene(scene, "s");
    return status ? std::string() : status.error().message;
  };
  CHECK(refusal({}).empty());
  CHECK(refusal({ClockKind::semi_fixed, 0}).find("s: settings.clock.ticks_per_frame_max") == 0);
  CHECK(refusal({ClockKind::adaptive, 5, 0}).find("s: settings.clock.tolerance") == 0);
  CHECK(refusal({ClockKind::adaptive, 5, 1e-4, 0}).find("s: settings.clock.dt_min") == 0);
  CHECK(
      refusal({ClockKind::adaptive, 5, 1e-4, 1e-3, 1e-4}).find("s: settings.clock.dt_min: must not be above dt_max") ==
      0);
  CHECK(refusal({ClockKind::adaptive, 5, 1e-4, 1e-3, NAN}).find("s: settings.clock.dt_max") == 0);
}

}  // namespace
}  // namespace ticktrue::test
