// `ticktrue reduce`: equal failures, later starts, neighbours, and searches with injected faults.
// SPDX-License-Identifier: MIT
#include "tool/experiment/reduce/reduce.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "engine/scene/scene_binary.h"
#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "tests/support/forwarding_engine.h"
#include "tests/support/scenes.h"
#include "tool/experiment/reduce/foreign_session.h"
#include "tool/experiment/reduce/neighbourhood.h"
#include "tool/experiment/reduce/program_judge.h"
#include "tool/experiment/reduce/result_folder.h"
#include "tool/experiment/reduce/session_file.h"
#include "tool/experiment/reduce/start_state.h"
#include "tool/experiment/shrink.h"
#include "verifier/verify/verify.h"

namespace ticktrue::test {
namespace {

using namespace reduce;
using engine::Engine;
using engine::Input;
using engine::InputKind;

Input input_of(std::uint64_t tick, InputKind kind, std::uint32_t body, std::initializer_list<double> values) {
  Input input;
  input.tick = tick;
  input.kind = kind;
  input.body = body;
  std::copy(values.begin(), values.end(), input.values.begin());
  return input;
}

/// Columns of boxes on the ground, pushed at times.
SoakCase columns_of_boxes(int column_count, std::uint64_t tick_count) {
  SoakCase session{stack_scene(2), {}, tick_count};
  const Body box = session.scene.bodies[1];
  session.scene.bodies.resize(1);
  session.scene.inputs = {InputKind::impulse};
  for (int i = 0; i < column_count; ++i)
    for (int j = 0; j < 3; ++j) {
      Body& body = session.scene.bodies.emplace_back(box);
      body.name = "box_" + std::to_string(3 * i + j);
      body.position = {3.0 * i - 1.5 * column_count, 0.5 + j};
    }
  for (std::uint64_t tick = 1; tick < tick_count; tick += 2)
    session.inputs.push_back(input_of(tick, InputKind::impulse, 1 + static_cast<std::uint32_t>(tick) % 7, {0.25, 0}));
  return session;
}

/// The same in f32, with a spring on one box that is too stiff for any tick.
SoakCase with_stiff_spring(SoakCase session, std::uint32_t body) {
  session.scene.settings.precision = Precision::f32;
  engine::Force spring;
  spring.kind = engine::ForceKind::spring;
  spring.body = body;
  spring.point = {0, 9};
  spring.stiffness = 1e12;
  spring.rest_length = 1;
  session.scene.forces.push_back(spring);
  return session;
}

ReduceOptions options_of(const EngineMaker& make = engine::make_engine) {
  ReduceOptions options;
  options.make = make;
  return options;
}

/// Flips a bit of a velocity at the end of each tick in which a box is faster than 3 m/s.
class FlipsFastBoxes : public ForwardingEngine {
 public:
  using ForwardingEngine::ForwardingEngine;
  Status step(const TickInput& input, StageObserver* observer) override {
    if (Status did = inner().step(input, observer); !did) return did;
    const StateView& state = inner().state();
    const std::size_t table = *state.schema->find_table("bodies");
    const TableSchema& schema = state.schema->tables[table];
    const std::vector<engine::BodyReport> bodies = inner().bodies();
    for (std::size_t row = 0; row < bodies.size(); ++row) {
      if (!(std::hypot(bodies[row].velocity.x, bodies[row].velocity.y) > 3)) continue;
      Bytes image;
      encode_image(state, image);
      const auto tables = split_image(*state.schema, image);
      std::size_t at = static_cast<std::size_t>((*tables)[table].rows.data() - image.data()) + row * schema.row_size;
      for (const Column& column : schema.columns)
        if (column.name == "velocity") at += column.offset;
      image[at] ^= 1;
      return inner().load(image);
    }
    return {};
  }
};

/// Verifies a trace with the faulty engine in this process.
Result<std::optional<Failure>> judge_with_fault(const std::string& trace) {
  Result<replay::TraceReader> reader = replay::TraceReader::open(trace);
  if (!reader) return reader.error();
  SimulationInfo faulty = engine::engine_info();
  faulty.make_on_threads = {};
  faulty.make = [](ByteView setup) -> Result<std::unique_ptr<Simulation>> {
    const Result<Scene> scene = engine::decode_scene(setup);
    if (!scene) return scene.error();
    auto made = engine::make_engine(*scene);
    if (!made) return made.error();
    return std::unique_ptr<Simulation>(std::make_unique<FlipsFastBoxes>(*std::move(made)));
  };
  verifier::VerifyOptions options;
  options.simulation = &faulty;
  const verifier::Report report = verifier::verify(*reader, options);
  return failure_of_report(verifier::report_json({&report, 1}, false));
}

/// A toy simulation that miscounts once it has six bodies.
class CrowdedToy : public ToySimulation {
 public:
  using ToySimulation::ToySimulation;
  Status step(const TickInput& input, StageObserver* observer) override {
    if (Status did = ToySimulation::step(input, observer); !did) return did;
    if (bodies.size() >= 6) bodies[0].charge += 1;
    return {};
  }
};

Result<std::optional<Failure>> judge_with_crowd(const std::string& trace) {
  Result<replay::TraceReader> reader = replay::TraceReader::open(trace);
  if (!reader) return reader.error();
  SimulationInfo crowded = toy_info;
  crowded.make = [](ByteView setup) -> Result<std::unique_ptr<Simulation>> {
    ByteReader in(setup);
    return std::unique_ptr<Simulation>(std::make_unique<CrowdedToy>(in.u32()));
  };
  verifier::VerifyOptions options;
  options.simulation = &crowded;
  const verifier::Report report = verifier::verify(*reader, options);
  return failure_of_report(verifier::report_json({&report, 1}, false));
}

}  // namespace

TEST_CASE("a failure is the same by its kind, and unless loose by stage, table and column",
          "[verifier][reduce][analytic]") {
  Failure a;
  a.kind = "diverged";
  a.stage = "tgs_soft";
  a.table = "bodies";
  a.column = "velocity";
  a.tick = 4;
  Failure b = a;
  b.tick = 7;
  b.row = 3;
  CHECK(is_same(a, b, false));
  for (std::string Failure::*const part : {&Failure::stage, &Failure::table, &Failure::column}) {
    Failure other = a;
    other.*part = "other";
    CHECK_FALSE(is_same(a, other, false));
    CHECK(is_same(a, other, true));
  }
  b.kind = "crashed";
  CHECK_FALSE(is_same(a, b, true));
}

TEST_CASE("places are read out of the messages of engine and oracle", "[verifier][reduce][analytic]") {
  Failure cached;
  read_place("tick 3: stage tgs_soft: bodies.velocity row 4: found 1 with cached structures, expected 2 without",
             cached);
  CHECK(place_text(cached) == "tgs_soft, bodies.velocity");
  Failure found;
  read_place("table contacts, column tangent_force, row 3 (box / box), lane 0: expected 0, got -0", found);
  CHECK(place_text(found) == "contacts.tangent_force");
  Failure none;
  read_place("inputs refused", none);
  CHECK(place_text(none).empty());
}

TEST_CASE("a session that begins with a later state goes on as the whole one", "[verifier][reduce][equivalence]") {
  SoakCase session{stack_scene(1), {}, 40};
  Scene& scene = session.scene;
  scene.bodies.resize(1);
  scene.inputs = {InputKind::spawn, InputKind::remove, InputKind::impulse, InputKind::set_gravity};
  for (int i = 0; i < 3; ++i) {
    Body& body = scene.bodies.emplace_back(unit_box({4.0 * i, 30}));
    body.angle = 0.3 * i;
    body.angular_velocity = 1 - i;
    body.velocity = {1.0 * i, 2};
  }
  scene.prototypes.push_back(unit_box({}));
  scene.prototypes[0].name = "crate";
  session.inputs = {input_of(2, InputKind::spawn, 0, {-6, 40, 0.5, 1, 0, 0.25}),
                    input_of(3, InputKind::remove, 1, {}),
                    input_of(5, InputKind::set_gravity, 0, {1, -3}),
                    input_of(20, InputKind::spawn, 0, {-12, 40, 0, 0, 0, 0}),
                    input_of(22, InputKind::impulse, 4, {3, 1}),
                    input_of(23, InputKind::impulse, 2, {-1, 1}),
                    input_of(24, InputKind::impulse, 5, {-2, 1})};
  const auto run = [](const SoakCase& some, std::uint64_t tick_count) {
    auto made = *engine::make_engine(some.scene);
    const soak::CaseInputs inputs(some);
    for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
      REQUIRE(made->accept(inputs.at(tick)));
      REQUIRE(made->step(inputs.at(tick), nullptr));
    }
    return made;
  };
  const SoakCase later = begin_at_state(session, *run(session, 10));
  CHECK(later.tick_count == 30);
  CHECK(later.inputs.size() == 4);
  const auto whole = run(session, 40)->bodies();
  const auto rest = run(later, 30)->bodies();
  REQUIRE(whole.size() == rest.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    CAPTURE(i, whole[i].name);
    CHECK(rest[i].center.x == Approx(whole[i].center.x).margin(1e-4));
    CHECK(rest[i].center.y == Approx(whole[i].center.y).margin(1e-4));
    CHECK(rest[i].angle == Approx(whole[i].angle).margin(1e-4));
  }
}

