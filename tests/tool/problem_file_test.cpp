// Users' problems: accepted files, refusals with reasons, and verdicts.
// SPDX-License-Identifier: MIT
#include "tool/study/problem_file/problem_file.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "tests/support/schema_keys.h"
#include "tool/expression/expression.h"
#include "tool/study/accuracy.h"
#include "tool/study/problem_file/reference_table.h"
#include "tool/study/problem_file/stress_file.h"

namespace ticktrue::test {
namespace {

using engine::Precision;
using tool::AccuracyCurve;
using tool::Problem;
using tool::ReferenceTable;
using tool::StudyVerdict;

void write_text(const std::string& path, const std::string& text) {
  write_file(path, Bytes(text.begin(), text.end()));
}

bool has_expressions() {
  return tool::Expression::parse("1", "test").has_value();
}

/// A ball thrown at (3, 7) m/s that hits nothing.
std::string thrown(const std::string& more = "", const std::string& exact = R"("exact": ["3*t", "7*t - 5*t^2"])") {
  return R"({"scene": "projectile?solver=tgs_soft", "duration": 1, "samples": 10, "observe": ["bodies.0.x", "bodies.0.y"], )" +
         exact + more + "}";
}

Result<Problem> read(const std::string& json) {
  const TemporaryFolder folder;
  write_text(folder.file("p.json"), json);
  return tool::read_problem(folder.file("p.json"));
}

std::string refusal(const std::string& json) {
  const auto problem = read(json);
  return problem ? "" : problem.error().message;
}

std::vector<AccuracyCurve> run(const Problem& problem) {
  tool::AccuracyOptions options;
  options.precisions = {engine::Precision::f64};
  options.repeat_max = 1;
  auto curves = tool::run_accuracy({problem}, options);
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
  CHECK(run(*wrong)[0].judgement.verdict == StudyVerdict::fail);
}

TEST_CASE("a claimed slope that no curve can show fails, unless rounding hides it", "[verifier][study]") {
  if (!has_expressions()) return;
  const auto judged = [](const std::string& json) {
    const auto problem = read(json);
    if (!problem) FAIL(problem.error().message);
    CHECK(tool::claims_of_own(*problem));
    return run(*problem)[0].judgement;
  };
  const std::string claim = R"(, "methods": ["tgs_soft"], "slope": 1)";
  const auto far_off = judged(thrown(claim, R"("exact": ["6*t", "7*t - 5*t^2"])"));
  CHECK(far_off.verdict == StudyVerdict::fail);
  CHECK(far_off.reason.find("at the finest setting, 64 sub") != std::string::npos);

  const std::string explodes = R"j({"scene": {"settings": {"solver": "free_flight", "integrator": "explicit_euler"},
      "bodies": [{"position": [1, 0], "shapes": [{"type": "circle", "radius": 0.5}]}],
      "forces": [{"type": "spring", "body": 0, "point": [0, 0], "stiffness": 1e9}]}, "duration": 1, "samples": 10,
      "observe": "bodies.0.x", "exact": "cos(t)", "methods": ["explicit_euler"])j";
  for (const char* more : {"}", R"(, "slope": 1})"}) {
    const auto problem = read(explodes + more);
    if (!problem) FAIL(problem.error().message);
    const auto judgement = run(*problem)[0].judgement;
    CAPTURE(judgement.reason);
    CHECK(judgement.verdict == StudyVerdict::fail);
    CHECK(judgement.reason.find("not finite") != std::string::npos);
  }

  // A claim that stays unseen is named beside a bar that is kept.
  const auto hidden = judged(R"({"scene": "projectile?solver=tgs_soft&integrator=velocity_verlet", "duration": 1,
      "samples": 10, "observe": "bodies.0.x", "exact": "3*t", "methods": ["tgs_soft"], "slope": 7,
      "bars": [{"method": "tgs_soft", "error": 0.1}]})");
  CHECK(hidden.verdict == StudyVerdict::pass);
  CHECK(hidden.expected.value_or(0) == 7);
  CHECK(hidden.reason.find("by its bars alone: rounding") == 0);
}

