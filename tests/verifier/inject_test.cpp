// Every injected bit comes back with its exact place.
// SPDX-License-Identifier: MIT
#include "verifier/inject/inject.h"

#include <nlohmann/json.hpp>
#include <set>

#include "tests/support/catch.h"
#include "tests/verifier/toy_variants.h"

namespace ticktrue::test {
namespace {

using verifier::InjectOptions;
using verifier::InjectReport;
using verifier::InjectRow;

InjectOptions inject_options(std::uint64_t count, const SimulationInfo& info = toy_info) {
  InjectOptions options;
  options.simulation = &info;
  options.count = count;
  return options;
}
InjectReport inject_bytes(ByteView trace, const InjectOptions& options) {
  replay::TraceReader reader = open_trace(trace);
  Result<InjectReport> report = verifier::inject(reader, options);
  if (!report) FAIL(report.error().message);
  return std::move(*report);
}

TEST_CASE("inject: 500 of 500 flips are found exactly in a trace stored in full", "[verifier][inject][analytic]") {
  const Bytes trace = toy_trace_with(full_toy_setup(20, 0, 1000), 120, 50);
  const InjectReport report = inject_bytes(trace, inject_options(500));
  CHECK(report.passed == 500);
  CHECK(report.failed == 0);
  CHECK(report.not_applicable == 0);
  CHECK(report.exit_code() == 0);
  std::set<std::uint64_t> ticks;
  std::set<std::string> columns;
  for (const InjectRow& row : report.rows) {
    CHECK(row.place_required);
    ticks.insert(row.tick);
    columns.insert(row.place.table + "." + row.place.column);
  }
  CHECK(ticks.size() > 80);
  CHECK(columns.size() == 15);  // all of the toy's
}

TEST_CASE("inject: each column and lane can be asked for and is found", "[verifier][inject][analytic]") {
  const Bytes trace = toy_trace_with(full_toy_setup(6, 0, 1000), 12, 0);
  for (const TableSchema& table : ToySimulation::schema().tables)
    for (const Column& column : table.columns)
      for (std::uint32_t lane = 0; lane < column.lane_count; ++lane)
        for (const std::uint32_t bit : {0u, 8u * scalar_info(column.type)->size - 1u}) {
          CAPTURE(table.name, column.name, lane, bit);
          InjectOptions options = inject_options(1);
          options.tick = 4;
          options.table = table.name;
          options.column = column.name;
          options.row = 0;
          options.lane = lane;
          options.bit = bit;
          const InjectReport report = inject_bytes(trace, options);
          REQUIRE(report.passed == 1);
          const InjectRow& row = report.rows[0];
          CHECK(row.place.table == table.name);
          CHECK(row.place.column == column.name);
          CHECK(row.place.lane == lane);
          CHECK(row.bit == bit);
          REQUIRE(row.divergence);
          CHECK(row.divergence->tick == 4);
          CHECK(!row.divergence->stage);
        }
}

TEST_CASE("inject: flips that make a NaN or an infinity are found like others", "[verifier][inject][analytic]") {
  const Bytes trace = toy_trace_with(full_toy_setup(6, 0, 1000), 12, 0);
  InjectOptions options = inject_options(1);
  options.tick = 0;
  options.table = "links";
  options.column = "stiffness";
  options.row = 0;
  // 0.5 has exponent 01111110: its top bit makes it huge, all others are set but the last.
  for (std::uint32_t bit = 0; bit < 32; ++bit) {
    options.bit = bit;
    CHECK(inject_bytes(trace, options).passed == 1);
  }
  options.column = "body_a";
  for (std::uint32_t bit = 0; bit < 32; ++bit) {
    options.bit = bit;
    CHECK(inject_bytes(trace, options).passed == 1);
  }
}

TEST_CASE("inject: the same seed draws the same places", "[verifier][inject][determinism]") {
  const Bytes trace = toy_trace_with(full_toy_setup(6, 0, 1000), 30, 0);
  InjectOptions options = inject_options(50);
  const std::string first = verifier::inject_json(inject_bytes(trace, options));
  CHECK(verifier::inject_json(inject_bytes(trace, options)) == first);
  options.seed = 2;
  CHECK(verifier::inject_json(inject_bytes(trace, options)) != first);
}

TEST_CASE("inject: only the tick is required where only hashes are stored, and it is said",
          "[verifier][inject][analytic]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 60, 7);
  const InjectReport report = inject_bytes(trace, inject_options(60));
  CHECK(report.passed == 60);
  bool tick_only = false, place = false;
  for (const InjectRow& row : report.rows) {
    (row.place_required ? place : tick_only) = true;
    // A checkpoint right behind the tick gives the place.
    CHECK(row.place_required == ((row.tick + 1) % 7 == 0));
  }
  CHECK(tick_only);
  CHECK(place);
  CHECK(contains(verifier::inject_text(report), "at the exact tick\n"));
  CHECK(contains(verifier::inject_text(report), "--detail full"));
}

class CannotLoad : public ToySimulation {
 public:
  using ToySimulation::ToySimulation;
  Status load(ByteView) override { return Error{ErrorCode::unsupported, "toy: observed only", ""}; }
};

TEST_CASE("inject: works without load and for a range stored in full in the middle", "[verifier][inject][analytic]") {
  const Bytes trace = toy_trace_with(full_toy_setup(6, 10, 19), 40, 0);
  const SimulationInfo cannot_load{"ticktrue.toy", 1, &make_toy<CannotLoad>};
  for (const SimulationInfo* info : {&toy_info, &cannot_load}) {
    const InjectReport report = inject_bytes(trace, inject_options(60, *info));
    CHECK(report.passed == 60);
    for (const InjectRow& row : report.rows) {
      CHECK(row.place_required);
      CHECK(row.tick >= 10);
      CHECK(row.tick <= 19);
    }
  }
}

TEST_CASE("inject: a place that is not there is not applicable or refused, never passed",
          "[verifier][inject][analytic]") {
  const Bytes trace = toy_trace_with(full_toy_setup(1, 0, 1000), 2, 0);
  InjectOptions options = inject_options(3);
  options.table = "links";  // one body has no link
  const InjectReport report = inject_bytes(trace, options);
  CHECK(report.not_applicable == 3);
  CHECK(report.passed == 0);
  CHECK(report.exit_code() == 1);

  const auto error = [&](const InjectOptions& asked) {
    replay::TraceReader reader = open_trace(trace);
    const auto result = verifier::inject(reader, asked);
    REQUIRE(!result);
    CHECK(result.error().code == ErrorCode::usage);
    return result.error().message;
  };
  options.table = "planets";
  CHECK(contains(error(options), "found planets, expected one of world, bodies, links"));
  options.table = "bodies";
  options.column = "stiffness";
  CHECK(contains(error(options), "found stiffness, expected one of id, partner"));
  options.column = "";
  options.row = 400;
  CHECK(contains(error(options), "--row: no such row in table bodies: found 400, expected 0..0"));
  options.row.reset();
  options.tick = 2;
  CHECK(contains(error(options), "--tick: beyond the trace: found 2, expected 0..1"));
}

TEST_CASE("inject: nothing is injected into a trace that does not match by itself", "[verifier][inject][analytic]") {
  injected = {3, ToySimulation::move_stage, [](ToySimulation& toy) { toy.bodies[0].charge += 1; }};
  const Bytes trace = toy_trace_with(full_toy_setup(6, 0, 1000), 12, 0);
  const InjectReport report = inject_bytes(trace, inject_options(10, faulty_info));
  CHECK(report.rows.empty());
  CHECK(report.exit_code() == 1);
  CHECK(contains(verifier::inject_text(report), "nothing was injected"));
}

TEST_CASE("inject: JSON has the counts and a row for each flip", "[verifier][inject][analytic]") {
  const Bytes trace = toy_trace_with(full_toy_setup(6, 0, 1000), 12, 0);
  const auto json = nlohmann::json::parse(verifier::inject_json(inject_bytes(trace, inject_options(20))));
  CHECK(json["schema"] == "ticktrue.inject/1");
  CHECK(json["passed"] == 20);
  CHECK(json["failed"] == 0);
  CHECK(json["expected"] == 0);
  CHECK(json["not_applicable"] == 0);
  CHECK(json["detail"] == "full");
  REQUIRE(json["rows"].size() == 20);
  for (const auto& row : json["rows"]) {
    CHECK(row["outcome"] == "found");
    for (const char* field : {"tick", "table", "column", "row", "lane"}) CHECK(row[field] == row["found"][field]);
  }
}

}  // namespace
}  // namespace ticktrue::test