TEST_CASE("neighbours come by contact and joint first, then by distance", "[verifier][reduce][analytic]") {
  SoakCase session = columns_of_boxes(4, 1);
  engine::Joint joint;
  joint.kind = engine::JointKind::distance;
  joint.body_a = 1;
  joint.body_b = 12;
  joint.length = 12;
  session.scene.joints.push_back(joint);
  const auto made = *engine::make_engine(session.scene);
  const std::vector<std::size_t> order = by_nearness(*made, {1});
  REQUIRE(order.size() == session.scene.bodies.size());
  CHECK(order[0] == 1);
  CHECK(std::set<std::size_t>(order.begin() + 1, order.begin() + 4) == std::set<std::size_t>{0, 2, 12});
  CHECK(order.back() != 3);
  CHECK(by_nearness(*made, {99}).empty());
  CHECK(connected_groups(*made) == std::vector<std::vector<std::size_t>>{{1, 2, 3, 10, 11, 12}, {4, 5, 6}, {7, 8, 9}});
}

TEST_CASE("a value that is not finite is reduced to the body that makes it", "[verifier][reduce][analytic]") {
  const SoakCase session = with_stiff_spring(columns_of_boxes(30, 80), 41);
  const auto predicate = not_finite(engine::make_engine);
  const auto result = reduce::reduce(session, *predicate, options_of());
  REQUIRE(result);
  CHECK(is_same(result->first, result->last, false));
  CHECK(result->last.stage == "tgs_soft");
  CHECK(result->smallest.scene.bodies.size() == 1);
  CHECK(result->smallest.scene.forces.size() == 1);
  CHECK(result->smallest.inputs.empty());
  CHECK(result->smallest.tick_count == result->last.tick + 1);
  const auto again = predicate->examine(result->smallest);
  REQUIRE((again && *again));
  CHECK(is_same(result->first, **again, false));

  SoakCase mended = result->smallest;
  mended.scene.forces.clear();
  CHECK_FALSE(predicate->examine(mended)->has_value());

  const auto twice = reduce::reduce(session, *predicate, options_of());
  CHECK(twice->smallest.scene == result->smallest.scene);
  CHECK(twice->run_count == result->run_count);
}

