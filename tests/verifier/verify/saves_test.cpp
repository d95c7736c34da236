// Checkpoints with saves of the simulation: where runs begin, what they find, and what a recording does without a save.
// SPDX-License-Identifier: MIT
#include <mutex>
#include <utility>
#include <vector>

#include "tests/support/catch.h"
#include "tests/verifier/toy_variants.h"

namespace ticktrue::test {
namespace {

using verifier::Report;
using verifier::Verdict;
using verifier::VerifyMode;
using verifier::VerifyOptions;

constexpr std::uint64_t recorded_ticks = 100;
constexpr std::uint32_t interval = 10;

/// What SavingToy does next, and what it did.
struct SavingPlan {
  std::uint64_t save_interval = interval;  // ticks between those at which it has a save; 0: never
  bool forgets = false;                    // load leaves the hidden counter as it was
  std::uint64_t fails_at = ~std::uint64_t{0};
  bool loads_images = false;
  bool drifts = false;   // the hidden counter counts twice in the last step before a checkpoint
  bool is_late = false;  // the first load lets a value change five steps later
  bool breaks = false;   // the first load lets the fifth step behind it fail
};
SavingPlan plan;
std::mutex loads_lock;
std::vector<std::uint64_t> loads;  // ticks of the saves that were loaded

/// Changes a value in every twentieth step since its beginning: the count is in its save and in no column.
class SavingToy : public ToySimulation {
 public:
  explicit SavingToy(std::uint32_t body_count) : ToySimulation(body_count) {
    disturb = [this](ToySimulation& self, std::size_t stage) {
      if (stage != move_stage) return;
      if (++steps_ % 20 == 0) self.bodies[0].hits += 1;
      if (++tick_ % interval == 0 && plan.drifts) ++steps_;
      if (steps_to_change_ > 0 && --steps_to_change_ == 0) self.bodies[0].hits += 1;
    };
  }

  Status step(const TickInput& input, StageObserver* observer) override {
    if (steps_to_break_ > 0 && --steps_to_break_ == 0) return Error{ErrorCode::limit, "no room for a step", ""};
    return ToySimulation::step(input, observer);
  }
  Status load(ByteView image) override {
    if (plan.loads_images) return ToySimulation::load(image);
    return Error{ErrorCode::unsupported, "observed", ""};
  }
  Result<std::optional<Bytes>> save(std::uint64_t tick) override {
    if (tick == plan.fails_at) return Error{ErrorCode::usage, "no room for a save", ""};
    if (plan.save_interval == 0 || tick % plan.save_interval != 0) return std::optional<Bytes>();
    ByteWriter out;
    out.u32(steps_);
    Bytes bytes = out.take(), image;
    encode_image(state(), image);
    bytes.insert(bytes.end(), image.begin(), image.end());
    return std::optional<Bytes>(std::move(bytes));
  }
  Status load_saved(std::uint64_t tick, ByteView save) override {
    {
      const std::lock_guard guard(loads_lock);
      loads.push_back(tick);
    }
    if (save.size() < 4) return Error{ErrorCode::usage, "a save of another size", ""};
    tick_ = tick;
    const bool is_first = !std::exchange(is_loaded_, true);
    if (plan.is_late && is_first) steps_to_change_ = 5;
    if (plan.breaks && is_first) steps_to_break_ = 5;
    if (!plan.forgets) steps_ = ByteReader(save).u32();
    return ToySimulation::load(save.subspan(4));
  }

