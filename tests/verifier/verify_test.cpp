// Every verdict of verify, over toy simulations with injected faults.
// SPDX-License-Identifier: MIT
#include "verifier/verify/verify.h"

#include "tests/support/catch.h"
#include "tests/verifier/toy_variants.h"

namespace ticktrue::test {
namespace {

using verifier::Report;
using verifier::Verdict;
using verifier::VerifyMode;
using verifier::VerifyOptions;

void plant(std::uint64_t tick, std::size_t stage, std::function<void(ToySimulation&)> fault) {
  injected = {tick, stage, std::move(fault)};
}
void nudge_velocity(ToySimulation& toy) {
  toy.bodies[1].velocity[1] = std::nextafter(toy.bodies[1].velocity[1], 1e9F);
}

TEST_CASE("verify: a trace matches the simulation that made it, in every mode and detail",
          "[verifier][verify][equivalence]") {
  for (const bool full : {false, true}) {
    const Bytes trace = toy_trace_with(full ? full_toy_setup(6, 5, 20) : toy_setup(6), 50, 8);
    for (const verifier::VerifyModeInfo& info : verifier::verify_modes) {
      if (info.mode == VerifyMode::threads) continue;  // the toy has one
      CAPTURE(full, info.name);
      const Report report = verify_bytes(trace, toy_info, info.mode);
      CHECK(report.verdict == Verdict::match);
      CHECK(report.exit_code() == 0);
      CHECK(report.ticks_recorded == 50u);
      CHECK(report.ticks_compared == 50);
      CHECK(report.warnings.empty());
      CHECK(!report.divergence);
      REQUIRE(report.end);
      CHECK(report.end->tail.condition == replay::TraceCondition::complete);
    }
  }
}

TEST_CASE("verify: a simulation with one thread refuses to be compared over threads", "[verifier][verify][analytic]") {
  const Report report = verify_bytes(toy_trace_with(toy_setup(6), 10, 8), toy_info, VerifyMode::threads);
  CHECK(report.verdict == Verdict::not_comparable);
  CHECK(contains(report.reason, "ticktrue.toy of this build has one thread"));
}

TEST_CASE("verify: restore to the end matches and counts each tick once", "[verifier][verify][equivalence]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 50, 8);
  VerifyOptions options = verify_options(toy_info, VerifyMode::restore);
  options.to_end = true;
  const Report report = verify_bytes(trace, options);
  CHECK(report.verdict == Verdict::match);
  CHECK(report.ticks_compared == 50);
}

TEST_CASE("verify: a changed result is diverged at its tick, stage, column, row and lane",
          "[verifier][verify][analytic]") {
  const Bytes trace = toy_trace_with(full_toy_setup(6, 0, 100), 50, 8);
  plant(37, ToySimulation::force_stage, nudge_velocity);
  for (const VerifyMode mode : {VerifyMode::replay, VerifyMode::restore}) {
    const Report report = verify_bytes(trace, faulty_info, mode);
    CHECK(report.verdict == Verdict::diverged);
    CHECK(report.exit_code() == 1);
    CHECK(report.ticks_recorded == 50u);
    CHECK(report.ticks_compared == 38);
    REQUIRE(report.divergence);
    CHECK(report.divergence->tick == 37);
    CHECK(report.divergence->stage == "forces");
    CHECK(contains(report.divergence->stage_note, "inputs agrees"));
    // Velocity goes into position in the same tick.
    REQUIRE(report.divergence->tables.size() == 1);
    CHECK(report.divergence->tables[0].table == "bodies");
    CHECK(report.divergence->tables[0].columns.back() == "velocity");
    const verifier::LaneReport& lane = report.divergence->rows.back();
    CHECK(lane.column == "velocity");
    CHECK(lane.lane == 1);
    REQUIRE(lane.id);
    CHECK(lane.name == "toy_" + std::to_string(*lane.id));
    REQUIRE(!report.again.empty());
    CHECK(contains(report.again[0], "--from 32 --to 37"));
  }
}

TEST_CASE("verify: the command a report suggests finds the same divergence", "[verifier][verify][equivalence]") {
  const Bytes trace = toy_trace_with(full_toy_setup(6, 0, 100), 50, 8);
  plant(37, ToySimulation::force_stage, nudge_velocity);
  VerifyOptions options = verify_options(faulty_info);
  const Report whole = verify_bytes(trace, options);
  options.from = 32;
  options.to = 37;
  const Report part = verify_bytes(trace, options);
  CHECK(part.verdict == Verdict::diverged);
  CHECK(part.ticks_compared == 6);
  REQUIRE(part.divergence);
  CHECK(part.divergence->tick == whole.divergence->tick);
  CHECK(part.divergence->time_s == whole.divergence->time_s);
  CHECK(part.divergence->stage == whole.divergence->stage);
  CHECK(part.divergence->lane_count == whole.divergence->lane_count);
}

TEST_CASE("verify: with root hashes only the tick is exact and a checkpoint behind it gives the columns",
          "[verifier][verify][analytic]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 50, 8);
  plant(30, ToySimulation::move_stage, nudge_velocity);
  Report report = verify_bytes(trace, faulty_info);
  CHECK(report.verdict == Verdict::diverged);
  REQUIRE(report.divergence);
  CHECK(report.divergence->tick == 30);
  CHECK(!report.divergence->stage);
  CHECK(report.divergence->tables.empty());
  REQUIRE(report.again.size() == 2);
  CHECK(contains(report.again[1], "--detail full:30..30"));

  plant(31, ToySimulation::move_stage, nudge_velocity);
  report = verify_bytes(trace, faulty_info);
  REQUIRE(report.divergence);
  CHECK(report.divergence->tick == 31);
  REQUIRE(report.divergence->rows.size() == 1);
  CHECK(report.divergence->rows[0].column == "velocity");
  CHECK(report.divergence->rows[0].row == 1);
  CHECK(report.divergence->rows[0].lane == 1);
}

TEST_CASE("verify: time of a divergence is the sum of the dt before it", "[verifier][verify][analytic]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 50, 8);
  plant(30, ToySimulation::move_stage, nudge_velocity);
  const Report report = verify_bytes(trace, faulty_info);
  REQUIRE(report.divergence);
  CHECK(report.divergence->time_s == 24 * 0.015625 + 6 * 0.0078125);
  CHECK(contains(report.divergence->inputs, "{\"tick\":30,\"type\":\"spawn\""));
}

// Each object begins otherwise, as with a member that is not initialised.
class Uninitialised : public ToySimulation {
 public:
  explicit Uninitialised(std::uint32_t body_count) : ToySimulation(body_count) {
    static std::uint32_t made = 0;
    const std::uint32_t garbage = ++made;
    disturb = [garbage](ToySimulation& self, std::size_t stage) {
      if (stage == move_stage && self.world.tick_count == 21) self.bodies[0].hits = static_cast<std::uint16_t>(garbage);
    };
  }
};
const SimulationInfo uninitialised_info{"ticktrue.toy", 1, &make_toy<Uninitialised>};

TEST_CASE("verify: two runs that differ are not reproducible, not diverged", "[verifier][verify][determinism]") {
  for (const bool full : {false, true}) {
    const Bytes trace = toy_trace_with(full ? full_toy_setup(6, 0, 100) : toy_setup(6), 50, 0);
    for (const VerifyMode mode : {VerifyMode::replay, VerifyMode::restore, VerifyMode::twice}) {
      CAPTURE(full, int(mode));
      const Report report = verify_bytes(trace, uninitialised_info, mode);
      CHECK(report.verdict == Verdict::not_reproducible);
      CHECK(report.exit_code() == 6);
      REQUIRE(report.divergence);
      CHECK(report.divergence->tick == 20);
      REQUIRE(report.divergence->rows.size() == 1);
      CHECK(report.divergence->rows[0].column == "hits");
      CHECK(contains(report.reason, "two runs here differ from tick 20 on"));
    }
  }
}

// Every second object is right: the first run agrees with the trace as far as the second goes, or the other way round.
class EverySecond : public ToySimulation {
 public:
  static inline std::uint32_t made = 0;
  explicit EverySecond(std::uint32_t body_count) : ToySimulation(body_count) {
    const std::uint64_t tick = ++made % 2 == 0 ? 11 : 31;
    disturb = [tick](ToySimulation& self, std::size_t stage) {
      if (stage == move_stage && self.world.tick_count == tick) self.bodies[0].hits += 1;
    };
  }
};
const SimulationInfo every_second_info{"ticktrue.toy", 1, &make_toy<EverySecond>};

TEST_CASE("verify: a second run that leaves the trace earlier than the first is told at that tick",
          "[verifier][verify][determinism]") {
  const Bytes trace = toy_trace_with(full_toy_setup(6, 0, 100), 50, 0);
  std::vector<std::uint64_t> ticks;
  for (std::uint32_t offset = 0; offset < 2; ++offset) {
    EverySecond::made = offset;
    const Report report = verify_bytes(trace, every_second_info);
    CHECK(report.verdict == Verdict::not_reproducible);
    REQUIRE(report.divergence);
    CHECK(report.divergence->tick == 10);
    REQUIRE(report.divergence->rows.size() == 1);
    CHECK(report.divergence->rows[0].column == "hits");
  }
}

TEST_CASE("verify: a value that is not finite here is located like any other", "[verifier][verify][analytic]") {
  const Bytes trace = toy_trace_with(full_toy_setup(6, 0, 100), 50, 8);
  plant(13, ToySimulation::move_stage, [](ToySimulation& toy) { toy.bodies[2].position[0] = std::nan(""); });
  const Report report = verify_bytes(trace, faulty_info);
  CHECK(report.verdict == Verdict::diverged);
  REQUIRE(report.divergence);
  CHECK(report.divergence->tick == 13);
  REQUIRE(report.divergence->rows.size() == 1);
  CHECK(report.divergence->rows[0].column == "position");
  CHECK(report.divergence->rows[0].row == 2);
  REQUIRE(report.notes.size() == 1);
  CHECK(contains(report.notes[0], "not finite: bodies row 2"));
}

Bytes non_finite_trace(bool with_inputs) {
  const TemporaryFolder folder;
  auto simulation = *make_faulty(ToySimulation::setup(4));
  ScriptedInputs source([&](std::uint64_t tick) -> Result<std::optional<std::pair<double, Bytes>>> {
    ToyInputs inputs;
    if (with_inputs && tick == 12) inputs.poison(2);
    return std::optional(std::pair(0.015625, inputs.take()));
  });
  replay::RecordOptions options;
  options.writer = plain_writer();
  const auto result = replay::record(*simulation, source, folder.file("toy.ttr"), toy_setup(4), toy_facts, options);
  REQUIRE(result);
  REQUIRE(result->reason == replay::EndReason::non_finite);
  return read_file(folder.file("toy.ttr"));
}

TEST_CASE("verify: a recording that ended in a non-finite value matches if the same happens here",
          "[verifier][verify][analytic]") {
  plant(12, ToySimulation::move_stage, [](ToySimulation&) {});
  const Bytes by_input = non_finite_trace(true);
  Report report = verify_bytes(by_input, toy_info);
  CHECK(report.verdict == Verdict::match);
  REQUIRE(report.notes.size() == 1);
  CHECK(contains(report.notes[0], "tick 12 is not finite, as recorded: bodies row 2 (toy_2)"));

  // The recording build had a bug that needs no input. This build has none, or has it elsewhere.
  const auto poison = [](std::size_t body) {
    return [body](ToySimulation& toy) { toy.bodies[body].velocity[0] = INFINITY; };
  };
  plant(12, ToySimulation::move_stage, poison(1));
  const Bytes by_bug = non_finite_trace(false);
  CHECK(verify_bytes(by_bug, faulty_info).verdict == Verdict::match);
  report = verify_bytes(by_bug, toy_info);
  CHECK(report.verdict == Verdict::diverged);
  CHECK(contains(report.reason, "here it is finite"));
  plant(12, ToySimulation::move_stage, poison(3));
  report = verify_bytes(by_bug, faulty_info);
  CHECK(report.verdict == Verdict::diverged);
  CHECK(contains(report.reason, "here it is not finite at bodies row 3"));
}

TEST_CASE("verify: a recording whose first tick is not finite has nothing to compare", "[verifier][verify][analytic]") {
  const TemporaryFolder folder;
  ToySimulation simulation(4);
  ScriptedInputs source([](std::uint64_t) -> Result<std::optional<std::pair<double, Bytes>>> {
    return std::optional(std::pair(0.015625, ToyInputs().poison(2).take()));
  });
  replay::RecordOptions options;
  options.writer = plain_writer();
  REQUIRE(replay::record(simulation, source, folder.file("toy.ttr"), toy_setup(4), toy_facts, options));
  const Report report = verify_bytes(read_file(folder.file("toy.ttr")), toy_info);
  CHECK(report.verdict == Verdict::incomplete);
  CHECK(report.exit_code() == 3);
  CHECK(report.reason == "no tick was compared: the first one is not finite, as recorded");
  REQUIRE(report.non_finite);
  CHECK(report.non_finite->tick == 0);
  CHECK(report.non_finite->row == 2);
}

TEST_CASE("verify: a state that never changes matches with a warning", "[verifier][verify][analytic]") {
  // Without bodies only the world's tick count changes.
  const TemporaryFolder folder;
  ToySimulation simulation(0);
  replay::NoInputs source(0.015625);
  replay::RecordOptions options;
  options.tick_count = 20;
  options.writer = plain_writer();
  REQUIRE(replay::record(simulation, source, folder.file("still.ttr"), toy_setup(0), toy_facts, options));
  const Report report = verify_bytes(read_file(folder.file("still.ttr")), toy_info);
  CHECK(report.verdict == Verdict::match);
  CHECK(report.exit_code() == 0);
  REQUIRE(report.warnings.size() == 1);
  CHECK(contains(report.warnings[0], "no state outside table world changed in 20 ticks"));
}

TEST_CASE("verify: no tick compared is not a match", "[verifier][verify][analytic]") {
  const Bytes empty = toy_trace_with(toy_setup(3), 0, 0);
  Report report = verify_bytes(empty, toy_info);
  CHECK(report.verdict == Verdict::incomplete);
  CHECK(report.exit_code() == 3);
  CHECK(report.exit_code(true) == 3);
  CHECK(report.reason == "no tick was compared");

  VerifyOptions options = verify_options(toy_info);
  options.from = 100;
  report = verify_bytes(toy_trace_with(toy_setup(3), 20, 5), options);
  CHECK(report.verdict == Verdict::incomplete);
}

class OtherSchema : public ToySimulation {
 public:
  explicit OtherSchema(std::uint32_t body_count) : ToySimulation(body_count), schema_(schema()) {
    schema_.tables[1].columns[5].name = "colour";
    view_ = ToySimulation::state();
    view_.schema = &schema_;
  }
  const StateView& state() const override {
    view_ = ToySimulation::state();
    view_.schema = &schema_;
    return view_;
  }

