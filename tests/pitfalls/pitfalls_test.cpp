// Verify finds each pitfall at its tick, column and units. docs/pitfalls.md shows the report.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <optional>
#include <set>
#include <sstream>

#include "tests/pitfalls/pitfall.h"
#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "verifier/report/likely_causes.h"

namespace ticktrue::test {
namespace {

using pitfalls::Machine;
using pitfalls::Pitfall;
using verifier::Report;
using verifier::Verdict;
using verifier::VerifyMode;

const Pitfall* const all[] = {
    &pitfalls::argument_order,
    &pitfalls::contraction,
    &pitfalls::float_to_int,
    &pitfalls::flush_to_zero,
    &pitfalls::libm,
    &pitfalls::negative_zero,
    &pitfalls::padding,
    &pitfalls::pointer_order,
    &pitfalls::rand_call,
    &pitfalls::thread_order,
    &pitfalls::unordered_iteration,
    &pitfalls::unsaved_state,
    &pitfalls::unstable_sort,
    &pitfalls::wall_clock,
};
constexpr std::uint64_t tick_count = 60;

Bytes recorded(const Pitfall& pitfall, bool is_full) {
  pitfalls::machine = Machine::recorder;
  const auto simulation = pitfall.make({});
  REQUIRE(simulation);
  replay::TraceSetup setup;
  setup.simulation = pitfall.name;
  setup.physics_version = 1;
  setup.title = pitfall.name;
  setup.dt = 0.015625;
  setup.schema = *(*simulation)->state().schema;
  if (is_full) {
    setup.detail = replay::Detail::full;
    setup.full_last = tick_count - 1;
  }
  setup.checkpoint_interval = 16;
  replay::NoInputs source(setup.dt);
  replay::RecordOptions options;
  options.tick_count = tick_count;
  options.writer = plain_writer();
  const TemporaryFolder folder;
  const auto result = replay::record(**simulation, source, folder.file("game.ttr"), setup, {}, options);
  REQUIRE(result);
  return read_file(folder.file("game.ttr"));
}

Report verified(const Pitfall& pitfall, const Bytes& trace, Machine machine, VerifyMode mode) {
  pitfalls::machine = machine;
  const SimulationInfo info{pitfall.name, 1, pitfall.make};
  auto reader = replay::TraceReader::open_bytes(trace, std::string(pitfall.name) + ".ttr");
  REQUIRE(reader);
  verifier::VerifyOptions options;
  options.simulation = &info;
  options.mode = mode;
  Report report = verifier::verify(*reader, options);
  report.file = std::string(pitfall.name) + ".ttr";
  return report;
}

/// Whether two runs on one machine are equal.
bool is_repeatable(const Pitfall& pitfall) {
  return pitfall.verdict != Verdict::not_reproducible;
}

TEST_CASE("every pitfall is found at its tick, column and units", "[verifier][pitfalls][analytic]") {
  for (const Pitfall* pitfall : all) {
    CAPTURE(pitfall->name);
    const Report report = verified(*pitfall, recorded(*pitfall, true), Machine::other, pitfall->mode);
    CHECK(report.verdict == pitfall->verdict);
    REQUIRE(report.divergence);
    INFO(verifier::report_text(report));
    CHECK(report.divergence->tick == pitfall->tick);
    REQUIRE(report.divergence->tables.size() == 1);
    CHECK(report.divergence->tables[0].table == "units");
    CHECK(report.divergence->tables[0].columns == std::vector<std::string>{pitfall->column});
    std::vector<std::uint32_t> units;
    for (const verifier::LaneReport& lane : report.divergence->rows) {
      REQUIRE(lane.id);
      units.push_back(static_cast<std::uint32_t>(*lane.id));
      CHECK(lane.name == "unit_" + std::to_string(*lane.id));
    }
    CHECK(units == pitfall->units);
  }
}

TEST_CASE("a comparison of two machines tick by tick finds the same tick and column",
          "[verifier][pitfalls][equivalence]") {
  for (const Pitfall* pitfall : all) {
    if (pitfall->verdict != Verdict::diverged || pitfall->mode != VerifyMode::replay) continue;
    CAPTURE(pitfall->name);
    const auto here = pitfall->make({});
    const auto there = pitfall->make({});
    for (std::uint64_t tick = 0; tick <= pitfall->tick; ++tick) {
      Bytes image_here, image_there;
      pitfalls::machine = Machine::recorder;
      REQUIRE((*here)->step({0.015625, {}}, nullptr));
      encode_image((*here)->state(), image_here);
      pitfalls::machine = Machine::other;
      REQUIRE((*there)->step({0.015625, {}}, nullptr));
      encode_image((*there)->state(), image_there);
      CAPTURE(tick);
      CHECK((image_here == image_there) == (tick < pitfall->tick));
      if (tick < pitfall->tick) continue;
      const StateSchema& schema = *(*here)->state().schema;
      const auto differences =
          diff_images(schema, *split_image(schema, image_here), *split_image(schema, image_there), 9);
      CHECK(differences.size() == pitfall->units.size());
      for (const LaneDifference& difference : differences)
        CHECK(schema.tables[1].columns[difference.place.column].name == pitfall->column);
    }
  }
}

TEST_CASE("the tick of every pitfall is exact with a hash per tick alone", "[verifier][pitfalls][analytic]") {
  for (const Pitfall* pitfall : all) {
    CAPTURE(pitfall->name);
    const Report report = verified(*pitfall, recorded(*pitfall, false), Machine::other, pitfall->mode);
    CHECK(report.verdict == pitfall->verdict);
    REQUIRE(report.divergence);
    CHECK(report.divergence->tick == pitfall->tick);
  }
}

TEST_CASE("on the machine that recorded it a pitfall shows only where two runs differ", "[verifier][pitfalls]") {
  for (const Pitfall* pitfall : all) {
    CAPTURE(pitfall->name);
    const Report report = verified(*pitfall, recorded(*pitfall, false), Machine::recorder, VerifyMode::replay);
    CHECK(report.verdict == (is_repeatable(*pitfall) ? Verdict::match : pitfall->verdict));
  }
}

/// The lines of a report that are equal in every run: the place, and the values unless they are random.
std::vector<std::string> lasting_lines(const Pitfall& pitfall, const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    const bool is_value = line.find("  value ") == 0;
    const bool is_cause = line.find("  why ") == 0 || line.find("          or ") == 0;
    const bool is_place = lines.empty() || line.find("  column ") == 0;
    if (is_place || ((is_value || is_cause) && is_repeatable(pitfall))) lines.push_back(line);
  }
  return lines;
}

TEST_CASE("docs/pitfalls.md shows what is said of every pitfall", "[verifier][pitfalls][docs]") {
  std::ifstream in(std::string(TICKTRUE_SOURCE_DIR) + "/docs/pitfalls.md");
  std::ostringstream text;
  text << in.rdbuf();
  for (const Pitfall* pitfall : all) {
    const std::string report =
        verifier::report_text(verified(*pitfall, recorded(*pitfall, true), Machine::other, pitfall->mode));
    if (std::getenv("TICKTRUE_UPDATE_DOCS") != nullptr) std::cout << report << "\n";
    CAPTURE(pitfall->name, report);
    CHECK(text.str().find("tests/pitfalls/" + std::string(pitfall->name) + ".cpp") != std::string::npos);
    const std::vector<std::string> lines = lasting_lines(*pitfall, report);
    CHECK(lines.size() >= 2);
    for (const std::string& line : lines) CHECK(text.str().find(line + "\n") != std::string::npos);
  }
}

TEST_CASE("report names the cause of twelve pitfalls among at most two", "[verifier][pitfalls][causes]") {
  using verifier::Cause;
  const std::map<std::string, std::optional<Cause>> expected{
      {"argument_order", std::nullopt},  // leaves values like those of any other rule
      {"contraction", Cause::other_math},      {"float_to_int", Cause::conversion_out_of_range},
      {"flush_to_zero", Cause::flush_to_zero}, {"libm", Cause::other_math},
      {"negative_zero", Cause::negative_zero}, {"padding", std::nullopt},
      {"pointer_order", Cause::tie},           {"rand_call", Cause::random_numbers},
      {"thread_order", Cause::thread_order},   {"unordered_iteration", Cause::sum_order},
      {"unsaved_state", Cause::unsaved_state}, {"unstable_sort", Cause::row_order},
      {"wall_clock", Cause::random_numbers}};
  for (const Pitfall* pitfall : all) {
    const Report report = verified(*pitfall, recorded(*pitfall, true), Machine::other, pitfall->mode);
    CAPTURE(pitfall->name, verifier::report_text(report));
    const std::vector<Cause> found = verifier::likely_causes(report);
    CHECK(found.size() <= 2);
    std::optional<Cause> cause = expected.at(pitfall->name);
    // The time since boot may also be a plausible calendar time.
    if (cause == Cause::random_numbers && found == std::vector<Cause>{Cause::clock}) cause = Cause::clock;
    if (cause) CHECK(std::find(found.begin(), found.end(), *cause) != found.end());
    if (!cause) CHECK(found.empty());
  }
}

}  // namespace
}  // namespace ticktrue::test