TEST_CASE("a slope may be claimed for each order, and for each method", "[verifier][study]") {
  if (!has_expressions()) return;
  const auto slopes = [](const std::string& scene, const std::string& claim) {
    const auto problem =
        read(R"({"scene": ")" + scene + R"(", "duration": 1, "observe": "bodies.0.x", "exact": "3*t", )" +
             R"("slope": )" + claim + "}");
    if (!problem) FAIL(problem.error().message);
    std::vector<std::pair<std::string, double>> out;
    for (const tool::Method& method : tool::methods_of(*problem))
      out.emplace_back(method.name, tool::expectation_of(*problem, method).slope.value_or(0));
    return out;
  };
  for (const auto& [name, slope] : slopes("projectile", "[1, 2]")) {
    const auto* info = engine::find_choice(engine::integrators, name);
    REQUIRE(info);
    CHECK(slope == (info->order >= 2 ? 2 : 1));
  }
  for (const auto& [name, slope] : slopes("projectile?solver=tgs_soft", R"({"tgs_soft": 1, "tgs_soft rk4": 4})"))
    CHECK(slope == (name == "tgs_soft" ? 1 : name == "tgs_soft rk4" ? 4 : 0));
}

TEST_CASE("each observed value may have a scale of its own", "[verifier][study]") {
  if (!has_expressions()) return;
  const auto error_of = [](const std::string& exact, const std::string& scale) {
    const auto problem = read(thrown(R"(, "methods": ["tgs_soft"], "scale": )" + scale, exact));
    if (!problem) FAIL(problem.error().message);
    return run(*problem)[0].points.back().error;
  };
  const std::string wrong_x = R"("exact": ["3.3*t", "7*t - 5*t^2"])";  // by .3 m after 1 s
  CHECK(error_of(wrong_x, "100") < 0.003);
  CHECK(error_of(wrong_x, "[3, 100]") == Approx(0.1 * std::sqrt(0.385)).epsilon(0.01));  // squares of .1 to 1
  CHECK(error_of(wrong_x, "[100, 2]") < 0.01);
}

TEST_CASE("the example is a problem, and passes", "[verifier][study]") {
  if (!has_expressions()) return;
  const auto problem = read(tool::example_problem);
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
  const auto problem = tool::read_problem(folder.file("p.json"));
  if (!problem) FAIL(problem.error().message);
  CHECK(run(*problem)[0].judgement.verdict == StudyVerdict::pass);
  write_text(folder.file("p.json"), thrown(R"(, "samples2": 3)", R"("reference": "ref.csv")"));
  CHECK_FALSE(tool::read_problem(folder.file("p.json")).has_value());
  write_text(folder.file("ref.csv"), "0,0,0\n0.5,1,1\n");
  write_text(folder.file("p.json"), thrown("", R"("reference": "ref.csv")"));
  const auto short_one = tool::read_problem(folder.file("p.json"));
  REQUIRE_FALSE(short_one.has_value());
  CHECK(short_one.error().message.find("found times from 0 to 0.5 s, expected 0.1 to 1 s") != std::string::npos);
}

TEST_CASE("between the rows of a table stands the cubic through four of them", "[verifier][study]") {
  std::string csv;
  for (int i = 0; i < 9; ++i) {
    const double t = i * i / 8.0;
    csv += std::to_string(t) + "," + std::to_string(t * t * t - 2 * t) + "\n";
  }
  const auto table = ReferenceTable::parse(csv, "t.csv", {"x"});
  REQUIRE(table.has_value());
  for (double t = 0; t <= 8; t += 0.37) CHECK(table->at(t)[0] == Approx(t * t * t - 2 * t).margin(1e-3));
  CHECK(table->at(table->last_time())[0] == Approx(8 * 8 * 8 - 16));
  const char* wrong[]{"",         "0,1\n",        "0,1\n0,2\n",   "1,1\n0,2\n",
                      "0,1\n1\n", "0,1\n1,2,3\n", "0,1\n1,nan\n", "0,1\nx,y\n"};
  for (const char* text : wrong) {
    CAPTURE(text);
    CHECK_FALSE(ReferenceTable::parse(text, "t.csv", {"x"}).has_value());
  }
  CHECK(ReferenceTable::parse("t,v\n# note\n0,1\n1,2\r\n", "t.csv", {"x"}).has_value());
}

