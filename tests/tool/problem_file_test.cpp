// Problems of one's own: what a file may say, what is refused and why, and the verdicts on them.
// SPDX-License-Identifier: MIT
#include "tool/study/problem_file/problem_file.h"

#include <cmath>
#include <string>

#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "tool/expression/expression.h"
#include "tool/study/accuracy.h"
#include "tool/study/problem_file/reference_table.h"

namespace ticktrue::test {
namespace {

using verifier::AccuracyCurve;
using verifier::Problem;
using verifier::ReferenceTable;
using verifier::StudyVerdict;

void write_text(const std::string& path, const std::string& text) {
  write_file(path, Bytes(text.begin(), text.end()));
}

bool has_expressions() {
  return verifier::Expression::parse("1", "test").has_value();
}

/// A ball thrown at (3, 7) m/s that meets nothing.
std::string thrown(const std::string& more = "", const std::string& exact = R"("exact": ["3*t", "7*t - 5*t^2"])") {
  return R"({"scene": "projectile?solver=tgs_soft", "duration": 1, "samples": 10, "observe": ["bodies.0.x", "bodies.0.y"], )" +
         exact + more + "}";
}

Result<Problem> read(const std::string& json) {
  const TemporaryFolder folder;
  write_text(folder.file("p.json"), json);
  return verifier::read_problem(folder.file("p.json"));
}

std::string refusal(const std::string& json) {
  const auto problem = read(json);
  return problem ? "" : problem.error().message;
}

std::vector<AccuracyCurve> run(const Problem& problem) {
  verifier::AccuracyOptions options;
  options.precisions = {engine::Precision::f64};
  options.repeat_max = 1;
  auto curves = verifier::run_accuracy({problem}, options);
  REQUIRE(curves.has_value());
  return *std::move(curves);
}

}  // namespace

TEST_CASE("a problem of one's own is judged by its slope and its bars", "[verifier][study]") {
  if (!has_expressions()) return;
  const auto problem = read(thrown(R"(, "methods": ["tgs_soft"], "slope": 1)"));
  if (!problem) FAIL(problem.error().message);
  CHECK(problem->scale == Approx(std::hypot(3, 2)).epsilon(1e-12));
  auto curves = run(*problem);
  REQUIRE(curves.size() == 1);
  CAPTURE(curves[0].judgement.reason);
  CHECK(curves[0].judgement.verdict == StudyVerdict::pass);
  const double error = curves[0].points[2].error;  // 4 substeps
  REQUIRE(error > 0);
  for (const bool keeps : {true, false}) {
    const std::string bar = std::to_string(error * (keeps ? 1.01 : 0.99));
    const auto with_bar = read(
        thrown(R"(, "methods": ["tgs_soft"], "slope": 1, "bars": [{"method": "tgs_soft", "at": "4 sub", "error": )" +
               bar + "}]"));
    if (!with_bar) FAIL(with_bar.error().message);
    curves = run(*with_bar);
    CHECK(curves[0].judgement.verdict == (keeps ? StudyVerdict::pass : StudyVerdict::fail));
  }
  const auto wrong = read(thrown(R"(, "methods": ["tgs_soft"], "slope": 1)", R"("exact": ["3*t", "7*t - 4.9*t^2"])"));
  REQUIRE(wrong.has_value());
  CHECK(run(*wrong)[0].judgement.verdict != StudyVerdict::pass);
}

TEST_CASE("the example is a problem, and passes", "[verifier][study]") {
  if (!has_expressions()) return;
  const auto problem = read(verifier::example_problem);
  if (!problem) FAIL(problem.error().message);
  for (const AccuracyCurve& curve : run(*problem)) {
    CAPTURE(curve.method.name, curve.judgement.reason);
    CHECK(curve.judgement.verdict == (curve.method.name == "pgs" ? StudyVerdict::not_judged : StudyVerdict::pass));
  }
}

TEST_CASE("a reference may be a table of times and values", "[verifier][study]") {
  if (!has_expressions()) return;
  const TemporaryFolder folder;
  std::string csv = "time,x,y\n";
  for (int i = 0; i <= 25; ++i) {
    const double t = i / 25.0;
    csv += std::to_string(t) + ", " + std::to_string(3 * t) + ", " + std::to_string(7 * t - 5 * t * t) + "\n";
  }
  write_text(folder.file("ref.csv"), csv);
  write_text(folder.file("p.json"), thrown(R"(, "methods": ["tgs_soft"], "slope": 1)", R"("reference": "ref.csv")"));
  const auto problem = verifier::read_problem(folder.file("p.json"));
  if (!problem) FAIL(problem.error().message);
  CHECK(run(*problem)[0].judgement.verdict == StudyVerdict::pass);
  write_text(folder.file("p.json"), thrown(R"(, "samples2": 3)", R"("reference": "ref.csv")"));
  CHECK_FALSE(verifier::read_problem(folder.file("p.json")).has_value());
  write_text(folder.file("ref.csv"), "0,0,0\n0.5,1,1\n");
  write_text(folder.file("p.json"), thrown("", R"("reference": "ref.csv")"));
  const auto short_one = verifier::read_problem(folder.file("p.json"));
  REQUIRE_FALSE(short_one.has_value());
  CHECK(short_one.error().message.find("found times from 0 to 0.5 s, expected 0.1 to 1 s") != std::string::npos);
}

TEST_CASE("between the rows of a table stands the cubic through four of them", "[verifier][study]") {
  std::string csv;
  for (int i = 0; i < 9; ++i) {
    const double t = i * i / 8.0;
    csv += std::to_string(t) + "," + std::to_string(t * t * t - 2 * t) + "\n";
  }
  const auto table = ReferenceTable::parse(csv, "t.csv", 1);
  REQUIRE(table.has_value());
  for (double t = 0; t <= 8; t += 0.37) CHECK(table->at(t)[0] == Approx(t * t * t - 2 * t).margin(1e-3));
  CHECK(table->at(table->last_time())[0] == Approx(8 * 8 * 8 - 16));
  const char* wrong[]{"",         "0,1\n",        "0,1\n0,2\n",   "1,1\n0,2\n",
                      "0,1\n1\n", "0,1\n1,2,3\n", "0,1\n1,nan\n", "0,1\nx,y\n"};
  for (const char* text : wrong) {
    CAPTURE(text);
    CHECK_FALSE(ReferenceTable::parse(text, "t.csv", 1).has_value());
  }
  CHECK(ReferenceTable::parse("t,v\n# note\n0,1\n1,2\r\n", "t.csv", 1).has_value());
}

TEST_CASE("what a problem file cannot mean is refused with its place", "[verifier][study]") {
  if (!has_expressions()) return;
  const std::pair<std::string, const char*> cases[]{
      {"{", "JSON"},
      {thrown(R"(, "slpoe": 1)"), "unknown key: found \"slpoe\""},
      {R"({"scene": "projectile?solver=tgs_soft", "observe": "bodies.0.x", "exact": "t"})", "duration: missing"},
      {thrown("", R"("scale": 1)"), "found neither exact and reference"},
      {thrown("", R"("exact": "3*t")"), "exact: found 1 expressions, expected 2"},
      {thrown("", R"("exact": ["3*t", "7*u"])"), "exact: \"7*u\""},
      {thrown("", R"("exact": ["0", "0"])"), "scale: found none"},
      {thrown("", R"("exact": ["1/0", "0"])"), "exact: found a value that is not finite"},
      {thrown(R"(, "methods": ["tgs"])"), "methods: found method \"tgs\", expected tgs_soft"},
      {thrown(R"(, "bars": [{"method": "tgs_soft"}])"), "bars[0]: found no bar"},
      {thrown(R"(, "bars": [{"method": "tgs_soft", "at": "3 sub", "error": 1}])"), "bars: found setting \"3 sub\""},
      {thrown(R"(, "methods": ["pgs"], "bars": [{"method": "tgs_soft", "error": 1}])"), "which methods leaves out"},
      {thrown(R"(, "substeps": [4, 2])"), "substeps[1]: found 2, expected more than before"},
      {R"({"scene": "projectile?solver=tgs_soft", "duration": 1, "samples": 7, "observe": "bodies.0.x", "exact": "3*t"})",
       "samples: found 7 in 1 s"},
      {R"({"scene": "projectile?solver=tgs_soft", "duration": 1, "observe": "bodies.9.x", "exact": "3*t"})",
       "observe: \"bodies.9.x\": found nan before the first tick"},
      {R"({"scene": "projectile?solver=tgs_soft", "duration": 1, "observe": "energy_start", "exact": "3*t"})",
       "found a name with _start"},
      {R"({"scene": "projektile", "duration": 1, "observe": "bodies.0.x", "exact": "3*t"})", "projektile"},
      {R"({"scene": {"bodies": [{"position": [0]}]}, "duration": 1, "observe": "bodies.0.x", "exact": "3*t"})",
       "bodies[0].position"},
  };
  for (const auto& [json, expected] : cases) {
    CAPTURE(json);
    const std::string found = refusal(json);
    CAPTURE(found, expected);
    CHECK(found.find(expected) != std::string::npos);
  }
}

TEST_CASE("an expression may name values of bodies where it is told so", "[verifier][study]") {
  if (!has_expressions()) return;
  using verifier::Expression;
  using verifier::ExpressionNames;
  CHECK_FALSE(Expression::parse("bodies.0.x", "test").has_value());
  CHECK_FALSE(Expression::parse("bodies.0.z", "test", ExpressionNames::world_and_parts).has_value());
  CHECK_FALSE(Expression::parse("bodies.x", "test", ExpressionNames::world_and_parts).has_value());
  CHECK_FALSE(Expression::parse("energy", "test", ExpressionNames::time).has_value());
  auto time = Expression::parse("2*t + 0.5", "test", ExpressionNames::time);
  REQUIRE(time.has_value());
  CHECK(time->evaluate_at(3) == 6.5);
}

}  // namespace ticktrue::test