TEST_CASE("a search that is stopped keeps the smallest session so far", "[verifier][reduce][analytic]") {
  const SoakCase session = with_stiff_spring(columns_of_boxes(30, 80), 41);
  const auto predicate = not_finite(engine::make_engine);
  for (const std::size_t limit : {1u, 3u, 12u}) {
    ReduceOptions options = options_of();
    std::size_t asked = 0;
    options.stops = [&] { return ++asked > limit; };
    const auto result = reduce::reduce(session, *predicate, options);
    REQUIRE(result);
    CHECK(result->ended_early);
    CHECK(result->run_count <= limit + 3);
    const auto again = predicate->examine(result->smallest);
    REQUIRE((again && *again));
    CHECK(is_same(result->first, **again, false));
  }
}

TEST_CASE("a session that does not fail is refused", "[verifier][reduce][analytic]") {
  const auto predicate = not_finite(engine::make_engine);
  const auto result = reduce::reduce(columns_of_boxes(2, 10), *predicate, options_of());
  REQUIRE_FALSE(result);
  CHECK(result.error().code == ErrorCode::usage);
  CHECK(result.error().message.find("does not fail") != std::string::npos);
}

/// Fails with every session, in the stage of the solver.
class FailsAlways : public Predicate {
 public:
  explicit FailsAlways(bool is_of_outcome = false) : is_of_outcome_(is_of_outcome) {}
  bool is_of_outcome() const override { return is_of_outcome_; }
  std::vector<std::string> words() const override { return {}; }
  Result<std::optional<Failure>> examine(const SoakCase& session) override {
    Failure failure;
    failure.kind = "differs";
    failure.stage = engine::info_of(engine::solvers, session.scene.settings.solver).name;
    failure.tick = is_of_outcome_ ? session.tick_count - 1 : 0;
    return std::optional(failure);
  }

