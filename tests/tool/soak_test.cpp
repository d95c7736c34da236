// The soak: its oracle finds injected faults, its shrinker makes worlds small, and pauses do not change its counts.
// SPDX-License-Identifier: MIT
#include "tool/experiment/soak/soak.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>

#include "engine/scene/scene_json.h"
#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "tests/support/forwarding_engine.h"
#include "tests/support/scenes.h"
#include "tests/support/text.h"
#include "tool/experiment/ddmin.h"
#include "tool/experiment/oracle/physics_checks.h"
#include "tool/experiment/shrink.h"
#include "tool/experiment/soak/cache_counts.h"
#include "tool/experiment/soak/failure_files.h"
#include "tool/experiment/soak/soak_report.h"

namespace ticktrue::test {
namespace {

using namespace soak;
using engine::CacheSet;
using engine::Engine;
using engine::EngineOptions;
using engine::Input;
using engine::InputKind;
using engine::Joint;
using engine::JointKind;

Input input_at(std::uint64_t tick, InputKind kind, std::uint32_t body = 0) {
  Input input;
  input.tick = tick;
  input.kind = kind;
  input.body = body;
  return input;
}

/// A few boxes on the ground, pushed at times.
SoakCase small_case(std::uint64_t seed, int count = 4, std::uint64_t tick_count = 24) {
  SoakCase soak_case{stack_scene(count, 0.05), {}, tick_count};
  soak_case.scene.inputs = {InputKind::impulse};
  soak_case.scene.bodies[1].angle = static_cast<double>(seed % 7) / 64;
  for (std::uint64_t tick = 3; tick < tick_count; tick += 5) {
    Input push = input_at(tick, InputKind::impulse, 1 + static_cast<std::uint32_t>(mix(seed, tick) % count));
    push.values[0] = 0.25;
    soak_case.inputs.push_back(push);
  }
  return soak_case;
}

WorldSource small_worlds() {
  WorldSource source;
  source.make = [](std::uint64_t seed) {
    return WorldSource::World{small_case(seed), {"shape/box", seed % 2 == 0 ? "feature/even" : "feature/odd"}};
  };
  source.without = [](std::uint64_t seed, const std::string& row) -> std::optional<SoakCase> {
    SoakCase without = small_case(seed);
    if (row == "shape/box") without.scene.bodies.pop_back();
    return without;
  };
  source.choices = {"shape/box", "feature/even", "feature/odd"};
  source.choice_changes_bits = [](const std::string&) { return true; };
  return source;
}

/// On request, flips a bit in a velocity of the last body; the lowest bit by default.
class FlippingEngine : public ForwardingEngine {
 public:
  using ForwardingEngine::ForwardingEngine;
  Status step(const TickInput& input, StageObserver* observer) override {
    if (Status did = inner().step(input, observer); !did) return did;
    if (!flips_now()) return {};
    const StateView& state = inner().state();
    const std::size_t table = *state.schema->find_table("bodies");
    const TableSchema& schema = state.schema->tables[table];
    Bytes image;
    encode_image(state, image);
    const auto rows = split_image(*state.schema, image);
    std::size_t at = static_cast<std::size_t>((*rows)[table].rows.data() - image.data()) +
                     ((*rows)[table].row_count - 1) * schema.row_size;
    for (const Column& column : schema.columns)
      if (column.name == "velocity") at += column.offset;
    image[at + flipped_byte()] ^= 1;
    return inner().load(image);
  }

 protected:
  virtual bool flips_now() = 0;
  virtual std::size_t flipped_byte() const { return 0; }
};

/// Refuses a tick as one that exceeds a limit, or as a failure.
template <ErrorCode code>
class RefusesTick : public ForwardingEngine {
 public:
  using ForwardingEngine::ForwardingEngine;
  Status step(const TickInput& input, StageObserver* observer) override {
    if (inner().tick() == 5) return Error{code, "tick 5: refused by the test", {}};
    return inner().step(input, observer);
  }
};

/// Changes a velocity of an f64 world by a millionth in one tick.
class PushesOnce : public FlippingEngine {
 public:
  static constexpr std::uint64_t pushed_tick = 20;
  using FlippingEngine::FlippingEngine;

