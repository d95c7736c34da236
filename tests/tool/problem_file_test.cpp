// Users' problems: accepted files, refusals with reasons, and verdicts.
// SPDX-License-Identifier: MIT
#include "tool/study/problem_file/problem_file.h"

#include <cmath>
#include <string>

#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "tool/expression/expression.h"
#include "tool/study/accuracy.h"
#include "tool/study/problem_file/reference_table.h"
#include "tool/study/problem_file/stress_file.h"

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

/// A ball thrown at (3, 7) m/s that hits nothing.
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

// ---- Stress cases ----

namespace {

Result<std::vector<verifier::StressCase>> read_stress(const std::string& json) {
  const TemporaryFolder folder;
  write_text(folder.file("s.json"), json);
  return verifier::read_stress_file(folder.file("s.json"));
}
std::vector<verifier::StressCase> stress_of(const std::string& json) {
  auto cases = read_stress(json);
  INFO((cases ? "" : cases.error().message));
  REQUIRE(cases.has_value());
  return *cases;
}
/// The value of the scene with its own settings.
double stress_value(const std::string& json) {
  const std::vector<verifier::StressCase> cases = stress_of(json);
  REQUIRE(cases.size() == 1);
  return cases[0].run(cases[0].methods[0], Precision::f64).value;
}

}  // namespace

TEST_CASE("the example of a stress case shows what a load does", "[verifier][study]") {
  if (!has_expressions()) return;
  verifier::StressOptions options;
  options.own = stress_of(verifier::example_stress);
  const auto rows = verifier::run_stress(options);
  REQUIRE(rows.has_value());
  REQUIRE(rows->size() == 9);  // three loads with three methods, and no built-in case
  CHECK((*rows)[0].name == "loaded bodies.5.shapes.0.density=1");
  CHECK((*rows)[0].verdict == verifier::StudyVerdict::pass);
  CHECK((*rows)[6].verdict == verifier::StudyVerdict::falls_short);
  CHECK((*rows)[7].verdict == verifier::StudyVerdict::pass);
}

TEST_CASE("the largest, the least and the last value of a run count as the file says", "[verifier][study][analytic]") {
  if (!has_expressions()) return;
  const auto value = [](const std::string& keys) {
    return stress_value(R"({"scene": "projectile?solver=tgs_soft", "duration": 2, "upper": 100, "methods": "scene",)"
                        R"("measure": "bodies.0.y - bodies.0.x", )" +
                        keys + "}");
  };
  // 4 t - 5 t^2: 0.8 at 0.4 s, -1 at 1 s, -12 at 2 s.
  CHECK(value(R"("over": "largest")") == Approx(0.8).margin(0.1));
  CHECK(value(R"("over": "end")") == Approx(-12).margin(0.2));
  CHECK(value(R"("over": "least")") == Approx(-12).margin(0.2));
  CHECK(value(R"("over": "largest", "from": 1)") == Approx(-1).margin(0.2));
}

TEST_CASE("values at the start may be named, keys vary in every combination", "[verifier][study]") {
  if (!has_expressions()) return;
  const auto cases = stress_of(
      R"({"name": "p", "scene": "pendulum", "duration": 1, "measure": "energy - energy_start", "lower": -1, "upper": 1,
          "vary": ["settings.dt=0.01,0.02", "bodies.1.angular_velocity=1:2:3"]})");
  REQUIRE(cases.size() == 6);
  CHECK(cases[0].name == "p settings.dt=0.01 bodies.1.angular_velocity=1");
  CHECK(cases[5].name == "p settings.dt=0.02 bodies.1.angular_velocity=2");
  const verifier::StressValue value = cases[0].run(cases[0].methods[0], Precision::f64);
  CHECK(value.why_not.empty());
  CHECK(value.is_finite);
}

TEST_CASE("a stress file that cannot be meant is refused with its place", "[verifier][study][hostile]") {
  if (!has_expressions()) return;
  const std::string good = R"("scene": "stack?boxes=2", "duration": 1, "measure": "overlap", )";
  const std::vector<std::pair<std::string, std::string>> refusals{
      {"[]", "found an array of 0, expected an object"},
      {"{" + good + R"("uper": 1})", "uper"},
      {"{" + good + R"("unit": "m"})", "found neither lower nor upper"},
      {"{" + good + R"("upper": 1, "lower": 2})", "lower: found 2, expected at most upper"},
      {"{" + good + R"("upper": 1, "from": 1})", "from: found 1"},
      {"{" + good + R"("upper": 1, "over": "mean"})", "over"},
      {"{" + good + R"("upper": 1, "methods": ["pgss"]})", "methods: found \"pgss\", expected scene, tgs_soft"},
      {"{" + good + R"("upper": 1, "vary": "bodies.9.x=1"})", "vary"},
      {"{" + good + R"("upper": 1, "vary": "settings.dt=0.01:0.02:5000"})", "vary"},
      {R"({"scene": "stack?boxes=2", "duration": 1, "measure": "overlapp", "upper": 1})", "measure"},
      {R"({"scene": "stack?boxes=2", "duration": 0, "measure": "overlap", "upper": 1})", "duration: found 0"},
      {R"({"scene": "stack?boxes=2", "duration": 1e300, "measure": "overlap", "upper": 1})", "duration: found 1e+300"},
      {R"({"scene": "stack?boxes=2", "duration": 1, "measure": "bodies.9.x", "upper": 1})", "measure: found nan"},
      {R"({"scene": "stak", "duration": 1, "measure": "overlap", "upper": 1})", "stak"},
      {R"({"scene": 5, "duration": 1, "measure": "overlap", "upper": 1})", "scene: found 5"},
  };
  for (const auto& [json, expected] : refusals) {
    const auto cases_read = read_stress(json);
    CAPTURE(json, expected);
    REQUIRE_FALSE(cases_read.has_value());
    const std::string found = cases_read.error().message;
    CAPTURE(found);
    CHECK(found.find(expected) != std::string::npos);
  }
}

}  // namespace ticktrue::test