TEST_CASE("names in the first line choose the columns of a reference table", "[verifier][study]") {
  const std::vector<std::string> names{"bodies.1.x", "bodies.1.y"};
  const auto at_1 = [&](const char* text) {
    const auto table = ReferenceTable::parse(text, "t.csv", names);
    INFO((table ? std::string() : table.error().message));
    REQUIRE(table.has_value());
    return table->at(1);
  };
  CHECK(at_1("tick,time,bodies.1.y,energy,bodies.1.x\n0,0,1,9,2\n1,1,3,9,4\n") == std::vector<double>{4, 3});
  CHECK(at_1("# note\ntime,bodies.1.x,bodies.1.y\n0,1,2\n1,3,4\n") == std::vector<double>{3, 4});
  CHECK(at_1("t,x,y\n0,1,2\n1,3,4\n") == std::vector<double>{3, 4});
  CHECK(at_1("0,1,2\n1,3,4\n") == std::vector<double>{3, 4});
  const std::pair<const char*, const char*> wrong[]{
      {"tick,time,bodies.1.x\n0,0,1\n1,1,3\n", "expected time,bodies.1.x,bodies.1.y"},
      {"0,oops,0\n1,2,3\n2,3,4\n", "t.csv:1: found \"0,oops,0\", expected 3 numbers: time,bodies.1.x,bodies.1.y"},
      {"time,bodies.1.y,bodies.1.x\n0,1\n", "expected 3 numbers"},
  };
  for (const auto& [text, message] : wrong) {
    const auto table = ReferenceTable::parse(text, "t.csv", names);
    REQUIRE_FALSE(table.has_value());
    CAPTURE(table.error().message);
    CHECK(table.error().message.find(message) != std::string::npos);
  }
}