 protected:
  bool flips_now() override { return inner().tick() == pushed_tick + 1; }
  std::size_t flipped_byte() const override { return 4; }  // of the mantissa: bit 32 of 52
};

/// If many bodies exist, dropping the pair list changes a bit of the next tick.
class ForgetsWrongly : public FlippingEngine {
 public:
  using FlippingEngine::FlippingEngine;
  void forget_caches(CacheSet caches) override {
    forgot_ = (caches & cache_bit(engine::CacheKind::pair_list)) != 0;
    inner().forget_caches(caches);
  }

 protected:
  bool flips_now() override {
    return std::exchange(forgot_, false) && inner().tick() > 5 && inner().bodies().size() > 3;
  }

 private:
  bool forgot_ = false;
};

/// Makes a mistake at one tick, if is_wrong says so.
class WrongAtTick : public FlippingEngine {
 public:
  WrongAtTick(std::unique_ptr<Engine> inner, bool is_wrong) : FlippingEngine(std::move(inner)), is_wrong_(is_wrong) {}

 protected:
  bool flips_now() override { return is_wrong_ && inner().tick() == 8; }

 private:
  bool is_wrong_;
};

/// Loads a state that differs a little from the stored one.
class LoadsWrongly : public FlippingEngine {
 public:
  using FlippingEngine::FlippingEngine;
  Status load(ByteView image) override {
    loaded_ = true;
    return inner().load(image);
  }

 protected:
  bool flips_now() override { return std::exchange(loaded_, false); }

 private:
  bool loaded_ = false;
};

/// Shows a velocity of -0 in one tick.
class ShowsNegativeZero : public ForwardingEngine {
 public:
  using ForwardingEngine::ForwardingEngine;
  const StateView& state() const override {
    if (inner().tick() < 7) return inner().state();
    view_ = inner().state();
    const std::size_t table = *view_.schema->find_table("bodies");
    const TableSchema& schema = view_.schema->tables[table];
    rows_.assign(view_.tables[table].data, view_.tables[table].data + view_.tables[table].row_count * schema.row_size);
    const double zero = -0.0;
    for (const Column& column : schema.columns)
      if (column.name == "angular_velocity") std::memcpy(rows_.data() + schema.row_size + column.offset, &zero, 8);
    view_.tables[table].data = rows_.data();
    return view_;
  }

 private:
  mutable StateView view_;
  mutable Bytes rows_;
};

/// Counts each tick as a hit of the pair list, unless the list was just dropped.
class CountsHits : public ForwardingEngine {
 public:
  using ForwardingEngine::ForwardingEngine;
  Status step(const TickInput& input, StageObserver* observer) override {
    if (Status did = inner().step(input, observer); !did) return did;
    auto& counts = report_[static_cast<std::size_t>(engine::CacheKind::pair_list)];
    ++(forgot_ ? counts.invalidations : counts.hits);
    forgot_ = false;
    return {};
  }
  void forget_caches(CacheSet caches) override { forgot_ = (caches & 1) != 0; }
  engine::CacheReport cache_report() const override { return report_; }