 private:
  bool is_of_outcome_;
};

TEST_CASE("the method of a session stays, unless any method is allowed", "[verifier][reduce][analytic]") {
  SoakCase session = columns_of_boxes(2, 10);
  engine::Settings& settings = session.scene.settings;
  settings.solver = engine::SolverKind::pgs;
  settings.substeps = 1;
  settings.iterations = 30;
  settings.precision = Precision::f64;
  settings.dt = 1.0 / 120;
  settings.broad_phase = engine::BroadPhaseKind::uniform_grid;
  settings.events = true;
  settings.restitution_threshold = 0.25;
  engine::Settings method = settings;
  method.events = engine::Settings{}.events;
  method.restitution_threshold = engine::Settings{}.restitution_threshold;
  for (const bool is_loose : {false, true})
    for (const bool any_method : {false, true}) {
      CAPTURE(is_loose, any_method);
      FailsAlways predicate;
      ReduceOptions options = options_of();
      options.is_loose = is_loose;
      options.any_method = any_method;
      const auto result = reduce::reduce(session, predicate, options);
      REQUIRE(result);
      const engine::Settings& found = result->smallest.scene.settings;
      CHECK(result->smallest.scene.bodies.size() <= 1);
      CHECK((found == method) == !any_method);
      // Without --loose the failure names the stage of the solver.
      CHECK((found.solver == engine::SolverKind::tgs_soft) == (any_method && is_loose));
    }
}

TEST_CASE("start, ticks and gravity stay where the outcome of a run is wrong", "[verifier][reduce][analytic]") {
  const SoakCase session = columns_of_boxes(2, 10);
  for (const bool is_of_outcome : {false, true}) {
    FailsAlways predicate(is_of_outcome);
    const auto result = reduce::reduce(session, predicate, options_of());
    REQUIRE(result);
    CHECK(result->smallest.scene.bodies.size() <= 1);
    CHECK(result->cut_tick == 0);
    CHECK(result->smallest.tick_count == (is_of_outcome ? 10 : 1));
    CHECK(result->smallest.scene.gravity == (is_of_outcome ? session.scene.gravity : engine::Point{}));
  }
}

TEST_CASE("a fault of another engine is reduced to the box and the push that show it",
          "[verifier][reduce][determinism]") {
  const TemporaryFolder folder;
  SoakCase session = columns_of_boxes(30, 60);
  session.inputs.push_back(input_of(40, InputKind::impulse, 77, {4, 0}));
  OtherProgram program;
  program.judge = judge_with_fault;
  program.folder = folder.file(".");
  const auto predicate = differs_elsewhere(program, engine::make_engine);
  const auto result = reduce::reduce(session, *predicate, options_of());
  REQUIRE(result);
  CHECK(result->first.tick == 40);
  CHECK(result->last.kind == "diverged");
  CHECK(result->last.table == "bodies");
  CHECK(result->last.column == "velocity");
  CHECK(is_same(result->first, result->last, false));
  CHECK(result->smallest.scene.bodies.size() == 1);
  CHECK(result->smallest.inputs.size() <= 1);
  CHECK(result->smallest.tick_count == 1);
}

TEST_CASE("what was written fails in the same way when it is read again", "[verifier][reduce][equivalence]") {
  const TemporaryFolder folder;
  const SoakCase session = with_stiff_spring(columns_of_boxes(5, 80), 7);
  const auto predicate = not_finite(engine::make_engine);
  const auto result = reduce::reduce(session, *predicate, options_of());
  REQUIRE(result);
  const auto written = write_result(*result, *predicate, options_of(), folder.file("out"));
  REQUIRE(written);
  CHECK(written->size > 0);
  CHECK(written->size < 10'000);
  CHECK(written->command.find("--not-finite --once") != std::string::npos);

  // A session with another failure is not written as the same failure.
  ReduceResult wrong = *result;
  wrong.last.column = "rotation";
  const auto refused = write_result(wrong, *predicate, options_of(), folder.file("wrong"));
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::inconsistent);
}