TEST_CASE("what a problem file cannot mean is refused with its place", "[verifier][study]") {
  if (!has_expressions()) return;
  const std::pair<std::string, const char*> cases[]{
      {"{", "JSON"},
      {thrown(R"(, "slpoe": 1)"), "unknown key: found \"slpoe\""},
      {R"({"scene": "projectile?solver=tgs_soft", "observe": "bodies.0.x", "exact": "t"})", "duration: missing"},
      {thrown("", R"("scale": 1)"), "found neither exact nor reference"},
      {thrown("", R"("exact": "3*t")"), "exact: found 1 expressions, expected 2"},
      {thrown("", R"("exact": ["3*t", "7*u"])"), "exact: \"7*u\""},
      {thrown("", R"("exact": ["0", "0"])"), "scale: found none"},
      {thrown("", R"("exact": ["1/0", "0"])"), "exact: found a value that is not finite"},
      {thrown(R"(, "methods": ["tgs"])"), "methods: found method \"tgs\", expected tgs_soft"},
      {thrown(R"(, "bars": [{"method": "tgs_soft"}])"), "bars[0]: found no bar"},
      {thrown(R"(, "bars": [{"method": "tgs_soft", "at": "3 sub", "error": 1}])"), "bars: found setting \"3 sub\""},
      {thrown(R"(, "methods": ["pgs"], "bars": [{"method": "tgs_soft", "error": 1}])"), "which methods leaves out"},
      {thrown(R"(, "substeps": [4, 2])"), "substeps[1]: found 2, expected more than before"},
      {thrown(R"(, "substeps": [128, 256, 512])"),
       "substeps[2]: must be a whole number in range: found 512, expected 1..256"},
      {thrown(R"(, "substeps": [1, 2], "slope": 1)"), "substeps: found 2 of them, expected at least 3"},
      {thrown(R"(, "slope": {})"), "slope: found nothing"},
      {thrown(R"(, "slope": {"tgs": 1})"), "slope: found method \"tgs\", expected tgs_soft"},
      {thrown(R"(, "slope": {"pgs": "one"})"), "slope.pgs"},
      {thrown(R"(, "scale": [])"), "scale: found nothing"},
      {thrown(R"(, "scale": [1, 2, 3])"), "scale: found 3 numbers, expected one, or 2"},
      {thrown(R"(, "scale": [1, 2], "size": 1)"), "scale: found several numbers"},
      {thrown("", R"("exact": ["30*t", "7*t - 5*t^2"])"), "scale: found none, and values of observe of up to 30"},
      {R"({"scene": "projectile", "duration": 1, "observe": "bodies.0.x", "exact": "3*t", "substeps": [1, 2, 4]})",
       "substeps: found with free_flight"},
      {R"({"scene": {"bodies": [{"shapes": [{"type": "circle", "radius": 0.5}]}],
           "forces": [{"type": "spring", "body": 0, "point": [0, 1], "stiffness": 1}]}, "duration": 1, "samples": 10,
           "observe": "bodies.0.x", "exact": "3*t", "bars": [{"method": "tgs_soft", "energy": 1}]})",
       "bars: found energy in a scene with springs"},
      {R"({"scene": "projectile?solver=tgs_soft", "duration": 1, "samples": 7, "observe": "bodies.0.x", "exact": "3*t"})",
       "samples: found 7 in 1 s"},
      {R"({"scene": "projectile?solver=tgs_soft", "duration": 1, "observe": "bodies.9.x", "exact": "3*t"})",
       "observe: bodies.9.x: found no body 9: the scene has 1, expected 0"},
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
  using tool::Expression;
  using tool::ExpressionNames;
  CHECK_FALSE(tool::Expression::parse("bodies.0.x", "test").has_value());
  CHECK_FALSE(tool::Expression::parse("bodies.0.z", "test", tool::ExpressionNames::world_and_parts).has_value());
  CHECK_FALSE(tool::Expression::parse("bodies.x", "test", tool::ExpressionNames::world_and_parts).has_value());
  CHECK_FALSE(tool::Expression::parse("energy", "test", tool::ExpressionNames::time).has_value());
  auto time = tool::Expression::parse("2*t + 0.5", "test", tool::ExpressionNames::time);
  REQUIRE(time.has_value());
  CHECK(time->evaluate_at(3) == 6.5);
}

// ---- Stress cases ----

namespace {

Result<std::vector<tool::StressCase>> read_stress(const std::string& json) {
  const TemporaryFolder folder;
  write_text(folder.file("s.json"), json);
  return tool::read_stress_file(folder.file("s.json"));
}
std::vector<tool::StressCase> stress_of(const std::string& json) {
  auto cases = read_stress(json);
  INFO((cases ? "" : cases.error().message));
  REQUIRE(cases.has_value());
  return *cases;
}
/// The value of the scene with its own settings.
double stress_value(const std::string& json) {
  const std::vector<tool::StressCase> cases = stress_of(json);
  REQUIRE(cases.size() == 1);
  return cases[0].run(cases[0].methods[0], Precision::f64).value;
}

}  // namespace

TEST_CASE("the example of a stress case shows what a load does", "[verifier][study]") {
  if (!has_expressions()) return;
  tool::StressOptions options;
  options.own = stress_of(tool::example_stress);
  const auto rows = tool::run_stress(options);
  REQUIRE(rows.has_value());
  REQUIRE(rows->size() == 9);  // three loads with three methods, and no built-in case
  CHECK((*rows)[0].name == "loaded bodies.5.shapes.0.density=1");
  CHECK((*rows)[0].verdict == StudyVerdict::pass);
  CHECK((*rows)[6].verdict == StudyVerdict::pass);
  CHECK((*rows)[7].verdict == StudyVerdict::not_judged);
}