 private:
  bool forgot_ = false;
  engine::CacheReport report_{};
};

template <typename Faulty>
EngineMaker maker_of() {
  return [](const Scene& scene, const EngineOptions& options) -> Result<std::unique_ptr<Engine>> {
    auto made = engine::make_engine(scene, options);
    if (!made) return made.error();
    return std::unique_ptr<Engine>(std::make_unique<Faulty>(*std::move(made)));
  };
}

/// Engines for which `is_wrong` holds make a mistake at tick 7.
EngineMaker maker_wrong_if(bool (*is_wrong)(const EngineOptions&)) {
  return [is_wrong](const Scene& scene, const EngineOptions& options) -> Result<std::unique_ptr<Engine>> {
    auto made = engine::make_engine(scene, options);
    if (!made) return made.error();
    return std::unique_ptr<Engine>(std::make_unique<WrongAtTick>(*std::move(made), is_wrong(options)));
  };
}

struct OracleFixture {
  TemporaryFolder folder;
  OracleOptions options;
  explicit OracleFixture(EngineMaker make = engine::make_engine) {
    options.make = std::move(make);
    options.checks.wanted[static_cast<std::size_t>(CheckKind::zeros)] = false;  // only injected faults are tested
    options.files.path = folder.file("world.ttr");
  }
};

SoakOptions soak_options(const TemporaryFolder& folder, std::uint64_t world_count) {
  SoakOptions options;
  options.world_count = world_count;
  options.folder = folder.file("soak");
  options.oracle = OracleFixture().options;
  options.worlds = small_worlds();
  return options;
}

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

TEST_CASE("ddmin keeps what fails together and nothing else", "[verifier][soak][analytic]") {
  std::size_t tests = 0;
  const auto remaining = ddmin(200, [&](const std::vector<std::size_t>& some) {
    ++tests;
    const auto has = [&](std::size_t i) { return std::count(some.begin(), some.end(), i) > 0; };
    return has(3) && has(17) && has(142);
  });
  CHECK(remaining == std::vector<std::size_t>{3, 17, 142});
  CHECK(tests < 200);
  CHECK(ddmin(9, [](const std::vector<std::size_t>&) { return true; }).empty());
  CHECK(ddmin(3, [](const std::vector<std::size_t>& some) { return some.size() == 3; }).size() == 3);
}

TEST_CASE("bodies that are left out take joints, forces and inputs along, and ids follow",
          "[verifier][soak][analytic]") {
  SoakCase all{stack_scene(5), {}, 10};
  Scene& scene = all.scene;
  scene.prototypes.push_back(unit_box({}));
  scene.prototypes[0].name = "crate";
  scene.inputs = {InputKind::spawn, InputKind::remove, InputKind::impulse};
  for (const std::uint32_t body_b : {2u, 4u}) {
    Joint joint;
    joint.kind = JointKind::weld;
    joint.body_a = 1;
    joint.body_b = body_b;
    scene.joints.push_back(joint);
  }
  engine::Force force;
  force.body = 3;
  scene.forces.push_back(force);
  all.inputs = {input_at(0, InputKind::spawn), input_at(1, InputKind::spawn), input_at(2, InputKind::impulse, 2),
                input_at(2, InputKind::impulse, 4), input_at(3, InputKind::remove, 7)};

  const SoakCase some = with_bodies(all, {0, 1, 4});
  CHECK(some.scene.bodies.size() == 3);
  REQUIRE(some.scene.joints.size() == 1);
  CHECK(some.scene.joints[0].body_b == 2);
  CHECK(some.scene.forces.empty());
  REQUIRE(some.inputs.size() == 4);
  CHECK(some.inputs[2].body == 2);  // previously 4
  CHECK(some.inputs[3].body == 4);  // the second spawned body

  const SoakCase later = with_inputs(all, {1, 4});
  REQUIRE(later.inputs.size() == 2);
  CHECK(later.inputs[1].body == 6);  // now the first spawned body
  CHECK(with_inputs(all, {0, 4}).inputs.size() == 1);
}

TEST_CASE("a world is shrunk to what a predicate asks for", "[verifier][soak][analytic]") {
  SoakCase failing = small_case(1, 60, 200);
  Joint joint;
  joint.kind = JointKind::revolute;
  joint.body_a = 17;
  joint.body_b = 41;
  failing.scene.joints.push_back(joint);
  failing.scene.settings.sleep.emplace();
  failing.scene.settings.events = true;
  const CaseFails predicate = [](const SoakCase& candidate) {
    const bool has_push = std::any_of(candidate.inputs.begin(), candidate.inputs.end(),
                                      [](const Input& input) { return input.tick == 33; });
    return has_push && !candidate.scene.joints.empty() && candidate.scene.settings.events && candidate.tick_count > 33;
  };
  REQUIRE(predicate(failing));
  const ShrinkResult result = shrink(failing, predicate);
  CHECK(predicate(result.smallest));
  CHECK(result.smallest.scene.bodies.size() <= 3);  // the two bodies of the joint, and one to push
  CHECK(result.smallest.inputs.size() == 1);
  CHECK(result.smallest.tick_count == 34);
  CHECK_FALSE(result.smallest.scene.settings.sleep);
  CHECK(result.smallest.scene.settings.events);

  ShrinkOptions few;
  few.test_count_max = 5;
  const ShrinkResult stopped = shrink(failing, predicate, few);
  CHECK(stopped.test_count <= 5);
  CHECK(predicate(stopped.smallest));
}

TEST_CASE("the oracle finds nothing in small worlds, and makes every run", "[verifier][soak][determinism]") {
  OracleFixture fixture;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    const WorldResult result = examine(small_case(seed), seed, fixture.options);
    CAPTURE(seed);
    for (const Finding& finding : result.findings) UNSCOPED_INFO(variant_text(finding.variant) << ": " << finding.what);
    CHECK(result.findings.empty());
    CHECK(result.base.tick_count == 24);
    for (const CheckKind kind : {CheckKind::finite, CheckKind::cold, CheckKind::forget, CheckKind::broad_phase,
                                 CheckKind::chunks, CheckKind::restore, CheckKind::trace, CheckKind::full_pipeline})
      CHECK(result.run_counts[static_cast<std::size_t>(kind)] > 0);
  }
}

TEST_CASE("the oracle finds injected faults, each by its check", "[verifier][soak][determinism]") {
  struct InjectedFault {
    const char* name;
    EngineMaker make;
    CheckKind found_by;
    std::uint64_t tick;  // the expected tick; no_tick: depends on the seed
  };
  constexpr std::uint64_t no_tick = UINT64_MAX;
  const InjectedFault faults[] = {
      {"forgetting", maker_of<ForgetsWrongly>(), CheckKind::cold, 5},
      {"forgetting some", maker_of<ForgetsWrongly>(), CheckKind::forget, no_tick},
      {"loading", maker_of<LoadsWrongly>(), CheckKind::restore, no_tick},
      {"loading, by verify", maker_of<LoadsWrongly>(), CheckKind::trace, no_tick},
      {"broad phase", maker_wrong_if([](const EngineOptions& o) { return o.broad_phase.has_value(); }),
       CheckKind::broad_phase, 7},
      {"chunks", maker_wrong_if([](const EngineOptions& o) { return o.parallel.runner != nullptr; }), CheckKind::chunks,
       7},
      {"threads", maker_wrong_if([](const EngineOptions& o) { return o.thread_count > 1; }), CheckKind::threads, 7},
      {"kernels", maker_wrong_if([](const EngineOptions& o) { return o.instruction_set.has_value(); }),
       CheckKind::instruction_set, 7},
      {"full pipeline", maker_wrong_if([](const EngineOptions& o) { return o.full_pipeline; }),
       CheckKind::full_pipeline, 7},
  };
  for (const InjectedFault& each : faults) {
    if (each.found_by == CheckKind::instruction_set &&
        engine::instruction_set_in_use() == engine::InstructionSet::baseline)
      continue;
    OracleFixture fixture(each.make);
    bool is_found = false;
    for (std::uint64_t seed = 0; seed < 16 && !is_found; ++seed)
      for (const Finding& finding : examine(small_case(seed, 6), seed, fixture.options).findings) {
        if (finding.variant.check != each.found_by) continue;
        is_found = true;
        CAPTURE(each.name, finding.what);
        if (each.tick != no_tick) CHECK(finding.tick == each.tick);
        if (each.found_by != CheckKind::trace)
          CHECK(finding.what.find("table bodies, column velocity, row 6") != std::string::npos);
      }
    CAPTURE(each.name);
    CHECK(is_found);
  }
}

TEST_CASE("a stored -0 is found with its place", "[verifier][soak][corruption]") {
  OracleFixture fixture(maker_of<ShowsNegativeZero>());
  fixture.options.checks = *parse_checks({"zeros"});
  SoakCase still{stack_scene(2), {}, 12};
  const WorldResult result = examine(still, 1, fixture.options);
  REQUIRE(result.findings.size() == 1);
  CHECK(result.findings[0].tick <= 6);
  CHECK(result.findings[0].what.find("column angular_velocity, row ") != std::string::npos);
  CHECK(result.findings[0].what.find("found -0, expected 0") != std::string::npos);
}

TEST_CASE("momentum is checked wherever it is asked for, and not where the thesis' solver loses it",
          "[verifier][soak][conservation]") {
  // A disc of 1 kg hits a disc of 12,000 kg, which `impulse` treats as static.
  SoakCase soak_case{flight_scene(Precision::f64, body_of(disc_shape(0.5), {0, 0})), {}, 30};
  soak_case.scene.settings.solver = engine::SolverKind::impulse;
  soak_case.scene.bodies[0].velocity = {10, 0};
  soak_case.scene.bodies.push_back(body_of(disc_shape(0.5), {3, 0}));
  for (Body& body : soak_case.scene.bodies) body.mass = engine::ExplicitMass{1, {}, {}};
  soak_case.scene.bodies[1].mass->mass = 12000;
  OracleFixture fixture;
  fixture.options.checks = *parse_checks({"momentum"});
  constexpr auto momentum = static_cast<std::size_t>(CheckKind::momentum);
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const WorldResult result = examine(soak_case, seed, fixture.options);
    CHECK(result.run_counts[momentum] == 1);
    CHECK(result.findings.empty());
  }
}

