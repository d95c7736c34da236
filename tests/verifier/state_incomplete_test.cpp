// What a run from a checkpoint finds is a divergence only if the run from the start has a finding too.
// SPDX-License-Identifier: MIT
#include <atomic>

#include "tests/support/catch.h"
#include "tests/verifier/toy_variants.h"
#include "verifier/report/report_ci.h"

namespace ticktrue::test {
namespace {

using verifier::Report;
using verifier::Verdict;
using verifier::VerifyMode;
using verifier::VerifyOptions;

/// Changes a value in every twentieth step since its creation, whatever was loaded. A variant may diverge for good.
class HiddenCounter : public ToySimulation {
 public:
  explicit HiddenCounter(std::uint32_t body_count, std::uint64_t diverges_at = 0) : ToySimulation(body_count) {
    disturb = [this, diverges_at](ToySimulation& self, std::size_t stage) {
      if (stage != move_stage) return;
      if (++steps_ % 20 == 0) self.bodies[0].hits += 1;
      if (diverges_at > 0 && self.world.tick_count == diverges_at + 1) self.bodies[1].charge += 1;
    };
  }

 private:
  int steps_ = 0;  // in no column
};
class HiddenCounterDiverging : public HiddenCounter {
 public:
  explicit HiddenCounterDiverging(std::uint32_t body_count) : HiddenCounter(body_count, 71) {}
};
/// No two objects are the same at tick 20.
class NeverTheSame : public ToySimulation {
 public:
  explicit NeverTheSame(std::uint32_t body_count) : ToySimulation(body_count) {
    static std::atomic<std::uint32_t> made{0};
    const std::uint32_t garbage = ++made;
    disturb = [garbage](ToySimulation& self, std::size_t stage) {
      if (stage == move_stage && self.world.tick_count == 21)
        self.bodies[0].hits = static_cast<std::uint16_t>(1000 + garbage);
    };
  }
};

const SimulationInfo hidden_info{"ticktrue.toy", 1, &make_toy<HiddenCounter>};

constexpr std::uint64_t recorded_ticks = 100;

Bytes hidden_counter_trace(bool is_full) {
  const TemporaryFolder folder;
  HiddenCounter simulation(6);
  ScriptedInputs source(lively_script);
  replay::RecordOptions options;
  options.tick_count = recorded_ticks;
  options.writer = plain_writer();
  replay::TraceSetup setup = is_full ? full_toy_setup(6, 0, recorded_ticks) : toy_setup(6);
  setup.checkpoint_interval = 30;
  REQUIRE(replay::record(simulation, source, folder.file("toy.ttr"), setup, toy_facts, options));
  return read_file(folder.file("toy.ttr"));
}

/// Every way in which a trace can be verified that begins with a checkpoint somewhere.
std::vector<VerifyOptions> ways_over_checkpoints(ByteView trace, const SimulationInfo& info) {
  std::vector<VerifyOptions> ways;
  for (const VerifyMode mode : {VerifyMode::replay, VerifyMode::restore})
    for (const unsigned thread_count : {1u, 2u, 4u}) {
      VerifyOptions options = verify_options(info, mode);
      options.thread_count = thread_count;
      options.in_segments = true;
      options.reopen = [trace]() -> std::unique_ptr<verifier::TraceSource> {
        return std::make_unique<verifier::OwnedReaderSource>(open_trace(trace));
      };
      ways.push_back(options);
    }
  VerifyOptions from = verify_options(info);
  from.from = 35;
  ways.push_back(from);
  VerifyOptions to_end = verify_options(info, VerifyMode::restore);
  to_end.to_end = true;
  ways.push_back(to_end);
  return ways;
}

TEST_CASE("state_incomplete: a hidden variable is found by every run from a checkpoint and by no run from the start",
          "[verifier][state_incomplete][analytic]") {
  for (const bool is_full : {false, true}) {
    const Bytes trace = hidden_counter_trace(is_full);
    CHECK(verify_bytes(trace, hidden_info).verdict == Verdict::match);
    for (const VerifyOptions& options : ways_over_checkpoints(trace, hidden_info)) {
      CAPTURE(is_full, int(options.mode), options.thread_count, options.from);
      const Report report = verify_bytes(trace, options);
      CHECK(report.verdict == Verdict::state_incomplete);
      CHECK(report.exit_code() == 1);
      CHECK(verifier::git_bisect_exit_code(report.exit_code()) == 1);
      CHECK(report.checkpoint == 30u);
      CHECK(report.ticks_compared == recorded_ticks - options.from);
      CHECK(contains(report.reason, "the run from the start matches, the run from the checkpoint of tick 30 does not"));
      CHECK(contains(report.hint, "in no column, or load does not restore it"));
      REQUIRE(report.divergence);
      CHECK(report.divergence->tick == 39);
      REQUIRE(!report.again.empty());
      CHECK(contains(report.again[0], "--mode restore --from 30 --to 39"));
      if (!is_full) {
        REQUIRE(report.again.size() == 2);
        CHECK(contains(report.again[1], "--detail full:39..39 --checkpoint-interval 30 -o full.ttr; then"));
        continue;
      }
      REQUIRE(report.divergence->tables.size() == 1);
      CHECK(report.divergence->tables[0].table == "bodies");
      CHECK(report.divergence->tables[0].columns == std::vector<std::string>{"hits"});
      REQUIRE(report.divergence->rows.size() == 1);
      CHECK(report.divergence->rows[0].name == "toy_0");
      CHECK(report.divergence->stage == "move");
    }
  }
}

TEST_CASE("state_incomplete: what really diverges is diverged in every mode, from every tick and on any threads",
          "[verifier][state_incomplete][equivalence]") {
  const Bytes trace = toy_trace_with(full_toy_setup(6, 0, recorded_ticks), recorded_ticks, 30);
  injected = {47, ToySimulation::move_stage, [](ToySimulation& toy) { toy.bodies[1].charge += 1; }};
  for (const VerifyOptions& options : ways_over_checkpoints(trace, faulty_info)) {
    CAPTURE(int(options.mode), options.thread_count, options.from);
    const Report report = verify_bytes(trace, options);
    CHECK(report.verdict == Verdict::diverged);
    CHECK(!report.checkpoint);
    CHECK(report.ticks_compared == 48 - options.from);
    REQUIRE(report.divergence);
    CHECK(report.divergence->tick == 47);
    REQUIRE(!report.divergence->rows.empty());
    CHECK(report.divergence->rows[0].column == "charge");
  }
}

TEST_CASE("state_incomplete: a hidden variable does not hide a divergence", "[verifier][state_incomplete][analytic]") {
  const SimulationInfo info{"ticktrue.toy", 1, &make_toy<HiddenCounterDiverging>};
  const Bytes trace = hidden_counter_trace(true);
  for (const VerifyOptions& options : ways_over_checkpoints(trace, info)) {
    CAPTURE(int(options.mode), options.thread_count, options.from);
    const Report report = verify_bytes(trace, options);
    CHECK(report.verdict == Verdict::diverged);
    REQUIRE(report.divergence);
    CHECK(report.divergence->tick == 71);
  }
}

TEST_CASE("state_incomplete: what no two runs agree on is not reproducible in every mode",
          "[verifier][state_incomplete][determinism]") {
  const SimulationInfo info{"ticktrue.toy", 1, &make_toy<NeverTheSame>};
  const Bytes trace = toy_trace_with(toy_setup(6), recorded_ticks, 15);
  for (VerifyOptions options : ways_over_checkpoints(trace, info)) {
    if (options.from > 0) options.from = 17;
    CAPTURE(int(options.mode), options.thread_count, options.from);
    const Report report = verify_bytes(trace, options);
    CHECK(report.verdict == Verdict::not_reproducible);
    REQUIRE(report.divergence);
    CHECK(report.divergence->tick == 20);
  }
}

TEST_CASE("state_incomplete: a divergence before --from is told, and the one behind it reported",
          "[verifier][state_incomplete][analytic]") {
  const Bytes trace = toy_trace_with(toy_setup(6), recorded_ticks, 30);
  const SimulationInfo info{"ticktrue.toy", 1, [](ByteView setup) {
                              auto toy = make_toy<ToySimulation>(setup);
                              static_cast<ToySimulation&>(**toy).disturb = [](ToySimulation& self, std::size_t stage) {
                                const std::uint64_t tick = self.world.tick_count;
                                if (stage == ToySimulation::move_stage && (tick == 8 || tick == 48))
                                  self.bodies[1].charge += 1;
                              };
                              return toy;
                            }};
  VerifyOptions options = verify_options(info);
  options.from = 40;
  const Report report = verify_bytes(trace, options);
  CHECK(report.verdict == Verdict::diverged);
  REQUIRE(report.divergence);
  CHECK(report.divergence->tick == 47);
  REQUIRE(report.notes.size() == 1);
  CHECK(contains(report.notes[0], "the run from the start leaves the recording at tick 7"));
}

TEST_CASE("state_incomplete: every form of a report knows it", "[verifier][state_incomplete][report]") {
  const Bytes trace = hidden_counter_trace(true);
  Report report = verify_bytes(trace, verify_options(hidden_info, VerifyMode::restore));
  report.file = "toy.ttr";
  const std::string text = verifier::report_text(report);
  CHECK(contains(text, "state_incomplete  toy.ttr  tick 39 of 100"));
  CHECK(contains(text, "bodies.hits"));
  CHECK(contains(text, "in no column"));
  const std::string json = verifier::report_json({&report, 1}, false);
  CHECK(contains(json, "\"verdict\": \"state_incomplete\""));
  CHECK(contains(json, "\"checkpoint\": 30"));
  CHECK(contains(json, "\"failed\": 1"));
  CHECK(contains(verifier::report_junit({&report, 1}, false), "<failure type=\"state_incomplete\""));
  CHECK(contains(verifier::report_github({&report, 1}, false), "title=ticktrue%3A state_incomplete"));
  CHECK(contains(verifier::report_markdown({&report, 1}, false), "| state_incomplete |"));
}

}  // namespace
}  // namespace ticktrue::test
