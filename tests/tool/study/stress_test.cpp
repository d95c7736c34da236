// The stress cases: excused and unexcused failures, the precision in a row, loads, rotating bodies with rods,
// mechanisms.
// SPDX-License-Identifier: MIT
#include "tool/study/stress/stress.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/catch.h"
#include "tests/support/source_tree.h"
#include "tests/support/text.h"
#include "tool/study/stress/stress_run_time.h"

using namespace ticktrue;
using namespace ticktrue::tool;
using engine::Precision;
using test::contains;

namespace {

const std::string source_root = TICKTRUE_SOURCE_DIR;

bool begins_with(const std::string& name, std::string_view start) {
  return name.compare(0, start.size(), start) == 0;
}

// Rows of a case with these values of its methods, judged and excused.
std::vector<tool::StressRow> judged(const tool::StressCase& c, const std::vector<double>& values,
                                    Precision precision = Precision::f32) {
  REQUIRE(values.size() == c.methods.size());
  std::vector<tool::StressRow> rows(values.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].method = c.methods[i].name;
    rows[i].precision = precision;
    rows[i].value = values[i];
    rows[i].verdict = judge(c, {values[i], true, ""});
  }
  excuse(rows, c);
  return rows;
}

tool::StressCase bounded_by_one(std::vector<tool::StressMethod> methods) {
  tool::StressCase c;
  c.upper = 1;
  c.methods = std::move(methods);
  return c;
}

std::vector<tool::StressRow> rows_of(std::vector<std::string> names, std::vector<Precision> precisions) {
  tool::StressOptions options;
  options.names = std::move(names);
  options.precisions = std::move(precisions);
  const auto rows = run_stress(options);
  REQUIRE(rows.has_value());
  return *rows;
}

const tool::StressRow& row_of(const std::vector<tool::StressRow>& rows, std::string_view name, std::string_view method,
                              Precision precision = Precision::f32) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const tool::StressRow& row) {
    return row.name == name && row.method == method && row.precision == precision;
  });
  CAPTURE(name, method);
  REQUIRE(found != rows.end());
  return *found;
}

}  // namespace

TEST_CASE("a method that a document names as the cure is never excused", "[verifier][study][stress]") {
  tool::StressCase c = bounded_by_one(tool::contact_methods());
  CHECK(judged(c, {0.5, 2, 0.5, 0.5})[1].verdict == tool::StudyVerdict::falls_short);
  c.cures = {{"tgs_soft auto", "README.md"}};
  c.shortfalls = {{"tgs_soft auto", "known", 0, 10}};
  const std::vector<tool::StressRow> rows = judged(c, {0.5, 2, 0.5, 0.5});
  CHECK(rows[1].verdict == tool::StudyVerdict::fail);
  CHECK(contains(rows[1].reason, "README.md"));
  CHECK(judged(c, {2, 0.5, 2, 2})[0].verdict == tool::StudyVerdict::falls_short);
}

TEST_CASE("what falls short is told as far as it is known, and no farther", "[verifier][study][stress]") {
  tool::StressCase c = bounded_by_one(tool::contact_methods());
  c.shortfalls = {{"tgs_soft", "known", 0, 3, Precision::f32}};
  CHECK(judged(c, {2, 2, 2, 2})[0].verdict == tool::StudyVerdict::falls_short);
  CHECK(judged(c, {2, 2, 2, 2})[0].reason == "known");
  CHECK(judged(c, {2, 2, 2, 2})[1].verdict == tool::StudyVerdict::fail);
  CHECK(judged(c, {4, 2, 2, 2})[0].verdict == tool::StudyVerdict::fail);
  CHECK(judged(c, {2, 2, 2, 2}, Precision::f64)[0].verdict == tool::StudyVerdict::fail);
  CHECK(judged(c, {std::nan(""), 2, 2, 2})[0].verdict == tool::StudyVerdict::fail);
}