TEST_CASE("a planted change of momentum is found under every solver", "[verifier][soak][conservation]") {
  for (const auto& solver : engine::solvers) {
    if (solver.kind == engine::SolverKind::free_flight) continue;  // this solver refuses bodies that may collide
    SoakCase soak_case{flight_scene(Precision::f64, body_of(disc_shape(0.5), {0, 0})), {}, 30};
    soak_case.scene.settings.solver = solver.kind;
    soak_case.scene.bodies[0].velocity = {3, 0};
    soak_case.scene.bodies.push_back(body_of(disc_shape(0.5), {1.2, 0}));
    soak_case.scene.bodies[1].velocity = {-1, 0};
    OracleFixture fixture(maker_of<PushesOnce>());
    fixture.options.checks = *parse_checks({"momentum"});
    CAPTURE(solver.name);
    const WorldResult result = examine(soak_case, 1, fixture.options);
    REQUIRE(result.findings.size() == 1);
    CAPTURE(result.findings[0].what);
    CHECK(result.findings[0].tick == PushesOnce::pushed_tick);
    fixture.options.make = OracleFixture().options.make;
    CHECK(examine(soak_case, 1, fixture.options).findings.empty());
  }
}

TEST_CASE("a tick in free space that exceeds a limit is no fault, another refusal is",
          "[verifier][soak][conservation]") {
  SoakCase soak_case = small_case(2);
  OracleFixture fixture(maker_of<RefusesTick<ErrorCode::limit>>());
  const CaseInputs inputs(soak_case);
  BaseRun base;
  base.tick_count = 10;
  CHECK_FALSE(check_momentum({soak_case, inputs, fixture.options.make}, base));
  fixture.options.make = maker_of<RefusesTick<ErrorCode::inconsistent>>();
  CHECK(check_momentum({soak_case, inputs, fixture.options.make}, base));
}

