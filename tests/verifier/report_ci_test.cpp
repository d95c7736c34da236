// What continuous integration is told: JUnit, GitHub Actions; and the manifest of golden traces.
// SPDX-License-Identifier: MIT
#include "verifier/report/report_ci.h"

#include <random>

#include "tests/support/catch.h"
#include "tests/verifier/toy_variants.h"
#include "verifier/corpus/golden.h"

namespace ticktrue::test {
namespace {

using verifier::Report;
using verifier::Verdict;

std::vector<Report> one_of_each() {
  std::vector<Report> reports;
  for (const verifier::VerdictInfo& info : verifier::verdicts) {
    Report report;
    report.file = std::string(info.name) + ".ttr";
    report.mode = "replay";
    report.verdict = info.verdict;
    report.reason = info.verdict == Verdict::match ? "" : "a \"reason\" & <more>, 100 %: \x01\nsecond line";
    reports.push_back(report);
  }
  return reports;
}

TEST_CASE("report_ci: JUnit has a case for each file, findings as failures, the rest as errors",
          "[verifier][report_ci][analytic]") {
  const std::string xml = verifier::report_junit(one_of_each(), false);
  CAPTURE(xml);
  CHECK(contains(xml, "tests=\"8\" failures=\"4\" errors=\"3\" skipped=\"0\""));
  CHECK(contains(xml, "<testcase classname=\"ticktrue.replay\" name=\"match.ttr\" time=\"0.000\"/>"));
  for (const char* name : {"diverged", "state_incomplete", "not_reproducible", "incomplete"})
    CHECK(contains(xml, "<failure type=\"" + std::string(name) + "\""));
  for (const char* name : {"damaged", "not_comparable", "error"})
    CHECK(contains(xml, "<error type=\"" + std::string(name) + "\""));
  CHECK(contains(xml, "a &quot;reason&quot; &amp; &lt;more&gt;, 100 %: \\u0001&#10;second line"));
  CHECK(!contains(xml, "\x01"));
}

TEST_CASE("report_ci: annotations are one line each, whatever the reason holds", "[verifier][report_ci][analytic]") {
  std::vector<Report> reports = one_of_each();
  reports[0].warnings.push_back("does it show all of its state?");
  reports[1].file = "a,b:c%.ttr";
  const std::string lines = verifier::report_github(reports, false);
  CAPTURE(lines);
  CHECK(std::count(lines.begin(), lines.end(), '\n') == 8);
  CHECK(contains(lines, "::warning file=match.ttr,title=ticktrue::does it show all of its state?\n"));
  CHECK(contains(lines, "::error file=a%2Cb%3Ac%25.ttr,title=ticktrue%3A diverged::a \"reason\" & <more>, 100 %25: "));
  const std::string table = verifier::report_markdown(reports, false);
  CHECK(contains(table, "1 of 8 traces pass"));
  CHECK(contains(table, "| damaged.ttr | damaged | "));
  CHECK(!contains(table, "| match.ttr"));
}

TEST_CASE("report_ci: an accepted cut passes everywhere", "[verifier][report_ci][analytic]") {
  const Bytes trace = toy_trace_with(toy_setup(4), 40, 8);
  auto reader = replay::TraceReader::open_bytes(ByteView(trace).first(trace.size() / 2), "cut.ttr");
  REQUIRE(reader);
  const Report report = verify(*reader, verify_options(toy_info));
  REQUIRE(report.verdict == Verdict::incomplete);
  CHECK(contains(verifier::report_junit({&report, 1}, false), "failures=\"1\""));
  CHECK(contains(verifier::report_junit({&report, 1}, true), "failures=\"0\" errors=\"0\""));
  CHECK(verifier::report_github({&report, 1}, true).empty());
}

TEST_CASE("report_ci: the sentence names tick, stage, column, row and bits", "[verifier][report_ci][analytic]") {
  injected = {37, ToySimulation::move_stage,
              [](ToySimulation& toy) { toy.bodies[1].velocity[1] = std::nextafter(toy.bodies[1].velocity[1], 1e9F); }};
  const Report report = verify_bytes(toy_trace_with(full_toy_setup(6, 0, 100), 50, 8), faulty_info);
  const std::string sentence = verifier::report_sentence(report);
  CAPTURE(sentence);
  CHECK(contains(sentence, "tick 37 of 50, stage move: bodies.velocity of row 1 (toy_"));
  CHECK(contains(sentence, ": expected "));
  CHECK(!contains(sentence, "\n"));
}

TEST_CASE("report_ci: a row that one state lacks has no values in the sentence", "[verifier][report_ci][analytic]") {
  Report report;
  report.verdict = Verdict::diverged;
  verifier::LaneReport row;
  row.table = "units";
  row.column = "hp";
  row.row = 3;
  row.expected = 7;
  report.divergence.emplace();
  report.divergence->rows = {row};
  CHECK(verifier::report_sentence(report) == "tick 0: units.hp of row 3");
  std::swap(report.divergence->rows[0].expected, report.divergence->rows[0].got);
  CHECK(verifier::report_sentence(report) == "tick 0: units.hp of row 3");
}

TEST_CASE("golden: a manifest is written as it was read", "[verifier][golden][equivalence]") {
  const std::string text =
      "# what this is\nfile\tscene\tinputs\tticks\tdetail\thash\tbytes\twhy\n"
      "a.ttr\tstack?boxes=3\t-\t60\troot\t0123456789abcdef\t100\tbecause\n# about b\n\n"
      "b.ttr\tlevel.json\tin.jsonl\t-\tfull:2..3\t-\t0\t\n# the end\n";
  const auto manifest = verifier::parse_manifest(text, "M");
  REQUIRE(manifest);
  REQUIRE(manifest->rows.size() == 2);
  CHECK(manifest->rows[0].inputs.empty());
  CHECK(manifest->rows[0].tick_count == 60u);
  CHECK(manifest->rows[1].inputs == "in.jsonl");
  CHECK(!manifest->rows[1].tick_count);
  CHECK(verifier::manifest_text(*manifest) == text);
}

TEST_CASE("golden: a wrong line of a manifest is named", "[verifier][golden][corruption]") {
  const std::pair<const char*, const char*> cases[] = {
      {"a.ttr\tstack\n", "M:1: columns: found 2, expected 8"},
      {"../a.ttr\tstack\t-\t60\troot\t-\t0\t\n", "M:1: file: found \"../a.ttr\""},
      {"a.ttr\tstack\t-\t0\troot\t-\t0\t\n", "M:1: ticks: found \"0\""},
      {"a.ttr\tstack\t-\t60\troot\tABC\t0\t\n", "M:1: hash: found \"ABC\""},
      {"a.ttr\tstack\t-\t60\troot\t-\t-1\t\n", "M:1: bytes: found \"-1\""},
      {"#\na.ttr\ts\t-\t6\troot\t-\t0\t\na.ttr\ts\t-\t6\troot\t-\t0\t\n", "M:3: file: found a.ttr again"},
  };
  for (const auto& [text, message] : cases) {
    CAPTURE(text);
    const auto manifest = verifier::parse_manifest(text, "M");
    REQUIRE(!manifest);
    CHECK(contains(manifest.error().message, message));
  }
}

verifier::GoldenRow row_named(const std::string& file) {
  verifier::GoldenRow row;
  row.file = file;
  row.scene = "command:./game --verify {}";
  row.detail = "root";
  row.hash = "0123456789abcdef";
  row.size = 7;
  row.why = "because";
  return row;
}

TEST_CASE("golden: a row is added behind the others, and every other line stays", "[verifier][golden][equivalence]") {
  std::mt19937 random(20261126);
  const std::string added = "new.ttr\tcommand:./game --verify {}\t-\t-\troot\t0123456789abcdef\t7\tbecause\n";
  const char* others[] = {"# a word\n", "\n", "file\tscene\n"};
  for (int i = 0; i < 300; ++i) {
    std::string before, after;
    for (std::size_t n = random() % 4; n > 0; --n)
      before += random() % 2 == 0 ? others[random() % (before.empty() ? 3 : 2)]
                                  : std::to_string(before.size()) + ".ttr\ts\t-\t6\troot\t-\t0\twhy\n";
    const bool has_row = before.find(".ttr") != std::string::npos;
    if (has_row) before += "last.ttr\ts\t-\t6\troot\t-\t0\twhy\n";
    for (std::size_t n = random() % 3; n > 0; --n) after += others[random() % 2];
    CAPTURE(i, before, after);
    auto manifest = verifier::parse_manifest(before + after, "M");
    REQUIRE(manifest);
    REQUIRE(verifier::add_row(*manifest, row_named("new.ttr"), "M"));
    CHECK(verifier::manifest_text(*manifest) == (has_row ? before + added + after : before + after + added));
    CHECK(!verifier::add_row(*manifest, row_named("new.ttr"), "M"));
  }
}

TEST_CASE("golden: a row that the file cannot hold is refused", "[verifier][golden][corruption]") {
  for (const char* name : {"#a.ttr", "", "file", "../a.ttr", "a/b.ttr", "a\tb.ttr", "a\nb.ttr"}) {
    CAPTURE(name);
    verifier::GoldenManifest manifest;
    CHECK(!verifier::add_row(manifest, row_named(name), "M"));
    CHECK(manifest.rows.empty());
  }
  for (std::string verifier::GoldenRow::*field : {&verifier::GoldenRow::scene, &verifier::GoldenRow::inputs,
                                                  &verifier::GoldenRow::detail, &verifier::GoldenRow::why}) {
    verifier::GoldenManifest manifest;
    verifier::GoldenRow row = row_named("a.ttr");
    row.*field = "two\nlines";
    CHECK(!verifier::add_row(manifest, row, "M"));
    row.*field = "two\tcolumns";
    CHECK(!verifier::add_row(manifest, row, "M"));
  }
}

TEST_CASE("golden: the ticks that changed are told as ranges", "[verifier][golden][analytic]") {
  const Bytes trace = toy_trace_with(toy_setup(6), 50, 8);
  auto a = open_trace(trace);
  auto b = open_trace(trace);
  CHECK(verifier::changed_ticks(a, b).empty());
  const Bytes longer = toy_trace_with(toy_setup(6), 60, 8);
  auto c = open_trace(longer);
  CHECK(verifier::changed_ticks(a, c) == "50..59 of 60");
}

}  // namespace
}  // namespace ticktrue::test
