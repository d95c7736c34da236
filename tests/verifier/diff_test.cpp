// Two traces compared without running anything.
// SPDX-License-Identifier: MIT
#include "verifier/compare/diff.h"

#include <nlohmann/json.hpp>

#include "tests/support/catch.h"
#include "tests/verifier/toy_variants.h"

namespace ticktrue::test {
namespace {

using verifier::DiffReport;
using verifier::DiffVerdict;

DiffReport diff_bytes(ByteView a, ByteView b) {
  auto reader_a = replay::TraceReader::open_bytes(a, "a.ttr");
  auto reader_b = replay::TraceReader::open_bytes(b, "b.ttr");
  REQUIRE(reader_a);
  REQUIRE(reader_b);
  verifier::DiffOptions options;
  options.simulation = &toy_info;
  return verifier::diff(*reader_a, *reader_b, options);
}

/// A trace of a toy with an injected fault, and inputs changed from one tick on.
Bytes faulty_trace(replay::TraceSetup setup, std::uint64_t tick_count, std::uint32_t interval,
                   std::optional<std::uint64_t> other_input = std::nullopt) {
  const TemporaryFolder folder;
  auto simulation = *make_faulty(setup.setup);
  ScriptedInputs source([&](std::uint64_t tick) -> Result<std::optional<std::pair<double, Bytes>>> {
    if (other_input == tick) return std::optional(std::pair(0.015625, ToyInputs().push(1, 42).take()));
    return lively_script(tick);
  });
  replay::RecordOptions options;
  options.tick_count = tick_count;
  options.writer = plain_writer();
  setup.checkpoint_interval = interval;
  REQUIRE(replay::record(*simulation, source, folder.file("toy.ttr"), setup, toy_facts, options));
  return read_file(folder.file("toy.ttr"));
}

void nudge(ToySimulation& toy) {
  toy.bodies[2].charge += 1;
}

TEST_CASE("diff: a trace equals itself, whatever its detail and checkpoints", "[verifier][diff][equivalence]") {
  const Bytes root = toy_trace_with(toy_setup(6), 40, 8);
  const Bytes full = toy_trace_with(full_toy_setup(6, 3, 20), 40, 13);
  for (const auto& [a, b] : {std::pair(&root, &root), std::pair(&full, &full), std::pair(&root, &full)}) {
    const DiffReport report = diff_bytes(*a, *b);
    CHECK(report.verdict == DiffVerdict::equal);
    CHECK(report.exit_code() == 0);
    CHECK(report.ticks_compared == 40);
    CHECK(!report.divergence);
    CHECK(!report.inputs);
    CHECK(report.setup.empty());
  }
}

TEST_CASE("diff: the first differing tick is located as far as both traces store it", "[verifier][diff][analytic]") {
  injected = {17, ToySimulation::force_stage, nudge};
  const Bytes full_a = toy_trace_with(full_toy_setup(6, 0, 100), 40, 8);
  const Bytes full_b = faulty_trace(full_toy_setup(6, 0, 100), 40, 8);
  DiffReport report = diff_bytes(full_a, full_b);
  CHECK(report.verdict == DiffVerdict::different);
  CHECK(report.exit_code() == 1);
  REQUIRE(report.divergence);
  CHECK(report.divergence->tick == 17);
  CHECK(report.divergence->stage == "forces");
  REQUIRE(!report.divergence->rows.empty());
  CHECK(report.divergence->rows.back().column == "charge");
  CHECK(report.divergence->rows.back().row == 2);
  CHECK(!report.inputs);
  CHECK(report.ticks_compared == 40);

  // Only hashes: the tick alone.
  const Bytes root_a = toy_trace_with(toy_setup(6), 40, 8);
  report = diff_bytes(root_a, faulty_trace(toy_setup(6), 40, 8));
  REQUIRE(report.divergence);
  CHECK(report.divergence->tick == 17);
  CHECK(report.divergence->tables.empty());
  REQUIRE(report.again.size() == 1);
  CHECK(contains(report.again[0], "full:17..17"));
  CHECK(!contains(report.again[0], "both builds"));

  // A checkpoint right behind the tick.
  report = diff_bytes(toy_trace_with(toy_setup(6), 40, 9), faulty_trace(toy_setup(6), 40, 6));
  REQUIRE(report.divergence);
  REQUIRE(report.divergence->rows.size() == 1);
  CHECK(report.divergence->rows[0].column == "charge");
}

TEST_CASE("diff: inputs that differ are named with their tick and text", "[verifier][diff][analytic]") {
  injected = {0, ToySimulation::move_stage, [](ToySimulation&) {}};
  const Bytes a = toy_trace_with(toy_setup(6), 40, 8);
  const DiffReport report = diff_bytes(a, faulty_trace(toy_setup(6), 40, 8, 22));
  CHECK(report.verdict == DiffVerdict::different);
  REQUIRE(report.inputs);
  CHECK(report.inputs->tick == 22);
  CHECK(contains(report.inputs->inputs_b, "{\"tick\":22,\"type\":\"push\",\"body\":1,\"value\":42"));
  CHECK(report.inputs->inputs_a != report.inputs->inputs_b);
  REQUIRE(report.divergence);
  CHECK(report.divergence->tick == 22);
}

TEST_CASE("diff: setups that differ are told, those of other simulations are not compared",
          "[verifier][diff][analytic]") {
  const Bytes a = toy_trace_with(toy_setup(6), 20, 8);
  DiffReport report = diff_bytes(a, toy_trace_with(toy_setup(7), 20, 8));
  CHECK(report.verdict == DiffVerdict::different);
  REQUIRE(report.setup.size() == 2);
  CHECK(report.setup[0].what == "title");
  CHECK(report.setup[1].what == "setup");
  REQUIRE(report.divergence);
  CHECK(report.divergence->stage == "setup");

  replay::TraceSetup other = toy_setup(6);
  other.physics_version = 2;
  report = diff_bytes(a, toy_trace_with(other, 20, 8));
  CHECK(report.verdict == DiffVerdict::not_comparable);
  CHECK(report.exit_code() == 5);
  CHECK(contains(report.reason, "physics version"));
  CHECK(!report.divergence);
  CHECK(report.ticks_compared == 0);

  // Only the first column that differs is named.
  const auto reaching = [](double id_max) {
    replay::TraceSetup setup = toy_setup(6);
    setup.schema.tables[1].columns[1].max = id_max;  // partner, a reference
    setup.schema.tables[2].columns[1].max = id_max;  // body_b, another one
    return setup;
  };
  report = diff_bytes(toy_trace_with(reaching(60000), 20, 8), toy_trace_with(reaching(61000), 20, 8));
  CHECK(report.verdict == DiffVerdict::not_comparable);
  CHECK(contains(report.reason, "schema: bodies.partner: "));
  CHECK(contains(report.reason, "..60000 and "));
  CHECK(contains(report.reason, "..61000"));
  CHECK(report.ticks_compared == 0);
}

TEST_CASE("diff: another length, a cut and damage are told apart", "[verifier][diff][corruption]") {
  const Bytes a = toy_trace_with(toy_setup(6), 40, 8);
  DiffReport report = diff_bytes(a, toy_trace_with(toy_setup(6), 30, 8));
  CHECK(report.verdict == DiffVerdict::different);
  CHECK(contains(report.reason, "lengths: 40 and 30"));
  CHECK(report.ticks_compared == 30);

  report = diff_bytes(a, ByteView(a).first(a.size() * 3 / 4));
  CHECK(report.verdict == DiffVerdict::incomplete);
  CHECK(report.exit_code() == 3);
  CHECK(report.exit_code(true) == 0);

  Bytes damaged = a;
  damaged[a.size() * 3 / 4] ^= 1;
  report = diff_bytes(a, damaged);
  CHECK(report.verdict == DiffVerdict::damaged);
  CHECK(report.exit_code() == 4);

  injected = {1, ToySimulation::move_stage, nudge};
  damaged = faulty_trace(toy_setup(6), 40, 8);
  damaged.resize(damaged.size() - 5);
  report = diff_bytes(a, damaged);
  CHECK(report.verdict == DiffVerdict::different);
  CHECK(report.exit_code() == 1);
}

TEST_CASE("diff: a shorter trace whose recorder was stopped is incomplete, not different",
          "[verifier][diff][equivalence]") {
  const Bytes a = toy_trace_with(toy_setup(6), 40, 8);
  const TemporaryFolder folder;
  const Bytes cut(a.begin(), a.begin() + static_cast<std::ptrdiff_t>(a.size() * 3 / 4));
  write_file(folder.file("cut.ttr"), cut);
  REQUIRE(replay::recover_trace(folder.file("cut.ttr"), folder.file("saved.ttr"), false));
  const DiffReport report = diff_bytes(read_file(folder.file("saved.ttr")), a);
  CHECK(report.verdict == DiffVerdict::incomplete);
  CHECK(report.exit_code() == 3);
  CHECK(report.exit_code(true) == 0);
  CHECK(contains(report.reason, "a.ttr ended early"));
}

TEST_CASE("diff: where only the setups differ, the states are said to be equal", "[verifier][diff][equivalence]") {
  replay::TraceSetup other = toy_setup(6);
  other.title = "another";
  const DiffReport report = diff_bytes(toy_trace_with(toy_setup(6), 20, 8), toy_trace_with(other, 20, 8));
  CHECK(report.verdict == DiffVerdict::different);
  CHECK(report.reason == "states equal; the setups differ");
}

TEST_CASE("diff: text and JSON say the same", "[verifier][diff][analytic]") {
  injected = {17, ToySimulation::move_stage, nudge};
  const DiffReport report =
      diff_bytes(toy_trace_with(full_toy_setup(6, 0, 100), 40, 8), faulty_trace(full_toy_setup(6, 0, 100), 40, 8, 30));
  const std::string text = verifier::diff_text(report);
  CHECK(contains(text, "different  a.ttr  b.ttr  tick 17 of 40"));
  CHECK(contains(text, "column  bodies.charge     row 2"));
  CHECK(contains(text, "value   a "));
  CHECK(contains(text, "differ first at tick 30"));
  const auto json = nlohmann::json::parse(verifier::diff_json(report));
  CHECK(json["schema"] == "ticktrue.diff/2");
  CHECK(json["verdict"] == "different");
  CHECK(json["divergence"]["tick"] == 17);
  CHECK(json["divergence"]["columns"] == std::vector<std::string>{"charge"});
  CHECK(json["inputs"]["tick"] == 30);
  CHECK(json["a"]["ticks"] == 40);
  CHECK(json["a"]["end"]["condition"] == "complete");
}

}  // namespace
}  // namespace ticktrue::test