 private:
  StateSchema schema_;
  mutable StateView view_;
};
class OtherStages : public ToySimulation {
 public:
  using ToySimulation::ToySimulation;
  std::span<const std::string> stage_names() const override {
    static const std::vector<std::string> names{"inputs", "move"};
    return names;
  }
};
class Picky : public ToySimulation {
 public:
  using ToySimulation::ToySimulation;
  Status accept(const TickInput& input) const override {
    if (world.tick_count == 9) return Error{ErrorCode::invalid_input, "toy input: too much gravity", ""};
    return ToySimulation::accept(input);
  }
};
Result<std::unique_ptr<Simulation>> refuse_setup(ByteView) {
  return Error{ErrorCode::invalid_scene, "toy setup: no such thing", ""};
}

TEST_CASE("verify: what this build is not cannot be compared", "[verifier][verify][analytic]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 30, 8);
  const SimulationInfo other_name{"ticktrue.other", 1, &ToySimulation::make};
  const SimulationInfo other_physics{"ticktrue.toy", 2, &ToySimulation::make};
  const SimulationInfo other_schema{"ticktrue.toy", 1, &make_toy<OtherSchema>};
  const SimulationInfo other_stages{"ticktrue.toy", 1, &make_toy<OtherStages>};
  const SimulationInfo picky{"ticktrue.toy", 1, &make_toy<Picky>};
  const SimulationInfo refusing{"ticktrue.toy", 1, &refuse_setup};
  const std::pair<const SimulationInfo*, const char*> cases[] = {
      {nullptr, "simulation ticktrue.toy is not available"},
      {&other_name, "simulation ticktrue.toy is not available"},
      {&other_physics, "physics version: recorded with 1, here 2"},
      {&other_schema, "schema: column 5 of bodies: recorded hits, here colour"},
      {&other_stages, "stages: recorded inputs, forces, move; here inputs, move"},
      {&picky, "tick 9: recorded inputs are refused here: toy input: too much gravity"},
      {&refusing, "setup refused here: toy setup: no such thing"},
  };
  for (const auto& [info, reason] : cases) {
    CAPTURE(reason);
    VerifyOptions options;
    options.simulation = info;
    const Report report = verify_bytes(trace, options);
    CHECK(report.verdict == Verdict::not_comparable);
    CHECK(report.exit_code() == 5);
    CHECK(contains(report.reason, reason));
    CHECK(!report.divergence);
    CHECK(report.ticks_recorded == 30u);
  }
}

class LoadForgets : public ToySimulation {
 public:
  using ToySimulation::ToySimulation;
  Status load(ByteView image) override {
    const Status loaded = ToySimulation::load(image);
    if (loaded)
      for (ToyBody& body : bodies) body.hits = 0;
    return loaded;
  }
};
// A value that influences later ticks is neither registered nor loaded.
class HiddenState : public ToySimulation {
 public:
  explicit HiddenState(std::uint32_t body_count) : ToySimulation(body_count) {
    disturb = [this](ToySimulation& self, std::size_t stage) {
      if (stage == move_stage && ++steps_ % 20 == 0) self.bodies[0].hits += 1;
    };
  }