TEST_CASE("an integrator that passes excuses no other one", "[verifier][study][stress]") {
  const tool::StressCase c = bounded_by_one(tool::integrator_methods());
  std::vector<double> values(c.methods.size(), 0.5);
  values[2] = 2;
  REQUIRE_FALSE(c.methods[2].is_baseline);
  CHECK(judged(c, values)[2].verdict == tool::StudyVerdict::fail);
}

TEST_CASE("a row tells the precision that its case ran with", "[verifier][study][stress]") {
  // Spring cases only run once, in f64.
  for (const std::vector<Precision>& asked :
       {std::vector<Precision>{Precision::f32}, {Precision::f32, Precision::f64}}) {
    const std::vector<tool::StressRow> rows = rows_of({"spring_sag_1e", "spring_damping_1e"}, asked);
    std::set<std::string> seen;
    for (const tool::StressRow& row : rows) {
      CAPTURE(row.name, row.method);
      CHECK(row.precision == Precision::f64);
      CHECK(seen.insert(row.name + row.method).second);
    }
  }
  // Other cases run in each requested precision, and depend on it: f32 has 24 bits.
  const std::vector<tool::StressRow> rows = rows_of({"far_1000"}, {Precision::f32, Precision::f64});
  CHECK(row_of(rows, "far_1000", "tgs_soft", Precision::f64).value < 1e-9);
  CHECK(row_of(rows, "far_1000", "tgs_soft", Precision::f32).value > 1e-9);
}

TEST_CASE("the cases that README gives automatic substeps as the cure for are judged by it",
          "[verifier][study][stress][docs]") {
  const std::string readme = source_tree::read_text(source_root + "/README.md");
  const std::size_t at = readme.find("`ticktrue stress ");
  REQUIRE(at != std::string::npos);
  std::string command = readme.substr(at + 17, readme.find('`', at + 1) - at - 17);
  CHECK(contains(readme.substr(at, 200), "\"substeps\": \"auto\""));
  std::vector<std::string> named;
  for (std::size_t begin = 0; begin < command.size();) {
    const std::size_t end = std::min(command.find(' ', begin), command.size());
    named.push_back(command.substr(begin, end - begin));
    begin = end + 1;
  }
  REQUIRE_FALSE(named.empty());
  int count = 0;
  for (const tool::StressCase& c : tool::stress_cases()) {
    const bool is_named =
        std::any_of(named.begin(), named.end(), [&](const std::string& name) { return begins_with(c.name, name); });
    const bool is_cured = std::any_of(c.cures.begin(), c.cures.end(), [](const tool::StressCure& cure) {
      return cure.place == "README.md" && cure.method == "tgs_soft auto";
    });
    CAPTURE(c.name);
    CHECK(is_named == is_cured);
    count += is_named ? 1 : 0;
  }
  CHECK(count >= 20);
}

TEST_CASE("each shortfall and each cure of a stress case is one of a method of its, and stands in the documents",
          "[verifier][study][stress][docs]") {
  const std::string study = source_tree::read_text(source_root + "/docs/study.md");
  for (const tool::StressCase& c : tool::stress_cases()) {
    CAPTURE(c.name);
    const auto has_method = [&](const std::string& name) {
      return std::any_of(c.methods.begin(), c.methods.end(),
                         [&](const tool::StressMethod& m) { return m.name == name; });
    };
    for (const tool::StressShortfall& known : c.shortfalls) {
      CAPTURE(known.reason);
      CHECK(has_method(known.method));
      CHECK(contains(study, known.reason));
    }
    for (const tool::StressCure& cure : c.cures) {
      CHECK(has_method(cure.method));
      CHECK_FALSE(source_tree::read_text(source_root + "/" + cure.place).empty());
    }
  }
}