TEST_CASE("joints that contradict each other lose momentum by rounding of their impulses alone",
          "[verifier][soak][conservation]") {
  // A hinge holds two discs .25 m apart, a rod wants 1 m: direct joints answer with 4e9 N, which cancel.
  SoakCase soak_case{flight_scene(Precision::f64, body_of(disc_shape(0.0625), {0.25, 0})), {}, 12};
  soak_case.scene.settings.solver = engine::SolverKind::tgs_soft;
  soak_case.scene.settings.joints = engine::JointSolverKind::direct;
  soak_case.scene.bodies.push_back(body_of(disc_shape(0.0625), {0.25, -0.25}));
  Joint hinge;
  hinge.kind = JointKind::revolute;
  hinge.body_a = 0;
  hinge.body_b = 1;
  hinge.anchor_a = {0, -0.125};
  hinge.anchor_b = {0, 0.125};
  Joint rod;
  rod.kind = JointKind::distance;
  rod.body_a = 0;
  rod.body_b = 1;
  rod.length = 1;
  Joint link = hinge;  // without a third disc the rounding is the same on both sides
  link.body_a = 1;
  link.body_b = 2;
  link.anchor_a = {0.125, 0};
  link.anchor_b = {-0.125, 0};
  soak_case.scene.joints = {hinge, link, rod};
  soak_case.scene.bodies.push_back(body_of(disc_shape(0.0625), {0.5, -0.25}));
  OracleFixture fixture;
  fixture.options.checks = *parse_checks({"momentum"});
  const WorldResult result = examine(soak_case, 1, fixture.options);
  CAPTURE(result.findings.empty() ? "" : result.findings[0].what);
  CHECK(result.findings.empty());
}

