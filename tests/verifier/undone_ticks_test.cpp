// Ticks that a simulation cannot do: told when they are met, in a recording and in a verification; what came before
// them is safe.
// SPDX-License-Identifier: MIT
#include <filesystem>

#include "engine/clock/step_control.h"
#include "engine/scene/scene_binary.h"
#include "tests/support/engine_runs.h"
#include "tests/support/scenes.h"
#include "tests/verifier/toy_variants.h"
#include "tool/report_page/animation.h"
#include "tool/session/clocked_inputs.h"
#include "tool/session/plugin_session.h"
#include "tool/session/session.h"
#include "tool/study/measures.h"
#include "tool/study/stress/stress.h"
#include "verifier/compare/stage_states.h"
#include "verifier/inject/inject.h"
#include "verifier/report/exit_codes.h"

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

namespace {

// Which of the simulations that are made in turn is limited, and how its run ended.
struct Chosen {
  int made_count = 0;
  int limited = -1;               // this one alone; -1: none
  int first_limited = 1'000'000;  // this one and all after it
  int wrong = 0;                  // this one ends a tick in another state:
  std::optional<std::uint64_t> differs_at = {};
  bool failed = false;  // one of them could not do a tick
};
Chosen chosen;

/// A toy that is limited, or wrong, if its number is chosen.
class ChosenToy : public LimitedToy {
 public:
  explicit ChosenToy(std::uint32_t body_count) : LimitedToy(body_count), number_(chosen.made_count++) {}
  Status accept(const TickInput& input) const override {
    Status accepted = is_limited() ? LimitedToy::accept(input) : ToySimulation::accept(input);
    chosen.failed = chosen.failed || !accepted;
    return accepted;
  }
  Status step(const TickInput& input, StageObserver* observer) override {
    Status did = is_limited() ? LimitedToy::step(input, observer) : ToySimulation::step(input, observer);
    if (number_ == chosen.wrong && chosen.differs_at && world.tick_count == *chosen.differs_at + 1) ++world.score;
    chosen.failed = chosen.failed || !did;
    return did;
  }

 private:
  bool is_limited() const { return number_ == chosen.limited || number_ >= chosen.first_limited; }

  int number_;
};
const SimulationInfo chosen_info{"ticktrue.toy", 1, &make_toy<ChosenToy>};

/// The time before a tick of the lively session.
double lively_time_s(std::uint64_t tick) {
  double time_s = 0;
  for (std::uint64_t before = 0; before < tick; ++before) time_s += (*lively_script(before))->first;
  return time_s;
}

}  // namespace

TEST_CASE("whichever run of a verification cannot do a tick, the verdict is no match", "[verifier][hostile]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 60, 8);
  ticks_possible = 31;
  int failed_count = 0;
  for (const ErrorCode code : {ErrorCode::limit, ErrorCode::inconsistent})
    for (const VerifyMode mode : modes)
      for (int limited = 0;; ++limited) {
        undone_code = code;
        chosen = {};
        chosen.limited = limited;
        const Report report = verify_bytes(trace, chosen_info, mode);
        if (limited >= chosen.made_count) break;
        CAPTURE(code, mode, limited, report.reason);
        CHECK((report.verdict == Verdict::match) == !chosen.failed);
        if (chosen.failed) ++failed_count;
        if (mode == VerifyMode::twice && chosen.failed) {
          CHECK(report.verdict == Verdict::not_reproducible);
          CHECK(contains(report.reason, "tick 31: one run does it, the other does not: tick 31: toys"));
        }
      }
  CHECK(failed_count > 6);
  undone_code = ErrorCode::limit;
}

