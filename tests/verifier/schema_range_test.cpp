// The range of a column may grow from build to build: old traces stay comparable.
// SPDX-License-Identifier: MIT
#include "engine/builtin_scenes/builtin_scenes.h"
#include "tests/support/catch.h"
#include "tests/verifier/toy_variants.h"
#include "tool/session/playback.h"
#include "tool/session/session.h"
#include "verifier/compare/diff.h"
#include "verifier/locate/schema_difference.h"

namespace ticktrue::test {
namespace {

using verifier::Ranges;
using verifier::Report;
using verifier::Verdict;
using verifier::VerifyMode;

/// The toy's setup as a build would write it that knows `kind_max` and no more.
replay::TraceSetup setup_with_kinds(double kind_max) {
  replay::TraceSetup setup = toy_setup(6);
  for (Column& column : setup.schema.tables[1].columns)
    if (column.name == "kind") column.max = kind_max;
  return setup;
}

TEST_CASE("schema range: a trace of a build that knew fewer kinds verifies, in every mode",
          "[verifier][schema_range][equivalence]") {
  const Bytes trace = toy_trace_with(setup_with_kinds(2), 40, 8);  // the toy here: 0..3
  for (const VerifyMode mode : {VerifyMode::replay, VerifyMode::restore, VerifyMode::twice}) {
    CAPTURE(int(mode));
    const Report report = verify_bytes(trace, toy_info, mode);
    CHECK(report.verdict == Verdict::match);
    CHECK(report.ticks_compared == 40);
    CHECK(report.warnings.empty());
  }
  verifier::VerifyOptions from = verify_options(toy_info);
  from.from = 20;
  CHECK(verify_bytes(trace, from).verdict == Verdict::match);
}

TEST_CASE("schema range: a trace of a build that knew more kinds is not comparable, and says why",
          "[verifier][schema_range][analytic]") {
  const Report report = verify_bytes(toy_trace_with(setup_with_kinds(4), 40, 8), toy_info);
  CHECK(report.verdict == Verdict::not_comparable);
  CHECK(report.exit_code() == 5);
  CHECK(report.reason ==
        "schema: bodies.kind: recorded -inf..4, here -inf..3: values may be recorded that this build does not know");
}

TEST_CASE("schema range: a divergence is located and followed in a trace of fewer kinds",
          "[verifier][schema_range][analytic]") {
  replay::TraceSetup setup = setup_with_kinds(2);
  setup.detail = replay::Detail::full;
  setup.full_last = 100;
  const Bytes trace = toy_trace_with(setup, 40, 8);
  // A kind that the recorded range does not have.
  injected = {17, ToySimulation::move_stage, [](ToySimulation& toy) { toy.bodies[1].kind = 3; }};
  const Report report = verify_bytes(trace, faulty_info);
  CHECK(report.verdict == Verdict::diverged);
  REQUIRE(report.divergence);
  CHECK(report.divergence->tick == 17);
  REQUIRE(report.divergence->rows.size() == 1);
  CHECK(report.divergence->rows[0].column == "kind");
  CHECK(!report.divergence->spread.empty());
}

TEST_CASE("schema range: ranges of references and everything else of a column stay exact",
          "[verifier][schema_range][analytic]") {
  const StateSchema here = ToySimulation::schema();
  const auto changed = [&](const auto& change) {
    StateSchema schema = here;
    change(schema.tables[1]);
    return schema;
  };
  const auto column = [](TableSchema& table, const char* name) -> Column& {
    for (Column& one : table.columns)
      if (one.name == name) return one;
    FAIL("no such column");
    return table.columns[0];
  };
  CHECK(!first_schema_difference(here, here, Ranges::same));
  const StateSchema narrower = changed([&](TableSchema& table) { column(table, "kind").max = 1; });
  CHECK(first_schema_difference(narrower, here, Ranges::same));
  CHECK(!first_schema_difference(narrower, here, Ranges::inside));
  CHECK(first_schema_difference(here, narrower, Ranges::inside));
  CHECK(!first_schema_difference(here, narrower, Ranges::any));
  for (const StateSchema& other : {changed([&](TableSchema& table) { column(table, "id").name = "number"; }),
                                   changed([&](TableSchema& table) { column(table, "partner").max = 5; }),
                                   changed([&](TableSchema& table) { column(table, "partner").target = 0; }),
                                   changed([&](TableSchema& table) { column(table, "partner").optional = false; }),
                                   changed([&](TableSchema& table) { column(table, "kind").type = ScalarType::u16; }),
                                   changed([&](TableSchema& table) { column(table, "kind").name = "sort"; }),
                                   changed([&](TableSchema& table) { table.key_column_count = 0; })}) {
    CHECK(first_schema_difference(other, here, Ranges::any));
    CHECK(first_schema_difference(here, other, Ranges::any));
  }
}

TEST_CASE("schema range: a joint kind that the recording build did not know keeps its traces comparable",
          "[verifier][schema_range][equivalence]") {
  const auto scene = engine::make_builtin_scene("chain");
  REQUIRE(scene);
  const auto made = engine::make_engine(*scene);
  REQUIRE(made);
  replay::TraceSetup setup = tool::make_trace_setup(**made, {replay::Detail::cells, 0, 0, 20});
  const auto joints = setup.schema.find_table("joints");
  REQUIRE(joints);
  bool is_narrowed = false;
  for (Column& column : setup.schema.tables[*joints].columns)
    if (column.name == "kind") {
      column.max -= 1;
      is_narrowed = true;
    }
  REQUIRE(is_narrowed);
  const TemporaryFolder folder;
  replay::NoInputs inputs(scene->settings.dt);
  replay::RecordOptions options;
  options.tick_count = 60;
  options.writer = plain_writer();
  REQUIRE(replay::record(**made, inputs, folder.file("chain.ttr"), setup, {}, options));
  auto reader = replay::TraceReader::open(folder.file("chain.ttr"));
  REQUIRE(reader);
  for (const VerifyMode mode : {VerifyMode::replay, VerifyMode::restore}) {
    const Report report = verifier::verify(*reader, verify_options(engine::engine_info(), mode));
    CHECK(report.verdict == Verdict::match);
    CHECK(report.ticks_compared == 60);
  }
  // Seeking takes the checkpoint, not the way from the start.
  std::uint64_t first_shown = 0;
  const auto played = tool::play_trace(*reader, 45, 50, [&](const engine::Engine&, std::uint64_t tick) {
    if (first_shown == 0) first_shown = tick;
    return true;
  });
  REQUIRE(played);
  CHECK(first_shown == 45);
}

TEST_CASE("schema range: two recordings of builds with other ranges are compared",
          "[verifier][schema_range][analytic]") {
  const Bytes trace_a = toy_trace_with(setup_with_kinds(2), 20, 8);
  const Bytes trace_b = toy_trace_with(setup_with_kinds(4), 20, 8);
  auto a = open_trace(trace_a);
  auto b = open_trace(trace_b);
  const verifier::DiffReport report = verifier::diff(a, b, {});
  CHECK(report.verdict == verifier::DiffVerdict::equal);
  CHECK(report.ticks_compared == 20);
}

}  // namespace
}  // namespace ticktrue::test