TEST_CASE("a session of a plug-in loses the ticks and inputs that its failure does not need",
          "[verifier][reduce][determinism]") {
  const TemporaryFolder folder;
  REQUIRE(record_toy(folder.file("long.ttr"), toy_setup(3), 60));
  const auto session = read_foreign_session(folder.file("long.ttr"), std::nullopt);
  REQUIRE(session);
  REQUIRE(session->ticks.size() == 60);
  const auto result = reduce_foreign(*session, toy_info, judge_with_crowd, folder.file("."), options_of());
  REQUIRE(result);
  CHECK(is_same(result->first, result->last, false));
  CHECK(result->last.column == "charge");
  CHECK(result->first.tick == 23);  // the fourth spawned body, after one was removed
  // If no body is removed, three more bodies are enough.
  CHECK(result->smallest.ticks.size() == 3);
  CHECK(result->smallest.input_count() == 3);
  REQUIRE(record_foreign(result->smallest, toy_info, folder.file("short.ttr")));
  CHECK(judge_with_crowd(folder.file("short.ttr"))->has_value());
  const std::string text = foreign_inputs_text(result->smallest);
  CHECK(std::count(text.begin(), text.end(), '\n') == 3);
  const auto quiet = reduce_foreign(*read_foreign_session(folder.file("long.ttr"), 5), toy_info, judge_with_crowd,
                                    folder.file("."), options_of());
  CHECK_FALSE(quiet.has_value());
}

TEST_CASE("reports of other programs are read, and wrong ones are refused", "[verifier][reduce][hostile]") {
  CHECK_FALSE(failure_of_report("").has_value());
  CHECK_FALSE(failure_of_report("[1]").has_value());
  CHECK_FALSE(failure_of_report(R"({"schema":"ticktrue.verify/3","verdict":"match"})").has_value());
  CHECK(failure_of_report(R"({"schema":"ticktrue.verify/1","verdict":"damaged","reason":"x"})").error().code ==
        ErrorCode::incompatible);
  const auto match = failure_of_report(R"({"schema":"ticktrue.verify/1","verdict":"match"})");
  REQUIRE(match);
  CHECK_FALSE(match->has_value());
  const auto bare = failure_of_report(
      R"({"schema":"ticktrue.verify/1","verdict":"diverged","divergence":{"tick":"4","rows":[7,{"id":-3}],"stage":null}})");
  REQUIRE((bare && *bare));
  CHECK((*bare)->tick == 0);
  CHECK((*bare)->bodies.empty());
  // Version 1 has values as texts, version 2 as numbers.
  for (const char* row : {R"({"schema":"ticktrue.verify/1","verdict":"diverged","divergence":{"tick":4,"rows":[
           {"table":"b","column":"c","row":2,"name":"n","expected_value":"0.1","got_value":"-7"}]}})",
                          R"({"schema":"ticktrue.verify/2","verdict":"diverged","divergence":{"tick":4,"rows":[
           {"table":"b","column":"c","row":2,"name":"n","expected_value":0.1,"got_value":-7}]}})"}) {
    const auto found = failure_of_report(row);
    REQUIRE((found && *found));
    CHECK((*found)->what == "b.c row 2 n: expected 0.1, got -7");
  }
  const auto missing = failure_of_report(
      R"({"schema":"ticktrue.verify/2","verdict":"diverged","divergence":{"tick":4,"rows":[
           {"table":"b","column":"c","row":2,"name":"n","expected_value":null,"got_value":"nan"}]}})");
  REQUIRE((missing && *missing));
  CHECK((*missing)->what == "b.c row 2 n: expected no row, got nan");
  CHECK(words_with_trace({"a", "b{}c", "{}"}, "x{}") == std::vector<std::string>{"a", "bx{}c", "x{}"});
  CHECK(words_with_trace({"a"}, "x") == std::vector<std::string>{"a", "x"});
}

