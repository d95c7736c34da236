// Ticks that a simulation cannot do: told when they are met, in a recording and in a verification; what came before
// them is safe.
// SPDX-License-Identifier: MIT
#include <filesystem>

#include "engine/scene/scene_binary.h"
#include "tests/support/engine_runs.h"
#include "tests/support/scenes.h"
#include "tests/verifier/toy_variants.h"
#include "tool/session/session.h"

namespace ticktrue::test {
namespace {

using replay::EndReason;
using verifier::Report;
using verifier::Verdict;
using verifier::VerifyMode;

std::uint64_t ticks_possible = 0;          // of LimitedToy; set before one is made
ErrorCode undone_code = ErrorCode::limit;  // likewise

/// A toy that cannot do more than so many ticks.
class LimitedToy : public ToySimulation {
 public:
  using ToySimulation::ToySimulation;
  Status accept(const TickInput& input) const override {
    const Status did = last_tick();
    return did ? ToySimulation::accept(input) : did;
  }
  Status step(const TickInput& input, StageObserver* observer) override {
    Status did = last_tick();
    if (did) did = ToySimulation::step(input, observer);
    return did ? last_tick() : did;
  }

 private:
  Status last_tick() const {
    if (world.tick_count <= ticks_possible) return {};
    return Error{undone_code, "tick " + std::to_string(ticks_possible) + ": toys: found more than expected",
                 "take fewer"};
  }
};

constexpr VerifyMode modes[] = {VerifyMode::replay, VerifyMode::restore, VerifyMode::twice};

Result<replay::RecordResult> record_limited(const std::string& path, bool repeatable, bool overwrite = false) {
  LimitedToy simulation(6);
  ScriptedInputs source(lively_script, repeatable);
  replay::TraceSetup setup = toy_setup(6);
  setup.checkpoint_interval = 8;
  replay::RecordOptions options;
  options.tick_count = 60;
  options.writer = plain_writer();
  options.writer.overwrite = overwrite;
  return replay::record(simulation, source, path, setup, toy_facts, options);
}

}  // namespace

TEST_CASE("a recording ends before a tick that cannot be done, and verifies in every mode",
          "[verifier][recorder][hostile]") {
  const TemporaryFolder folder;
  for (const bool repeatable : {false, true})
    for (const std::uint64_t possible : {30, 31, 32, 40}) {  // with and without inputs, at a checkpoint
      CAPTURE(repeatable, possible);
      ticks_possible = possible;
      const std::string path = folder.file("limited.ttr");
      const auto result = record_limited(path, repeatable, true);
      REQUIRE_FALSE(result.has_value());
      CHECK(result.error().code == ErrorCode::limit);
      CHECK(contains(result.error().message, "tick " + std::to_string(possible) + ": toys"));
      CHECK(result.error().hint ==
            "take fewer; the trace was closed and holds the " + std::to_string(possible) + " ticks before");
      const Bytes trace = read_file(path);
      const ReadTrace read = read_all(trace);
      CHECK(read.ticks.size() == possible);
      REQUIRE(read.tail.end.has_value());
      CHECK(read.tail.end->reason == EndReason::interrupted);
      CHECK(read.tail.end->note == result.error().message);
      for (const SimulationInfo& info : {SimulationInfo{"ticktrue.toy", 1, &make_toy<LimitedToy>},
                                         SimulationInfo{"ticktrue.toy", 1, &make_toy<ToySimulation>}})
        for (const VerifyMode mode : modes) {
          const Report report = verify_bytes(trace, info, mode);
          CHECK(report.verdict == Verdict::match);
          CHECK(report.ticks_compared == possible);
        }
    }
}

TEST_CASE("where the first tick cannot be done nothing is left behind", "[verifier][recorder][hostile]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("limited.ttr");
  ticks_possible = 0;
  CHECK(record_limited(path, true).error().hint == "take fewer");
  CHECK_FALSE(std::filesystem::exists(path));
  write_file(path, Bytes{1, 2, 3});
  CHECK_FALSE(record_limited(path, true, true).has_value());
  CHECK(read_file(path) == Bytes{1, 2, 3});
}

namespace {

/// Verifies in every mode up to a tick that is not done for this reason.
void check_undone(ErrorCode code, Verdict expected) {
  const Bytes trace = toy_trace_with(toy_setup(6), 60, 8);
  const SimulationInfo info{"ticktrue.toy", 1, &make_toy<LimitedToy>};
  undone_code = code;
  for (const std::uint64_t possible : {0, 31, 40})
    for (const VerifyMode mode : modes)
      for (const unsigned thread_count : {1u, 4u}) {
        CAPTURE(possible, mode, thread_count);
        ticks_possible = possible;
        verifier::VerifyOptions options = verify_options(info, mode);
        options.thread_count = thread_count;
        options.reopen = [&]() -> std::unique_ptr<verifier::TraceSource> {
          auto reader = replay::TraceReader::open_bytes(trace, "toy.ttr");
          if (!reader) return nullptr;
          return std::make_unique<verifier::OwnedReaderSource>(std::move(*reader));
        };
        const Report report = verify_bytes(trace, options);
        CHECK(report.verdict == expected);
        CHECK(contains(report.reason, "tick " + std::to_string(possible) + ": toys"));
        CHECK_FALSE(report.divergence.has_value());
      }
  undone_code = ErrorCode::limit;
}

}  // namespace

TEST_CASE("a recorded tick that cannot be done here is not comparable, in every mode", "[verifier][hostile]") {
  check_undone(ErrorCode::limit, Verdict::not_comparable);
}

TEST_CASE("a tick that gives other bits when it is done again is not reproducible, in every mode", "[verifier][kept]") {
  check_undone(ErrorCode::inconsistent, Verdict::not_reproducible);
}

TEST_CASE("a scene whose shapes come together records up to the tick that has too many pairs",
          "[verifier][recorder][hostile]") {
  Scene scene = empty_scene();
  scene.gravity = {0, 0};
  for (int i = 0; i < 40; ++i) {
    const Point from{1.0 + 0.5 * (i % 7), 1.0 + 0.5 * (i / 7)};
    scene.bodies.push_back(body_of(disc_shape(0.1), from));
    scene.bodies.back().velocity = {-4 * from.x, -4 * from.y};
  }
  engine::EngineOptions few;
  few.pair_count_max = 60;
  const TemporaryFolder folder;
  const std::string path = folder.file("meeting.ttr");
  const auto engine = make_engine_or_fail(scene, few);
  replay::NoInputs source(scene.settings.dt);
  replay::RecordOptions options;
  options.tick_count = 60;
  options.writer = plain_writer();
  const auto result = replay::record(*engine, source, path, verifier::make_trace_setup(*engine, {}),
                                     verifier::make_build_facts(), options);
  REQUIRE_FALSE(result.has_value());
  CHECK(contains(result.error().message, ": pairs of shapes near each other: found more than 60"));
  const Bytes trace = read_file(path);
  const std::size_t tick_count = read_all(trace).ticks.size();
  CHECK(tick_count > 3);
  CHECK(tick_count < 30);
  for (const VerifyMode mode : modes) {
    const Report report = verify_bytes(trace, engine::engine_info(), mode);
    CHECK(report.verdict == Verdict::match);
    CHECK(report.ticks_compared == tick_count);
  }
  // A session without a trace ends in the same tick.
  const auto again = make_engine_or_fail(scene, few);
  const auto run = verifier::run_session(*again, source, 60, {});
  REQUIRE_FALSE(run.has_value());
  CHECK(run.error().message == result.error().message);
  CHECK(run.error().code == ErrorCode::limit);
}

}  // namespace ticktrue::test