 private:
  std::uint32_t steps_ = 0;  // in no column
  std::uint64_t tick_ = 0;
  std::uint32_t steps_to_change_ = 0;
  std::uint32_t steps_to_break_ = 0;
  bool is_loaded_ = false;
};

SimulationInfo saving_info() {
  SimulationInfo info{"ticktrue.toy", 1, &make_toy<SavingToy>};
  info.has_saves = true;
  return info;
}

replay::TraceSetup saving_setup(bool is_full) {
  replay::TraceSetup setup = is_full ? full_toy_setup(6, 0, recorded_ticks) : toy_setup(6);
  setup.checkpoint_interval = interval;
  setup.features = static_cast<std::uint32_t>(replay::Feature::saves);
  return setup;
}

Result<replay::RecordResult> record_saving(const std::string& path, const replay::TraceSetup& setup) {
  SavingToy simulation(6);
  ScriptedInputs source(lively_script);
  replay::RecordOptions options;
  options.tick_count = recorded_ticks;
  options.writer = plain_writer();
  return replay::record(simulation, source, path, setup, toy_facts, options);
}

Bytes saving_trace(const replay::TraceSetup& setup) {
  const TemporaryFolder folder;
  const auto recorded = record_saving(folder.file("toy.ttr"), setup);
  if (!recorded) FAIL(recorded.error().message);
  return read_file(folder.file("toy.ttr"));
}

/// Every way in which runs begin at checkpoints.
std::vector<VerifyOptions> ways(ByteView trace, const SimulationInfo& info) {
  std::vector<VerifyOptions> all;
  for (const VerifyMode mode : {VerifyMode::replay, VerifyMode::restore})
    for (const unsigned thread_count : {1u, 3u}) {
      VerifyOptions options = verify_options(info, mode);
      options.thread_count = thread_count;
      options.in_segments = true;
      options.reopen = [trace]() -> std::unique_ptr<verifier::TraceSource> {
        return std::make_unique<verifier::OwnedReaderSource>(open_trace(trace));
      };
      all.push_back(options);
    }
  VerifyOptions from = verify_options(info);
  from.from = 35;
  all.push_back(from);
  VerifyOptions to_end = verify_options(info, VerifyMode::restore);
  to_end.to_end = true;
  all.push_back(to_end);
  return all;
}

}  // namespace

TEST_CASE("saves: what is in a save and in no column comes back in every run from a checkpoint",
          "[verifier][saves][equivalence]") {
  plan = {};
  const SimulationInfo info = saving_info();
  for (const bool is_full : {false, true}) {
    const Bytes trace = saving_trace(saving_setup(is_full));
    for (const VerifyOptions& options : ways(trace, info)) {
      CAPTURE(is_full, int(options.mode), options.thread_count, options.from);
      loads.clear();
      const Report report = verify_bytes(trace, options);
      CAPTURE(report.reason);
      CHECK(report.verdict == Verdict::match);
      CHECK(report.ticks_compared == recorded_ticks - options.from);
      // A run of the whole trace is one run in order, however many threads or segments are asked for.
      CHECK(loads.empty() == (options.mode == VerifyMode::replay && options.from == 0));
    }
  }
}

TEST_CASE("saves: a hidden difference that each save undoes is a divergence in every way of comparing the whole trace",
          "[verifier][saves][analytic]") {
  plan = {};
  const Bytes trace = saving_trace(saving_setup(true));
  plan.drifts = true;
  for (const VerifyOptions& options : ways(trace, saving_info())) {
    CAPTURE(int(options.mode), options.thread_count, options.from, options.to_end);
    const Report report = verify_bytes(trace, options);
    CHECK(report.verdict == Verdict::diverged);
    REQUIRE(report.divergence);
    CHECK(report.divergence->tick == (options.from > 0 ? 57 : 18));  // from the save of tick 30 on, it drifts later
  }
  plan = {};
}

TEST_CASE("saves: restore loads the save of each checkpoint, and says so", "[verifier][saves][analytic]") {
  plan = {};
  const SimulationInfo info = saving_info();
  loads.clear();
  const Report report = verify_bytes(saving_trace(saving_setup(false)), info, VerifyMode::restore);
  CHECK(report.verdict == Verdict::match);
  CHECK(loads == std::vector<std::uint64_t>{0, 10, 20, 30, 40, 50, 60, 70, 80, 90});
  REQUIRE(report.notes.size() == 1);
  CHECK(contains(report.notes[0], "begin with its save, which ticktrue.toy loads"));
}

TEST_CASE("saves: what load forgets is state_incomplete with tick, table, column and the save",
          "[verifier][saves][analytic]") {
  plan = {};
  plan.forgets = true;
  const SimulationInfo info = saving_info();
  const Bytes trace = saving_trace(saving_setup(true));
  for (const VerifyOptions& options : ways(trace, info)) {
    CAPTURE(int(options.mode), options.thread_count, options.from);
    const Report report = verify_bytes(trace, options);
    if (options.mode == VerifyMode::replay && options.from == 0) {  // nothing is loaded
      CHECK(report.verdict == Verdict::match);
      continue;
    }
    CHECK(report.verdict == Verdict::state_incomplete);
    const std::uint64_t save = options.from > 0 ? 30 : 10;
    CHECK(report.checkpoint == save);
    CHECK(contains(report.reason,
                   "the run from the start matches, the run from the save of tick " + std::to_string(save)));
    CHECK(contains(report.hint, "is not in the save, or load does not bring it back"));
    REQUIRE(report.divergence);
    // The count of the recording passes a multiple of 20 first.
    CHECK(report.divergence->tick == (options.from > 0 ? 39u : 19u));
    REQUIRE(report.divergence->tables.size() == 1);
    CHECK(report.divergence->tables[0].table == "bodies");
    CHECK(report.divergence->tables[0].columns == std::vector<std::string>{"hits"});
  }
}

TEST_CASE("saves: without its saves the same trace is restored from images, and the hidden count is missing",
          "[verifier][saves][analytic]") {
  plan = {};
  plan.loads_images = true;
  SimulationInfo info = saving_info();
  info.has_saves = false;
  const Bytes trace = saving_trace(saving_setup(true));
  loads.clear();
  const Report report = verify_bytes(trace, info, VerifyMode::restore);
  CHECK(report.verdict == Verdict::state_incomplete);
  CHECK(contains(report.reason, "the run from the checkpoint of tick 10"));
  CHECK(loads.empty());
}

TEST_CASE("saves: a checkpoint without a save is compared, and no run begins there", "[verifier][saves][analytic]") {
  plan = {};
  plan.save_interval = 40;
  const SimulationInfo info = saving_info();
  const TemporaryFolder folder;
  const auto recorded = record_saving(folder.file("toy.ttr"), saving_setup(false));
  REQUIRE(recorded);
  CHECK(recorded->saves_missing == 8);
  const Bytes trace = read_file(folder.file("toy.ttr"));
  loads.clear();
  const Report report = verify_bytes(trace, info, VerifyMode::restore);
  CHECK(report.verdict == Verdict::match);
  CHECK(loads == std::vector<std::uint64_t>{0, 40, 80});
  VerifyOptions from = verify_options(info);
  for (const auto& [first, begin] : {std::pair(39, 0), std::pair(79, 40), std::pair(99, 80)}) {
    CAPTURE(first);
    loads.clear();
    from.from = static_cast<std::uint64_t>(first);
    const Report part = verify_bytes(trace, from);
    CHECK(part.verdict == Verdict::match);
    CHECK(part.ticks_compared == recorded_ticks - from.from);
    CHECK(loads == (begin == 0 ? std::vector<std::uint64_t>{} : std::vector<std::uint64_t>(1, std::uint64_t(begin))));
  }
}

TEST_CASE("saves: a trace that begins late, and without a save, is not comparable", "[verifier][saves][late]") {
  plan = {};
  replay::TraceSetup setup = saving_setup(false);
  setup.features |= static_cast<std::uint32_t>(replay::Feature::tail);
  const TemporaryFolder folder;
  replay::WriterOptions options = plain_writer();
  options.allow_third = true;
  auto writer = replay::TraceWriter::create(folder.file("late.ttr"), setup, toy_facts, options);
  REQUIRE(writer);
  SavingToy toy(6);
  const TickInput input{0.015625, {}};
  for (int tick = 0; tick < 13; ++tick) REQUIRE(toy.step(input, nullptr));
  writer->begin_at(13, 13 * input.dt);
  REQUIRE(writer->checkpoint(toy.state(), root_hash(toy.state())));
  for (int tick = 13; tick < 20; ++tick) {
    REQUIRE(writer->begin_tick(input));
    REQUIRE(toy.step(input, nullptr));
    REQUIRE(writer->end_tick(root_hash(toy.state()), {}, &toy.state()));
  }
  REQUIRE(writer->finish(replay::EndReason::complete, ""));
  loads.clear();
  for (const VerifyMode mode : {VerifyMode::replay, VerifyMode::restore, VerifyMode::twice}) {
    const Report report = verify_bytes(read_file(folder.file("late.ttr")), saving_info(), mode);
    CHECK(report.verdict == Verdict::not_comparable);
    CHECK(report.reason == "begins at tick 13 with a checkpoint without a save");
  }
  CHECK(loads.empty());
}

TEST_CASE("saves: where there is none, nothing is loaded, and the report says why", "[verifier][saves][analytic]") {
  plan = {};
  plan.save_interval = 0;
  const SimulationInfo info = saving_info();
  const Bytes empty = saving_trace(saving_setup(false));
  CHECK(verify_bytes(empty, info).verdict == Verdict::match);
  const Report none = verify_bytes(empty, info, VerifyMode::restore);
  CHECK(none.verdict == Verdict::not_comparable);
  CHECK(none.reason == "no checkpoint has a save: there is nothing to load");

  replay::TraceSetup setup = saving_setup(false);
  setup.features = 0;
  const Bytes older = saving_trace(setup);
  CHECK(verify_bytes(older, info).verdict == Verdict::match);
  const Report lacks = verify_bytes(older, info, VerifyMode::restore);
  CHECK(lacks.verdict == Verdict::not_comparable);
  CHECK(lacks.reason == "the trace holds no saves, and ticktrue.toy loads nothing else");
  CHECK(open_trace(older).setup().features == 0);
}

TEST_CASE("saves: a simulation that cannot give one ends the recording, which keeps the ticks before",
          "[verifier][saves][corruption]") {
  plan = {};
  const TemporaryFolder folder;
  plan.fails_at = 30;
  const auto later = record_saving(folder.file("later.ttr"), saving_setup(false));
  REQUIRE(!later);
  CHECK(later.error().message == "no room for a save");
  CHECK(contains(later.error().hint, "holds the 30 ticks before"));
  CHECK(verify_bytes(read_file(folder.file("later.ttr")), saving_info()).ticks_compared == 30);
  plan.fails_at = 0;
  CHECK(!record_saving(folder.file("first.ttr"), saving_setup(false)));
  CHECK(read_file(folder.file("first.ttr")).empty());
  plan = {};
}

namespace {

Report sync_report(ByteView trace, const SimulationInfo& info, std::uint64_t ticks, std::uint64_t from = 0) {
  VerifyOptions options = verify_options(info);
  options.sync_ticks = ticks;
  options.from = from;
  options.thread_count = 3;  // in order all the same
  options.in_segments = true;
  return verify_bytes(trace, options);
}

}  // namespace

TEST_CASE("sync test: every tick runs twice, for every number of ticks at once", "[verifier][sync][equivalence]") {
  plan = {};
  const Bytes trace = saving_trace(saving_setup(true));
  plan.save_interval = 1;
  struct Row {
    std::uint64_t ticks;
    std::size_t load_count;  // every other second run of several ticks, and the first, begins twice
  };
  for (const auto& [ticks, load_count] :
       {Row{1, 100}, Row{3, 34 + 17}, Row{7, 15 + 8}, Row{64, 2 + 1}, Row{100, 1 + 1}, Row{1'000, 1 + 1}}) {
    CAPTURE(ticks);
    loads.clear();
    const Report report = sync_report(trace, saving_info(), ticks);
    CAPTURE(report.reason);
    CHECK(report.verdict == Verdict::match);
    CHECK(report.ticks_compared == recorded_ticks);
    REQUIRE(report.notes.size() == 1);
    CHECK(report.notes[0] == "sync test: 100 ticks ran twice with the same state");
    CHECK(loads.size() == load_count);
  }
  const Report late = sync_report(trace, saving_info(), 4, 35);
  CHECK(late.verdict == Verdict::match);
  CHECK(late.ticks_compared == recorded_ticks - 35);
  CHECK(late.notes[0] == "sync test: 70 ticks ran twice with the same state");  // from the save of tick 30 on
}

TEST_CASE("sync test: what load forgets is state_incomplete with tick, table, column and the save",
          "[verifier][sync][injection]") {
  plan = {};
  const Bytes trace = saving_trace(saving_setup(true));
  plan.save_interval = 1;
  plan.forgets = true;
  int second_count = 0;
  // The hidden count of 20 is in step again behind 20 ticks: found since every other run begins twice.
  for (const std::uint64_t ticks : {1, 3, 7, 10, 20, 100}) {
    CAPTURE(ticks);
    const Report report = sync_report(trace, saving_info(), ticks);
    CHECK(report.verdict == Verdict::state_incomplete);
    REQUIRE(report.divergence);
    const std::uint64_t tick = report.divergence->tick;
    REQUIRE(report.checkpoint);
    CHECK(*report.checkpoint % ticks == 0);
    CHECK(*report.checkpoint <= tick);
    // The count that load left shows in a second run, or in the first run of the ticks behind it.
    const bool is_second = tick < *report.checkpoint + ticks;
    CHECK(report.reason ==
          "tick " + std::to_string(tick) +
              (is_second
                   ? " ended in two states: the second run began with the save of tick "
                   : " is as recorded where no tick runs twice, and not behind the second run that began with tick ") +
              std::to_string(*report.checkpoint));
    second_count += is_second ? 1 : 0;
    CHECK(contains(report.hint, "not in what save gives"));
    REQUIRE(report.divergence->tables.size() == 1);
    CHECK(report.divergence->tables[0].columns == std::vector<std::string>{"hits"});
    REQUIRE(report.divergence->rows.size() == 1);
    CHECK(report.divergence->rows[0].expected != report.divergence->rows[0].got);
    REQUIRE(!report.again.empty());
    CHECK(contains(report.again[0], " --sync-test " + std::to_string(ticks) + " --from "));
  }
  CHECK(second_count >= 3);
  plan = {};
}

TEST_CASE("sync test: without saves the state comes back from its columns", "[verifier][sync][analytic]") {
  plan = {};
  SimulationInfo info = saving_info();
  info.has_saves = false;
  const Bytes trace = saving_trace(saving_setup(true));
  CHECK(sync_report(trace, info, 5).verdict == Verdict::not_comparable);
  plan.loads_images = true;
  const Report hidden = sync_report(trace, info, 20);
  CHECK(hidden.verdict == Verdict::state_incomplete);
  CHECK(contains(hidden.reason, "began with the state of tick "));
  CHECK(contains(hidden.hint, "is in no column"));
  const Bytes plain = toy_trace(toy_setup(5), 40);
  const Report whole = sync_report(plain, toy_info, 7);
  CHECK(whole.verdict == Verdict::match);
  CHECK(whole.notes == std::vector<std::string>{"sync test: 40 ticks ran twice with the same state"});
  plan = {};
}

TEST_CASE("sync test: what goes wrong behind a second run is no divergence", "[verifier][sync][injection]") {
  plan = {};
  const Bytes trace = saving_trace(saving_setup(true));
  plan.save_interval = 1;
  plan.is_late = true;
  const Report late = sync_report(trace, saving_info(), 3);
  CHECK(late.verdict == Verdict::state_incomplete);
  CHECK(late.checkpoint == 0);
  CHECK(contains(late.reason, "tick 3 is as recorded where no tick runs twice"));
  REQUIRE(late.divergence);
  CHECK(late.divergence->tick == 3);
  CHECK(late.divergence->tables.at(0).columns == std::vector<std::string>{"hits"});
  CHECK(late.divergence->time_s == 3 * 0.015625);
  // A tick that cannot be done there either.
  plan = {};
  plan.save_interval = 1;
  plan.breaks = true;
  const Report broken = sync_report(trace, saving_info(), 3);
  CHECK(broken.verdict == Verdict::state_incomplete);
  CHECK(broken.checkpoint == 0);
  CHECK(contains(broken.reason, "tick 3 is as recorded where no tick runs twice"));
  CHECK(contains(broken.reason, "with tick 0: cannot be done here: no room for a step"));
  REQUIRE(broken.divergence);
  CHECK(broken.divergence->tick == 3);
  CHECK(broken.divergence->time_s == 3 * 0.015625);
  // A build that gives other bits diverges as in any verification.
  plan = {};
  plan.save_interval = 1;
  plan.drifts = true;
  const Report other = sync_report(trace, saving_info(), 3);
  CHECK(other.verdict == Verdict::diverged);
  REQUIRE(other.divergence);
  CHECK(other.divergence->tick == 18);
  plan = {};
}

TEST_CASE("sync test: a save that is missing makes no match, one that fails is told", "[verifier][sync][analytic]") {
  plan = {};
  const Bytes trace = saving_trace(saving_setup(false));
  const Report few = sync_report(trace, saving_info(), 1);
  CHECK(few.verdict == Verdict::incomplete);
  CHECK(few.reason == "sync test: 90 times there was no save");
  plan.save_interval = 0;
  CHECK(sync_report(trace, saving_info(), 1).verdict == Verdict::incomplete);
  plan.save_interval = 1;
  plan.fails_at = 30;
  const Report fails = sync_report(trace, saving_info(), 6);
  CHECK(fails.verdict == Verdict::state_incomplete);
  CHECK(fails.reason == "no room for a save");
  REQUIRE(fails.divergence);
  CHECK(fails.divergence->tick == 30);
  plan = {};
}

}  // namespace ticktrue::test