TEST_CASE("programs are judged by their report, their exit code or their crash", "[verifier][reduce][hostile]") {
  const TemporaryFolder folder;
  const auto judge = [&](const std::string& script) {
    return program_judge({"sh", "-c", script + " # {}"}, folder.file("."), 20)("trace");
  };
  CHECK_FALSE(judge("exit 0")->has_value());
  CHECK((*judge("exit 1"))->kind == "exit_code_1");
  CHECK_FALSE(judge("exit 7").has_value());
  CHECK((*judge("kill -SEGV $$"))->kind == "crashed");
  CHECK((*judge(R"(echo '{"schema":"ticktrue.verify/1","verdict":"diverged"}'; exit 1)"))->kind == "diverged");
  CHECK((*judge(R"(echo '{"schema":"ticktrue.verify/1","verdict":"diverged"}' > $TICKTRUE_RESULT; echo a)"))->kind ==
        "diverged");
  CHECK_FALSE(judge("exit 0")->has_value());  // the report of the previous run was removed
  CHECK_FALSE(program_judge({"/nonexistent/program"}, folder.file("."), 20)("trace").has_value());
}

TEST_CASE("expressions measure a world, before the first tick too", "[verifier][reduce][analytic]") {
  const auto parsed = tool::Expression::parse("1", "--expect");
  if (!parsed) {
    CHECK(parsed.error().code == ErrorCode::unsupported);
    return;
  }
  const auto made = *engine::make_engine(columns_of_boxes(2, 10).scene);
  const auto value = [&](const std::string& text) {
    auto expression = tool::Expression::parse(text, "--expect");
    REQUIRE(expression);
    expression->begin(*made);
    for (int tick = 0; tick < 10; ++tick) REQUIRE(made->step({1.0 / 60, {}}, nullptr));
    return expression->evaluate(*made);
  };
  CHECK(value("tick - tick_start") == 10);
  CHECK(value("bodies") == 7);
  CHECK(value("abs(energy - kinetic - potential) < 1e-9 * energy") == 1);
  CHECK(value("contacts >= 6 && overlap < 0.1") == 1);
  CHECK(value("speed_max > 1e9") == 0);
  for (const char* wrong : {"energy = 5", "enrgy < 5", "energy <", "energy, tick", ""}) {
    CAPTURE(wrong);
    const auto refused = tool::Expression::parse(wrong, "--expect");
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == ErrorCode::usage);
    CHECK(refused.error().message.find("--expect") == 0);
  }
}

TEST_CASE("an expectation that is broken at first is refused, one that breaks later is reduced",
          "[verifier][reduce][analytic]") {
  if (!tool::Expression::parse("1", "--expect")) return;
  const auto expects = [](const std::string& text) {
    return broken_expectation(*tool::Expression::parse(text, "--expect"), engine::make_engine);
  };
  SoakCase session = columns_of_boxes(20, 60);
  session.inputs.push_back(input_of(30, InputKind::impulse, 50, {9, 0}));
  const auto at_first = reduce::reduce(session, *expects("bodies < 3"), options_of());
  REQUIRE_FALSE(at_first);
  CHECK(at_first.error().message.find("before the first tick") != std::string::npos);
  const auto predicate = expects("speed_max < 5");
  const auto result = reduce::reduce(session, *predicate, options_of());
  REQUIRE(result);
  CHECK(result->first.tick == 30);
  CHECK(result->smallest.scene.bodies.size() == 1);
  CHECK(result->smallest.inputs.size() == 1);
  CHECK(result->smallest.tick_count == 1);
}

TEST_CASE("inputs that are needed at different ticks move together", "[verifier][reduce][analytic]") {
  if (!tool::Expression::parse("1", "--expect")) return;
  SoakCase session = columns_of_boxes(5, 90);
  session.scene.inputs = {InputKind::spawn, InputKind::impulse};
  session.scene.prototypes.push_back(unit_box({}));
  session.scene.prototypes[0].name = "crate";
  for (const std::uint64_t tick : {20u, 51u, 80u})
    session.inputs.push_back(input_of(tick, InputKind::spawn, 0, {0, 9.0 + static_cast<double>(tick)}));
  std::stable_sort(session.inputs.begin(), session.inputs.end(),
                   [](const Input& a, const Input& b) { return a.tick < b.tick; });
  for (std::size_t i = 0; i < session.inputs.size(); ++i) session.inputs[i].sequence = static_cast<std::uint32_t>(i);
  const auto predicate =
      broken_expectation(*tool::Expression::parse("bodies < bodies_start + 3", "--expect"), engine::make_engine);
  const auto result = reduce::reduce(session, *predicate, options_of());
  REQUIRE(result);
  CHECK(result->smallest.inputs.size() == 3);
  CHECK(result->smallest.tick_count == 3);
  CHECK(result->smallest.scene.bodies.empty());
}

}  // namespace ticktrue::test