TEST_CASE("automatic substeps see loads that are not weight, and fixed ones do not", "[verifier][study][stress]") {
  const std::vector<tool::StressRow> rows = rows_of(
      {"load_force_5_10000", "load_input_5_10000", "load_ram_5_10000", "load_pointer_5_100", "load_pusher_5_100"},
      {Precision::f32});
  for (const char* name : {"load_force_5_10000", "load_input_5_10000", "load_ram_5_10000"}) {
    CHECK(row_of(rows, name, "tgs_soft").value > 100);
    CHECK(row_of(rows, name, "tgs_soft").verdict == tool::StudyVerdict::falls_short);
    CHECK(row_of(rows, name, "tgs_soft auto").value > 0.8);
  }
  for (const tool::StressRow& row : rows) {
    CAPTURE(row.name, row.method, row.reason);
    CHECK(row.verdict != tool::StudyVerdict::not_applicable);
    CHECK(row.verdict != tool::StudyVerdict::fail);
    if (row.method == "tgs_soft auto") CHECK(row.verdict == tool::StudyVerdict::pass);
  }
}

TEST_CASE("bolas keep their energy and their joints with automatic substeps, and not at the default",
          "[verifier][study][stress]") {
  const std::vector<tool::StressRow> rows = rows_of({"floating_bolas_20", "floating_bolas_50"}, {Precision::f64});
  CHECK(row_of(rows, "floating_bolas_20_energy", "tgs_soft", Precision::f64).value > 0.1);
  CHECK(row_of(rows, "floating_bolas_20_energy", "tgs_soft auto", Precision::f64).value < 1e-4);
  CHECK(row_of(rows, "floating_bolas_20_gap", "tgs_soft direct", Precision::f64).value < 1e-8);
  CHECK(row_of(rows, "floating_bolas_50_energy", "tgs_soft direct", Precision::f64).value > 0.1);
  CHECK(row_of(rows, "floating_bolas_50_energy", "tgs_soft auto", Precision::f64).value < 0.002);
}

TEST_CASE("mechanisms gain no energy, whatever the joint, the integrator and the solver of joints",
          "[verifier][study][stress]") {
  const std::vector<tool::StressRow> rows = rows_of({"gain_", "direct_gain_"}, {Precision::f64});
  int count = 0;
  for (const tool::StressRow& row : rows) {
    if (row.verdict == tool::StudyVerdict::not_applicable || row.method == "explicit_euler") continue;
    CAPTURE(row.name, row.method);
    // No mechanism has damping, so the kept share of the swing is no accident.
    const bool is_direct = begins_with(row.name, "direct_") && row.name != "direct_gain_gear";
    CHECK(row.value < (is_direct ? 1e-3 : row.name == "gain_prismatic" ? 0.012 : 0.01));
    if (is_direct) CHECK(row.value > -1e-3);
    // Gears that enter the drift by half lose a fortieth of the swing.
    if (row.name == "gain_gear" || row.name == "direct_gain_gear") CHECK(row.value > -0.005);
    ++count;
  }
  CHECK(count == 2 * 7 * 6);  // joints, integrators
}

TEST_CASE("run times of automatic and fixed substeps are taken in turns over the same ticks",
          "[verifier][study][stress]") {
  tool::RunTimeOptions options;
  options.names = {"dominoes"};
  options.tick_count = 20;
  const auto rows = run_times(options);
  REQUIRE(rows.has_value());
  REQUIRE(rows->size() == 1);
  const tool::RunTimeRow& row = rows->front();
  CHECK(row.tick_count == 20);
  CHECK(row.automatic_s > 0);
  CHECK(row.fixed_s > 0);
  CHECK(row.worst_ratio >= row.ratio());
  CHECK(row.substeps_most >= 4);
  CHECK(row.substeps_most <= 256);
  CHECK(row.ticks_at_most <= row.tick_count);
  CHECK(row.default_later_s == 0);
  CHECK(row.default_later_ratio() == 0);
  options.tick_count = 140;
  const auto longer = run_times(options);
  REQUIRE(longer.has_value());
  CHECK(longer->front().automatic_later_s > 0);
  CHECK(longer->front().automatic_later_s < longer->front().automatic_s);
  CHECK(longer->front().default_later_s > 0);
  CHECK(longer->front().default_later_s < longer->front().default_s);
  options.seconds_max = 0;
  const auto none = run_times(options);
  REQUIRE(none.has_value());
  CHECK(none->front().tick_count == 0);
  CHECK(none->front().ratio() == 0);
  options.names = {"nothing_like_this"};
  CHECK_FALSE(run_times(options).has_value());
}