TEST_CASE("a mismatch whose second run cannot do a tick is not reproducible, and says the tick",
          "[verifier][hostile]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 60, 8);
  for (const ErrorCode code : {ErrorCode::limit, ErrorCode::inconsistent})
    for (const std::uint64_t possible : {20, 35, 37}) {  // before the checkpoint of tick 32, behind it, the mismatch
      CAPTURE(code, possible);
      undone_code = code;
      ticks_possible = possible;
      chosen = {};
      chosen.differs_at = 37;
      chosen.wrong = 1;  // the first one only shows its columns
      chosen.first_limited = 2;
      const Report report = verify_bytes(trace, chosen_info);
      CHECK(chosen.failed);
      CHECK(report.verdict == Verdict::not_reproducible);
      const std::string tick = std::to_string(possible);
      CHECK(contains(report.reason, "two runs here differ from tick " + tick +
                                        " on: the second run could not do this tick: tick " + tick + ": toys"));
      REQUIRE(report.divergence.has_value());
      CHECK(report.divergence->tick == possible);
      CHECK(report.divergence->time_s == lively_time_s(possible));
      CHECK_FALSE(report.divergence->stage.has_value());
    }
  undone_code = ErrorCode::limit;
}

TEST_CASE("behind a divergence, a tick that cannot be done ends the spread, and the trace still has its end",
          "[verifier][hostile]") {
  const Bytes trace = toy_trace_with(full_toy_setup(6, 0, 100), 60, 8);
  SimulationInfo info = toy_info;
  info.make = [](ByteView setup) -> Result<std::unique_ptr<Simulation>> {
    auto toy = std::make_unique<LimitedToy>(ByteReader(setup).u32());
    toy->disturb = [](ToySimulation& self, std::size_t stage) {
      if (stage == ToySimulation::move_stage && self.world.tick_count == 38) self.bodies[0].hits += 1;
    };
    return std::unique_ptr<Simulation>(std::move(toy));
  };
  ticks_possible = 40;
  const Report report = verify_bytes(trace, info);
  CHECK(report.verdict == Verdict::diverged);
  REQUIRE(report.divergence);
  CHECK(report.divergence->tick == 37);
  REQUIRE(report.divergence->spread.size() == 2);
  CHECK(report.divergence->spread[1].tick == 39);
  REQUIRE(report.end);
  CHECK(report.end->tail.condition == replay::TraceCondition::complete);
  CHECK(report.end->tail.ticks_intact == 60);
}

TEST_CASE("the states of a tick are an error where it or one before it cannot be done",
          "[verifier][against][hostile]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 60, 100);
  ticks_possible = 31;
  for (const std::uint64_t tick : {31, 32, 50}) {
    CAPTURE(tick);
    replay::TraceReader reader = open_trace(trace);
    verifier::ReaderSource source(reader);
    const auto states = verifier::stage_states(source, SimulationInfo{"ticktrue.toy", 1, &make_toy<LimitedToy>}, tick);
    REQUIRE_FALSE(states.has_value());
    CHECK(states.error().code == ErrorCode::limit);
    CHECK(contains(states.error().message, "tick 31: toys"));
  }
}

TEST_CASE("inject reports no success where a run cannot do a tick", "[verifier][inject][hostile]") {
  replay::TraceSetup in_cells = toy_setup(6);
  in_cells.detail = replay::Detail::cells;
  int failed_count = 0;
  for (const replay::TraceSetup& setup : {toy_setup(6), full_toy_setup(6, 0, 100), in_cells}) {
    const Bytes trace = toy_trace_with(setup, 60, 8);
    ticks_possible = 31;
    for (int limited = 0;; ++limited) {
      chosen = {};
      chosen.limited = limited;
      verifier::InjectOptions options;
      options.simulation = &chosen_info;
      options.count = 2;
      options.tick = 31;
      replay::TraceReader reader = open_trace(trace);
      const auto report = verifier::inject(reader, options);
      if (limited >= chosen.made_count) break;
      CAPTURE(setup.detail, limited, chosen.failed);
      if (!chosen.failed) continue;
      ++failed_count;
      CHECK((!report || report->exit_code() != 0));
    }
  }
  CHECK(failed_count > 6);
}