 private:
  int steps_ = 0;
};
class RefusesLoad : public ToySimulation {
 public:
  using ToySimulation::ToySimulation;
  Status load(ByteView image) override {
    if (image.empty()) return ToySimulation::load(image);
    return Error{ErrorCode::corrupt, "toy image: not today", ""};
  }
};
class RefusesToLoad : public ToySimulation {
 public:
  using ToySimulation::ToySimulation;
  Status load(ByteView) override { return Error{ErrorCode::unsupported, "toy: observed only", ""}; }
};

template <typename Toy>
Bytes trace_of(std::uint64_t tick_count, std::uint32_t interval) {
  const TemporaryFolder folder;
  Toy simulation(6);
  ScriptedInputs source(lively_script);
  replay::RecordOptions options;
  options.tick_count = tick_count;
  options.writer = plain_writer();
  replay::TraceSetup setup = toy_setup(6);
  setup.checkpoint_interval = interval;
  REQUIRE(replay::record(simulation, source, folder.file("toy.ttr"), setup, toy_facts, options));
  return read_file(folder.file("toy.ttr"));
}

TEST_CASE("verify: restore catches a load that forgets a column, which replay cannot see",
          "[verifier][verify][analytic]") {
  const SimulationInfo info{"ticktrue.toy", 1, &make_toy<LoadForgets>};
  const Bytes trace = trace_of<LoadForgets>(100, 40);
  CHECK(verify_bytes(trace, info).verdict == Verdict::match);
  const Report report = verify_bytes(trace, info, VerifyMode::restore);
  CHECK(report.verdict == Verdict::state_incomplete);
  CHECK(report.exit_code() == 1);
  CHECK(report.checkpoint == 80u);
  REQUIRE(report.divergence);
  CHECK(report.divergence->tick == 80);  // at 40 nothing has been hit yet
  CHECK(report.divergence->stage == "load");
  REQUIRE(report.divergence->tables.size() == 1);
  CHECK(report.divergence->tables[0].columns == std::vector<std::string>{"hits"});
}

TEST_CASE("verify: restore catches state that is not shown", "[verifier][verify][analytic]") {
  const SimulationInfo info{"ticktrue.toy", 1, &make_toy<HiddenState>};
  const Bytes trace = trace_of<HiddenState>(100, 30);
  CHECK(verify_bytes(trace, info).verdict == Verdict::match);
  const Report report = verify_bytes(trace, info, VerifyMode::restore);
  CHECK(report.verdict == Verdict::state_incomplete);
  CHECK(report.checkpoint == 30u);
  REQUIRE(report.divergence);
  CHECK(report.divergence->tick == 39);

  // With close checkpoints, runs that end at the next checkpoint do not notice it.
  const Bytes close = trace_of<HiddenState>(100, 20);
  VerifyOptions options = verify_options(info, VerifyMode::restore);
  CHECK(verify_bytes(close, options).verdict == Verdict::match);
}

TEST_CASE("verify: a load that refuses an intact checkpoint is a finding", "[verifier][verify][analytic]") {
  const SimulationInfo info{"ticktrue.toy", 1, &make_toy<RefusesLoad>};
  const Report report = verify_bytes(trace_of<RefusesLoad>(30, 10), info, VerifyMode::restore);
  CHECK(report.verdict == Verdict::state_incomplete);
  REQUIRE(report.divergence);
  CHECK(report.divergence->stage == "load");
  CHECK(contains(report.reason, "not today"));
}

TEST_CASE("verify: a simulation that cannot load is replayed from the start and not restored",
          "[verifier][verify][analytic]") {
  const SimulationInfo info{"ticktrue.toy", 1, &make_toy<RefusesToLoad>};
  const Bytes trace = trace_of<RefusesToLoad>(30, 10);
  VerifyOptions options = verify_options(info);
  options.from = 25;
  const Report report = verify_bytes(trace, options);
  CHECK(report.verdict == Verdict::match);
  CHECK(report.ticks_compared == 5);
  CHECK(verify_bytes(trace, info, VerifyMode::restore).verdict == Verdict::not_comparable);
}

class OtherStart : public ToySimulation {
 public:
  explicit OtherStart(std::uint32_t body_count) : ToySimulation(body_count) { bodies[3].charge += 1; }
};

TEST_CASE("verify: another initial state is told before the first tick", "[verifier][verify][analytic]") {
  const SimulationInfo info{"ticktrue.toy", 1, &make_toy<OtherStart>};
  const Report report = verify_bytes(toy_trace_with(toy_setup(6), 30, 10), info);
  CHECK(report.verdict == Verdict::diverged);
  CHECK(report.ticks_compared == 0);
  REQUIRE(report.divergence);
  CHECK(report.divergence->stage == "setup");
  REQUIRE(report.divergence->rows.size() == 1);
  CHECK(report.divergence->rows[0].column == "charge");
  CHECK(report.divergence->rows[0].name == "toy_3");
}

TEST_CASE("verify: a cut trace is incomplete, names its last good tick, and --allow-truncated accepts it",
          "[verifier][verify][corruption]") {
  const Bytes trace = toy_trace_with(toy_setup(4), 40, 8);
  const std::uint64_t whole = 40;
  int incomplete_count = 0;
  for (std::size_t size = 0; size < trace.size(); ++size) {
    CAPTURE(size);
    auto reader = replay::TraceReader::open_bytes(ByteView(trace).first(size), "cut.ttr");
    const Report report =
        reader ? verify(*reader, verify_options(toy_info)) : verifier::open_error_report("cut.ttr", reader.error());
    CHECK(report.verdict == Verdict::incomplete);
    CHECK(report.exit_code() == 3);
    if (!reader || !report.end) continue;
    CHECK(report.ticks_compared == report.end->tail.ticks_intact);
    CHECK(report.ticks_compared <= whole);
    CHECK(report.exit_code(true) == (report.ticks_compared > 0 ? 0 : 3));
    ++incomplete_count;
    if (report.end->tail.has_pending_inputs && !report.end->tail.pending_inputs.empty())
      CHECK(!report.end->pending_inputs.empty());
  }
  CHECK(incomplete_count > 100);
}

TEST_CASE("verify: a changed byte is never a match, an error of the call or a divergence",
          "[verifier][verify][corruption]") {
  const Bytes trace = toy_trace_with(toy_setup(2), 6, 4);
  Bytes changed = trace;
  for (std::size_t i = 0; i < trace.size(); ++i)
    for (const int mask : {0x01, 0x80, 0xff}) {
      CAPTURE(i, mask);
      changed[i] = static_cast<std::uint8_t>(trace[i] ^ mask);
      auto reader = replay::TraceReader::open_bytes(changed, "changed.ttr");
      const Report report = reader ? verify(*reader, verify_options(toy_info))
                                   : verifier::open_error_report("changed.ttr", reader.error());
      const int code = report.exit_code();
      CHECK((code == 3 || code == 4 || code == 5));
      changed[i] = trace[i];
    }
}

TEST_CASE("verify: damage leaves what is before it proven, and a divergence before it counts more",
          "[verifier][verify][corruption]") {
  Bytes trace = toy_trace_with(toy_setup(4), 3000, 1000);
  const std::vector<ChunkPlace> places = chunk_places(trace);
  // The chunk in the middle.
  const ChunkPlace& place = places[places.size() / 2];
  trace[place.offset + place.size / 2] ^= 0x10;
  Report report = verify_bytes(trace, toy_info);
  CHECK(report.verdict == Verdict::damaged);
  CHECK(report.exit_code() == 4);
  REQUIRE(report.ticks_compared > 0);
  REQUIRE(report.ticks_compared < 3000);
  REQUIRE(report.end);
  CHECK(report.ticks_compared == report.end->tail.ticks_intact);
  CHECK(!report.end->tail.intact_after.empty());
  CHECK(contains(report.hint, "--to " + std::to_string(report.ticks_compared - 1)));

  VerifyOptions options = verify_options(toy_info);
  options.to = report.ticks_compared - 1;
  CHECK(verify_bytes(trace, options).verdict == Verdict::match);

  plant(17, ToySimulation::move_stage, nudge_velocity);
  report = verify_bytes(trace, faulty_info);
  CHECK(report.verdict == Verdict::diverged);
  CHECK(report.exit_code() == 1);
  REQUIRE(report.end);
  CHECK(report.end->tail.condition == replay::TraceCondition::damaged);
}

TEST_CASE("verify: a part of a trace is compared on its own", "[verifier][verify][equivalence]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 50, 8);
  plant(20, ToySimulation::move_stage, nudge_velocity);
  for (const auto& [from, to, verdict] :
       {std::tuple{24u, 49u, Verdict::match}, std::tuple{0u, 19u, Verdict::match}, std::tuple{24u, 24u, Verdict::match},
        std::tuple{18u, 30u, Verdict::diverged}, std::tuple{0u, 20u, Verdict::diverged}}) {
    CAPTURE(from, to);
    VerifyOptions options = verify_options(faulty_info);
    options.from = from;
    options.to = to;
    const Report report = verify_bytes(trace, options);
    CHECK(report.verdict == verdict);
    if (verdict == Verdict::match) CHECK(report.ticks_compared == to - from + 1);
    CHECK(report.ticks_recorded == 50u);
  }
}

}  // namespace
}  // namespace ticktrue::test