TEST_CASE("no other method excuses a failure in a stress file", "[verifier][study]") {
  if (!has_expressions()) return;
  const auto verdicts = [](const std::string& more) {
    tool::StressOptions options;
    options.own = stress_of(R"({"scene": "stack?boxes=5&substeps=4", "vary": "bodies.5.shapes.0.density=1000",
        "duration": 3, "from": 2, "measure": "overlap", "upper": 0.05)" +
                            more + "}");
    const auto rows = tool::run_stress(options);
    REQUIRE(rows.has_value());
    std::vector<std::pair<std::string, StudyVerdict>> out;
    for (const tool::StressRow& row : *rows) out.emplace_back(row.method, row.verdict);
    return out;
  };
  using tool::StudyVerdict;
  const auto all = verdicts("");
  CHECK(all[0] == std::pair{std::string("scene"), StudyVerdict::fail});
  for (std::size_t i = 1; i < all.size(); ++i)  // what passes passes, nothing else fails
    CHECK((all[i].second == StudyVerdict::pass || all[i].second == StudyVerdict::not_judged));
  const auto both = verdicts(R"(, "methods": ["scene", "tgs_soft auto"])");
  REQUIRE(both.size() == 2);
  CHECK(both[0].second == StudyVerdict::fail);
  CHECK(both[1].second == StudyVerdict::pass);
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
  const tool::StressValue value = cases[0].run(cases[0].methods[0], Precision::f64);
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
      {R"({"scene": "stack?boxes=2", "duration": 1, "measure": "bodies.9.x", "upper": 1})",
       "measure: bodies.9.x: found no body 9"},
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

namespace {

using nlohmann::json;

json schema_of(const std::string& name) {
  return json::parse(std::ifstream(std::filesystem::path(TICKTRUE_SOURCE_DIR) / "scenes" / name));
}

// The example without a key, for each key.
template <typename Visit>
void for_each_lack(const std::string& example, const Visit& visit) {
  const json whole = json::parse(example);
  for (const std::string& key : keys_of(whole)) {
    json part = whole;
    part.erase(key);
    visit(key, part.dump());
  }
}

}  // namespace

TEST_CASE("the JSON Schemas of problems and stress cases have the keys of their readers",
          "[verifier][study][equivalence]") {
  if (!has_expressions()) return;
  const json problem = schema_of("problem.schema.json");
  const json stress = schema_of("stress.schema.json");
  CHECK(reader_keys(refusal(R"({"?":0})")) == keys_of(problem["properties"]));
  CHECK(reader_keys(refusal(thrown(R"(,"bars":[{"?":0}])"))) == keys_of(problem["$defs"]["bar"]["properties"]));
  const auto stress_refusal = [](const std::string& text) {
    const auto cases_read = read_stress(text);
    return cases_read ? std::string() : cases_read.error().message;
  };
  CHECK(reader_keys(stress_refusal(R"({"?":0})")) == keys_of(stress["properties"]));
  const std::set<std::string> overs = stress["properties"]["over"]["enum"];
  json wrong = json::parse(tool::example_stress);
  wrong["over"] = "?";
  for (const std::string& name : overs) CHECK(stress_refusal(wrong.dump()).find(name) != std::string::npos);
  CHECK(overs.size() == 3);
  // The reader requires the keys that the schema requires, and no others.
  const std::set<std::string> of_problem = problem["required"], of_stress = stress["required"];
  for_each_lack(tool::example_problem, [&](const std::string& key, const std::string& text) {
    CAPTURE(key);
    CHECK((refusal(text) != "") == (of_problem.count(key) == 1 || key == "exact"));
  });
  for_each_lack(tool::example_stress, [&](const std::string& key, const std::string& text) {
    CAPTURE(key);
    CHECK((stress_refusal(text) != "") == (of_stress.count(key) == 1 || key == "upper"));
  });
  CHECK(refusal(thrown(R"(,"$schema":"problem.schema.json")")) == "");
  const json& samples = problem["properties"]["samples"];
  const auto refuses = [](const json& part, const std::string& key, int value) {
    json text = part;
    text[key] = value;
    return refusal(text.dump()).find(key + ": ") != std::string::npos;
  };
  const json whole = json::parse(tool::example_problem);
  CHECK(refuses(whole, "samples", samples["minimum"].get<int>() - 1));
  CHECK(refuses(whole, "samples", samples["maximum"].get<int>() + 1));
}

}  // namespace ticktrue::test