TEST_CASE("a session of a simulation that is not ours ends with the tick that cannot be done",
          "[verifier][session][hostile]") {
  for (const std::uint64_t possible : {0, 31}) {
    ticks_possible = possible;
    LimitedToy simulation(6);
    ScriptedInputs source(lively_script);
    const auto run = cli::run_ticks(simulation, source, 60);
    REQUIRE_FALSE(run.has_value());
    CHECK(run.error().code == ErrorCode::limit);
    CHECK(contains(run.error().message, "tick " + std::to_string(possible) + ": toys"));
  }
  ticks_possible = 60;
  LimitedToy simulation(6);
  ScriptedInputs source(lively_script);
  const auto run = cli::run_ticks(simulation, source, 60);
  REQUIRE(run.has_value());
  CHECK(run->tick_count == 60);
}

TEST_CASE("a replay of a trace that is not ours ends before the tick that cannot be done",
          "[verifier][session][hostile]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 60, 8);
  const auto replayed = [&](std::uint64_t possible, bool differs) {
    ticks_possible = possible;
    chosen = {};
    chosen.limited = 0;
    if (differs) chosen.differs_at = 7;
    ChosenToy simulation(6);
    replay::TraceReader reader = open_trace(trace);
    return cli::replay_with(simulation, reader, 1000, 1000, 1, false);  // prints no tick
  };
  CHECK(replayed(60, false) == verifier::exit_ok);
  CHECK(replayed(31, false) == verifier::exit_not_comparable);
  CHECK(replayed(31, true) == verifier::exit_finding);
}

TEST_CASE("the animation of a recorded run ends at a tick that cannot be done", "[verifier][report][hostile]") {
  using tool::MatchRange;
  using tool::TickMatch;
  const auto strip_of = [](std::uint64_t possible) {
    ticks_possible = possible;
    chosen = {};
    chosen.differs_at = 20;
    chosen.first_limited = 1;
    const Bytes trace = toy_trace_with(toy_setup(6), 32, 8);
    replay::TraceReader reader = open_trace(trace);
    tool::AnimationOptions options;
    options.simulation = &chosen_info;
    return tool::make_animation(reader, options).match_ranges;
  };
  const auto known_ticks = [](const std::vector<MatchRange>& strip) {
    std::uint64_t count = 0;
    for (const MatchRange& part : strip)
      if (part.match == TickMatch::differs_known) count += part.last - part.first + 1;
    return count;
  };
  CHECK(known_ticks(strip_of(100)) == 8);  // from the checkpoint at tick 24 on
  CHECK(known_ticks(strip_of(27)) == 3);   // ticks 24, 25, 26
}

namespace {

/// Discs that come together: more and more pairs.
Scene coming_together() {
  Scene scene = empty_scene();
  scene.gravity = {0, 0};
  for (int i = 0; i < 40; ++i) {
    const Point from{1.0 + 0.5 * (i % 7), 1.0 + 0.5 * (i / 7)};
    scene.bodies.push_back(body_of(disc_shape(0.1), from));
    scene.bodies.back().velocity = {-4 * from.x, -4 * from.y};
  }
  return scene;
}

engine::EngineOptions few_pairs() {
  engine::EngineOptions few;
  few.pair_count_max = 60;
  return few;
}

constexpr const char* too_many = ": pairs of shapes near each other: found more than 60";

}  // namespace

TEST_CASE("a measured run is an error in the tick that cannot be done, and stays one", "[verifier][study][hostile]") {
  const Scene scene = coming_together();
  auto all = tool::Run::make(scene, few_pairs());
  auto one_by_one = tool::Run::make(scene, few_pairs());
  REQUIRE(all.has_value());
  REQUIRE(one_by_one.has_value());
  const Status advanced = all->advance(60);
  REQUIRE_FALSE(advanced.has_value());
  CHECK(advanced.error().code == ErrorCode::limit);
  CHECK(contains(advanced.error().message, too_many));
  CHECK_FALSE(all->advance(1).has_value());
  const TickInput input{scene.settings.dt, {}};
  Result<double> did = one_by_one->step(input);
  for (int tick = 1; tick < 60 && did; ++tick) did = one_by_one->step(input);
  REQUIRE_FALSE(did.has_value());
  CHECK(did.error().message == advanced.error().message);
}