TEST_CASE("comparisons count while the base run uses a structure again", "[verifier][soak][analytic]") {
  OracleFixture fixture(maker_of<CountsHits>());
  fixture.options.checks = *parse_checks({"cold", "broad_phase=0"});
  const SoakCase soak_case = small_case(2);
  const WorldResult result = examine(soak_case, 2, fixture.options);
  constexpr auto counted = static_cast<std::size_t>(engine::CacheKind::pair_list);
  CHECK(result.base.caches[counted].hits == soak_case.tick_count);
  CHECK(result.tally.while_hit[counted] == soak_case.tick_count);  // of the cold run; the other variant hits as well
  CHECK(result.tally.while_hit[counted + 1] == 0);
}

TEST_CASE("an injected fault is shrunk to few bodies and written with a command that reproduces it",
          "[verifier][soak][determinism]") {
  OracleFixture fixture(maker_of<ForgetsWrongly>());
  const SoakCase failing = small_case(3, 40, 60);
  const auto found = examine_variant(failing, {CheckKind::cold}, fixture.options);
  REQUIRE(found);
  const std::string folder = fixture.folder.file("failure");
  const FailedWorld failure = write_failure(failing, 3, *found, {folder, 30, fixture.options});
  CHECK(failure.body_count == 4);
  CHECK(failure.tick_count == 6);
  const auto scene = engine::parse_scene(text_of(folder + "/scene.json"), "scene.json");
  REQUIRE(scene);
  CHECK(text_of(folder + "/inputs.jsonl").empty());
  CHECK(text_of(folder + "/command").find("--ticks 6 --checks cold\n") != std::string::npos);
  const auto again = read_case(*scene, folder + "/inputs.jsonl", 6);
  REQUIRE(again);
  CHECK(examine_variant(*again, {CheckKind::cold}, fixture.options));
}

TEST_CASE("a soak that was resumed counts the same as one that was not", "[verifier][soak][determinism]") {
  const TemporaryFolder folder, other;
  const auto whole = run_soak(soak_options(folder, 200));
  REQUIRE(whole);
  CHECK(whole->is_whole);
  CHECK(whole->counters.failures.empty());
  CHECK(whole->counters.choices.at("shape/box").active == 200);
  CHECK(whole->counters.choices.at("shape/box").effect == 200);
  CHECK(whole->counters.choices.at("feature/odd").effect == 0);

  SoakOptions parts = soak_options(other, 200);
  parts.thread_count = 3;
  parts.progress = [](const SoakCounters& counters, double) { return counters.world_count < 150; };
  const auto first = run_soak(parts);
  REQUIRE(first);
  CHECK_FALSE(first->is_whole);
  parts.progress = {};
  parts.resume = true;
  const auto second = run_soak(parts);
  REQUIRE(second);
  CHECK(second->new_worlds == 72);  // the worlds of the interrupted second block were not saved
  CHECK(print_progress({}, second->counters) == print_progress({}, whole->counters));

  SoakReport report_a = *whole, report_b = *second;
  report_a.seconds = report_b.seconds = 0;
  CHECK(soak_json(parts, report_a, {}) == soak_json(parts, report_b, {}));
}

TEST_CASE("the progress of another soak is refused", "[verifier][soak][corruption]") {
  const TemporaryFolder folder;
  SoakOptions options = soak_options(folder, 16);
  REQUIRE(run_soak(options));
  options.resume = true;
  options.seed = 2;
  const auto refused = run_soak(options);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::incompatible);
  CHECK(refused.error().message.find("progress.json: seed: found 1, expected 2") != std::string::npos);
  const std::string text = print_progress({}, {});
  for (std::size_t size = 0; size + 1 < text.size(); size += 7)
    CHECK_FALSE(parse_progress(text.substr(0, size), {}, "p"));
  CHECK(parse_progress(text, {}, "p"));
}

TEST_CASE("a soak over a faulty engine says where, and ends after so many failures", "[verifier][soak][determinism]") {
  const TemporaryFolder folder;
  SoakOptions options = soak_options(folder, 32);
  options.oracle.make = maker_of<LoadsWrongly>();
  options.oracle.checks = *parse_checks({"restore"});
  options.failure_count_max = 2;
  const auto report = run_soak(options);
  REQUIRE(report);
  REQUIRE(report->counters.failures.size() == 2);
  CHECK(report->counters.failures[0].variant.rfind("restore=", 0) == 0);
  CHECK(report->counters.failures[0].body_count <= 2);
  CHECK(soak_text(options, *report, {}).rfind("FOUND", 0) == 0);
}

