// The suite of the cross-check: its scenes are valid, and it distinguishes a standing solver from a falling one.
// SPDX-License-Identifier: MIT
#include "tool/study/crosscheck_suite.h"

#include <algorithm>
#include <set>
#include <string>

#include "tests/support/catch.h"
#include "tool/box2d/box2d_peer.h"
#include "tool/crosscheck/crosscheck.h"

namespace ticktrue::test {
namespace {

const tool::SuiteScene& find_scene(std::string_view name) {
  const auto scenes = tool::crosscheck_suite();
  const auto found =
      std::find_if(scenes.begin(), scenes.end(), [&](const tool::SuiteScene& scene) { return scene.name == name; });
  REQUIRE(found != scenes.end());
  return *found;
}

tool::CrosscheckReport check(std::string_view name, std::uint32_t seeds) {
  const tool::SuiteScene& scene = find_scene(name);
  tool::CrosscheckOptions options;
  options.solvers = {engine::SolverKind::tgs_soft, engine::SolverKind::impulse};
  options.seed_count = seeds;
  options.seconds = scene.seconds;
  options.match_skin = true;
  const Result<tool::CrosscheckReport> report = crosscheck(scene.make(), options);
  REQUIRE(report);
  return *report;
}

const tool::CrosscheckSolver& solver_of(const tool::CrosscheckReport& report, std::string_view name) {
  const auto found = std::find_if(report.solvers.begin(), report.solvers.end(),
                                  [&](const tool::CrosscheckSolver& solver) { return solver.solver == name; });
  REQUIRE(found != report.solvers.end());
  return *found;
}

TEST_CASE("the suite has at least 25 sound scenes with names of their own", "[verifier][crosscheck_suite]") {
  std::set<std::string_view> names;
  for (const tool::SuiteScene& scene : tool::crosscheck_suite()) {
    INFO(scene.name);
    names.insert(scene.name);
    const engine::Scene made = scene.make();
    const Status checked = engine::check_scene(made, std::string(scene.name));
    INFO((checked ? "" : checked.error().message));
    CHECK(checked);
    CHECK(tool::make_layout(made).dynamic_count > 0);
    CHECK(scene.seconds > 0);
    CHECK_FALSE(scene.outcome.empty());
  }
  CHECK(names.size() >= 25);
  CHECK(names.size() == tool::crosscheck_suite().size());
}

TEST_CASE("scenes of the suite: tgs_soft agrees with Box2D, the thesis' solver does not",
          "[verifier][crosscheck_suite]") {
  SKIP_UNLESS(!tool::box2d_version().empty(), "a build without Box2D");
  for (const std::string_view name : {"tower_5", "arch", "slope_slides"}) {
    INFO(name);
    const tool::CrosscheckReport report = check(name, 2);
    CHECK(solver_of(report, "tgs_soft").failed == 0);
    CHECK(solver_of(report, "tgs_soft").passed > 0);
    CHECK(solver_of(report, "impulse").failed > 0);
  }
}

TEST_CASE("scenes in which the default falls and Box2D's finest steps stand are judged so",
          "[verifier][crosscheck_suite]") {
  int count = 0;
  for (const tool::SuiteScene& scene : tool::crosscheck_suite()) {
    if (!scene.falls_short) continue;
    CAPTURE(scene.name);
    CHECK_FALSE(scene.make().settings.auto_substeps.has_value());
    CHECK(scene.make().settings.substeps == 4);
    ++count;
  }
  CHECK(count == 10);
  SKIP_UNLESS(!tool::box2d_version().empty(), "a build without Box2D");
  for (const std::string_view name : {"under_100", "growing"}) {
    CAPTURE(name);
    const tool::CrosscheckReport report = check(name, 1);
    const auto stands = std::find_if(report.rows.begin(), report.rows.end(), [](const tool::CriterionResult& row) {
      return row.solver == "tgs_soft" && row.criterion == tool::stands_criterion;
    });
    REQUIRE(stands != report.rows.end());
    CHECK(stands->verdict == tool::Agreement::differ);
    CHECK(tool::mean_of(stands->ours) == 0);
    CHECK(tool::mean_of(stands->box2d) == 0);  // both fall: only the finest steps show the difference
    REQUIRE_FALSE(stands->box2d_finest.empty());
    CHECK(tool::mean_of(stands->box2d_finest) == 1);
  }
}

TEST_CASE("falls whose end depends on the step are no difference of physics", "[verifier][crosscheck_suite]") {
  SKIP_UNLESS(!tool::box2d_version().empty(), "a build without Box2D");
  const struct {
    std::string_view scene, criterion;
    tool::Agreement verdict;
  } cases[]{{"leaning_falls", tool::top_criterion, tool::Agreement::expected},
            {"slope_topples", tool::travel_criterion, tool::Agreement::not_applicable}};
  for (const auto& [scene, criterion, verdict] : cases) {
    CAPTURE(scene);
    const tool::CrosscheckReport report = check(scene, 3);
    for (const tool::CriterionResult& row : report.rows) {
      if (row.solver != "tgs_soft") continue;
      CAPTURE(row.criterion, row.reason);
      CHECK(row.verdict != tool::Agreement::differ);
      if (row.criterion != criterion) continue;
      CHECK(row.difference > row.tolerance);
      CHECK(row.verdict == verdict);
    }
  }
}

TEST_CASE("a solver without joints is not applicable to a chain, beside one that is", "[verifier][crosscheck_suite]") {
  SKIP_UNLESS(!tool::box2d_version().empty(), "a build without Box2D");
  const tool::CrosscheckReport report = check("hanging_chain", 1);
  CHECK(solver_of(report, "tgs_soft").passed > 0);
  CHECK(solver_of(report, "impulse").not_applicable == 1);
  CHECK(solver_of(report, "impulse").failed == 0);
}

TEST_CASE("with its skin matched Box2D's tower is as high as its boxes", "[verifier][crosscheck_suite][analytic]") {
  SKIP_UNLESS(!tool::box2d_version().empty(), "a build without Box2D");
  const engine::Scene scene = find_scene("tower_5").make();
  for (const bool match_skin : {false, true}) {
    INFO(match_skin);
    tool::Box2dOptions options;
    options.match_skin = match_skin;
    const Result<std::unique_ptr<tool::Box2dPeer>> peer = make_box2d_peer(scene, options);
    REQUIRE(peer);
    for (int tick = 0; tick < 300; ++tick) (*peer)->step();
    double top = 0;
    for (const engine::BodyReport& body : (*peer)->bodies()) top = std::max(top, body.center.y);
    // Box2D leaves at most a slop of overlap at each of the five contacts. With the skin, each contact stays 1.5 cm
    // apart.
    if (match_skin)
      CHECK(top == Approx(4.5).margin(5 * 0.005));
    else
      CHECK(top == Approx(4.5 + 5 * 0.015).margin(5 * 0.005));
  }
}

}  // namespace
}  // namespace ticktrue::test