TEST_CASE("an adaptive clock that tries a tick that cannot be done is an error and leaves the engine as it was",
          "[verifier][clocks][hostile]") {
  Scene scene = coming_together();
  scene.settings.clock = {engine::ClockKind::adaptive, 5, 1e-2, 1e-6, 0.1};
  const auto engine = make_engine_or_fail(scene, few_pairs());
  engine::StepControl control(*engine);
  engine::ClockReport report;
  std::uint64_t hash = root_hash(engine->state());
  Result<double> dt = control.choose(*engine, 0.02, report);
  int tick_count = 0;
  for (; tick_count < 200 && dt; ++tick_count) {
    REQUIRE(engine->step({*dt, {}}, nullptr));
    hash = root_hash(engine->state());
    dt = control.choose(*engine, 0.02, report);
  }
  CHECK(tick_count > 3);
  REQUIRE_FALSE(dt.has_value());
  CHECK(dt.error().code == ErrorCode::limit);
  CHECK(contains(dt.error().message, too_many));
  CHECK(root_hash(engine->state()) == hash);
  CHECK(engine->accept({1e-6, {}}).has_value());
  // A recording keeps the ticks before, as it does where the tick itself cannot be done.
  const TemporaryFolder folder;
  const std::string path = folder.file("adaptive.ttr");
  const auto again = make_engine_or_fail(scene, few_pairs());
  auto frames = tool::open_host("steady_60", 1);
  REQUIRE(frames.has_value());
  tool::ClockedInputs source(*again, std::make_unique<replay::NoInputs>(scene.settings.dt), *std::move(frames));
  replay::RecordOptions options;
  options.tick_count = 200;
  options.writer = plain_writer();
  const auto result =
      replay::record(*again, source, path, tool::make_trace_setup(*again, {}), tool::make_build_facts(), options);
  REQUIRE_FALSE(result.has_value());
  CHECK(contains(result.error().message, too_many));
  const ReadTrace read = read_all(read_file(path));
  CHECK(read.ticks.size() > 3);
  REQUIRE(read.tail.end.has_value());
  CHECK(read.tail.end->reason == EndReason::interrupted);
}

TEST_CASE("a stress case whose tick cannot be done fails", "[verifier][study][hostile]") {
  tool::StressCase stress_case;
  stress_case.upper = 1;
  CHECK(tool::judge(stress_case, {0.5, true, {}, {}}) == tool::StudyVerdict::pass);
  CHECK(tool::judge(stress_case, {0.5, true, {}, "tick 3: too many"}) == tool::StudyVerdict::fail);
}

TEST_CASE("a scene whose shapes come together records up to the tick that has too many pairs",
          "[verifier][recorder][hostile]") {
  const Scene scene = coming_together();
  const engine::EngineOptions few = few_pairs();
  const TemporaryFolder folder;
  const std::string path = folder.file("meeting.ttr");
  const auto engine = make_engine_or_fail(scene, few);
  replay::NoInputs source(scene.settings.dt);
  replay::RecordOptions options;
  options.tick_count = 60;
  options.writer = plain_writer();
  const auto result =
      replay::record(*engine, source, path, tool::make_trace_setup(*engine, {}), tool::make_build_facts(), options);
  REQUIRE_FALSE(result.has_value());
  CHECK(contains(result.error().message, too_many));
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
  const auto run = tool::run_session(*again, source, 60, {});
  REQUIRE_FALSE(run.has_value());
  CHECK(run.error().message == result.error().message);
  CHECK(run.error().code == ErrorCode::limit);
}

}  // namespace ticktrue::test