TEST_CASE("a soak in which a cached structure was never hit is no match", "[verifier][soak][determinism]") {
  const TemporaryFolder folder;
  SoakOptions options = soak_options(folder, 16);
  const auto report = run_soak(options);
  REQUIRE(report);
  CHECK(soak_text(options, *report, {}).rfind("match", 0) == 0);
  options.hits_expected_after = 17;
  CHECK(never_hit(options, report->counters).empty());
  options.hits_expected_after = 16;
  CHECK(never_hit(options, report->counters) ==
        std::vector<std::string>{"manifolds", "joint_plan", "joint_graph", "cell_side"});  // only worlds of two boxes
  const std::string text = soak_text(options, *report, {});
  CHECK(text.rfind("FOUND", 0) == 0);
  CHECK(text.find("cached structure that was never hit: found joint_plan") != std::string::npos);
}

TEST_CASE("counts of physics that rise are told apart from those that fall", "[verifier][soak][analytic]") {
  const KnownFile known{7, 100, {{{"pgs rk4 free", "energy"}, 3}, {{"pgs rk4 free", "overlap"}, 2}}};
  const auto read = parse_known(print_known(known), "known.tsv");
  REQUIRE(read);
  CHECK(read->seed == 7);
  CHECK(read->world_count == 100);
  CHECK(read->counts == known.counts);
  const KnownComparison same = compare_known(known.counts, known.counts);
  CHECK((same.rose.empty() && same.fell.empty()));
  const KnownComparison other =
      compare_known(known.counts, {{{"pgs rk4 free", "energy"}, 4}, {{"tgs_soft rk4 free", "energy"}, 1}});
  CHECK(other.rose == std::vector<std::string>{"pgs rk4 free, energy: found 4 worlds, expected 3",
                                               "tgs_soft rk4 free, energy: found 1 worlds, expected 0"});
  CHECK(other.fell == std::vector<std::string>{"pgs rk4 free, overlap: found 0 worlds, expected 2"});
  CHECK_FALSE(parse_known("pgs rk4 free\tenergy\n", "known.tsv"));
}

TEST_CASE("counts of cached structures that differ are named, and half a table is refused",
          "[verifier][soak][analytic]") {
  engine::CacheReport counts;
  for (std::size_t i = 0; i < counts.size(); ++i) counts[i] = {100 + i, 7 * i};
  const std::string text = print_cache_counts(counts);
  const auto read = parse_cache_counts(text, "counts.tsv");
  REQUIRE(read);
  CHECK(compare_cache_counts(counts, *read, "counts.tsv"));
  for (std::size_t i = 0; i < counts.size(); ++i) {
    engine::CacheReport other = counts;
    ++(i % 2 ? other[i].hits : other[i].invalidations);
    const Status compared = compare_cache_counts(counts, other, "counts.tsv");
    REQUIRE_FALSE(compared);
    CHECK(contains(compared.error().message, std::string(engine::cache_kinds[i].name) + ": found "));
  }
  CHECK_FALSE(parse_cache_counts(text.substr(0, text.rfind("cell_side")), "counts.tsv"));
  CHECK_FALSE(parse_cache_counts(text + "more\t1\t2\n", "counts.tsv"));
  CHECK_FALSE(parse_cache_counts("boxes\t1\t2\n", "counts.tsv"));
  CHECK_FALSE(parse_cache_counts(text + "\x01", "counts.tsv"));
}

TEST_CASE("names of checks are read with their numbers, and others are refused", "[verifier][soak][analytic]") {
  const auto checks = parse_checks({"cold", "restore=57"});
  REQUIRE(checks);
  CHECK(checks->has(CheckKind::cold));
  CHECK_FALSE(checks->has(CheckKind::trace));
  CHECK(checks->only == std::vector<soak::Variant>{{CheckKind::cold, 0}, {CheckKind::restore, 57}});
  for (const char* wrong : {"colder", "restore=", "restore=x", "cold=1", "restore=1x", ""}) {
    CAPTURE(wrong);
    CHECK_FALSE(parse_checks({wrong}));
  }
}

}  // namespace ticktrue::test
