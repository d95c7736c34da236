// The cross-check if Box2D has not converged: its finest steps decide.
// SPDX-License-Identifier: MIT
#include <algorithm>

#include "tests/support/catch.h"
#include "tests/support/scenes.h"
#include "tool/box2d/box2d_peer.h"
#include "tool/crosscheck/crosscheck.h"

namespace ticktrue::test {
namespace {

using tool::Agreement;
using tool::CriterionResult;

/// A row with the means of one seed. `allowed`: the largest difference that agrees.
CriterionResult row_of(std::string_view criterion, double ours, double box2d, double allowed) {
  CriterionResult row;
  row.criterion = criterion;
  row.ours = {ours};
  row.box2d = {box2d};
  row.difference = ours > box2d ? ours - box2d : box2d - ours;
  row.tolerance = allowed;
  row.verdict = row.difference <= allowed ? Agreement::agree : Agreement::differ;
  return row;
}

/// The verdict on the engine's value, given Box2D's values with plain and with finest steps.
Agreement judged(std::string_view criterion, double ours, double plain, double finest, double allowed) {
  std::vector<CriterionResult> rows{row_of(criterion, ours, plain, allowed)};
  tool::judge_by_finest(rows, {row_of(criterion, ours, finest, allowed)}, 16);
  return rows[0].verdict;
}

/// Boxes of 1 kg below a box of `load` kg.
Scene loaded_stack(int count, double load, bool substeps_are_automatic) {
  Scene scene = empty_scene(Precision::f32);
  scene.name = "loaded";
  scene.bodies.push_back(ground());
  for (int i = 0; i <= count; ++i) {
    scene.bodies.push_back(unit_box({0, 0.5 + i}));
    scene.bodies.back().shapes[0].density = i == count ? load : 1;
  }
  if (substeps_are_automatic) scene.settings.auto_substeps.emplace();
  return scene;
}

const CriterionResult& row_named(const tool::CrosscheckReport& report, std::string_view criterion) {
  const auto found = std::find_if(report.rows.begin(), report.rows.end(),
                                  [&](const CriterionResult& row) { return row.criterion == criterion; });
  REQUIRE(found != report.rows.end());
  return *found;
}

}  // namespace

TEST_CASE("where Box2D stands with its finest steps, ours that falls differs", "[verifier][crosscheck][analytic]") {
  const std::string_view stands = tool::stands_criterion;
  CHECK(judged(stands, 0, 0, 1, 0.2) == Agreement::differ);  // both fall, but the finest steps stand
  CHECK(judged(stands, 0, 1, 1, 0.2) == Agreement::differ);
  CHECK(judged(stands, 1, 1, 0, 0.2) == Agreement::differ);    // both stand, but the finest steps fall
  CHECK(judged(stands, 1, 0, 1, 0.2) == Agreement::expected);  // Box2D has not converged
  CHECK(judged(stands, 0, 1, 0, 0.2) == Agreement::expected);
  CHECK(judged(stands, 0.5, 0, 1, 0.2) == Agreement::differ);  // a value between both is not expected here
  CHECK(judged(stands, 1, 1, 1, 0.2) == Agreement::agree);
  CHECK(judged(stands, 0, 0, 0, 0.2) == Agreement::agree);
}

TEST_CASE("a difference that Box2D's finest steps do not remove stays one", "[verifier][crosscheck][analytic]") {
  CHECK(judged("top height", 3, 2, 3, 0.1) == Agreement::expected);
  CHECK(judged("top height", 3, 2, 2, 0.1) == Agreement::differ);
  CHECK(judged("top height", 3, 2, 2.5, 0.1) == Agreement::differ);
  CHECK(judged("top height", 3, 2, 4, 0.1) == Agreement::expected);  // the value is between Box2D's values
  CHECK(judged("top height", 3, 3, 4, 0.1) == Agreement::agree);
  // judge_by_finest does not change the criteria of single bodies.
  CHECK(judged(tool::place_criterion, 3, 2, 3, 0.1) == Agreement::differ);
}

TEST_CASE("a stack under 1,001 kg is judged by what stands, not by who falls alike",
          "[verifier][crosscheck][equivalence]") {
  SKIP_UNLESS(!tool::box2d_version().empty(), "a build without Box2D");
  tool::CrosscheckOptions options;
  options.seed_count = 2;
  options.seconds = 10;
  const auto falls = tool::crosscheck(loaded_stack(4, 1001, false), options);
  REQUIRE(falls.has_value());
  const CriterionResult& fallen = row_named(*falls, tool::stands_criterion);
  CAPTURE(fallen.reason);
  CHECK(tool::mean_of(fallen.ours) == 0);
  REQUIRE(!fallen.box2d_finest.empty());
  CHECK(tool::mean_of(fallen.box2d_finest) == 1);
  CHECK(fallen.verdict == Agreement::differ);
  CHECK(fallen.reason.find("ours with 4 times the substeps") != std::string::npos);

  const auto stood = tool::crosscheck(loaded_stack(4, 1001, true), options);
  REQUIRE(stood.has_value());
  const CriterionResult& standing = row_named(*stood, tool::stands_criterion);
  CAPTURE(standing.reason);
  CHECK(tool::mean_of(standing.ours) == 1);
  CHECK(standing.verdict != Agreement::differ);
}

TEST_CASE("thin boxes are compared with a thinner skin, and the report counts them",
          "[verifier][crosscheck][analytic]") {
  SKIP_UNLESS(!tool::box2d_version().empty(), "a build without Box2D");
  Scene scene = empty_scene(Precision::f32);
  scene.bodies.push_back(ground());
  for (int i = 0; i < 3; ++i) scene.bodies.push_back(body_of(box_shape(0.2, 0.01), {0, 0.01 + 0.02 * i}));
  tool::CrosscheckOptions options;
  options.seed_count = 2;
  options.seconds = 2;
  const auto report = tool::crosscheck(scene, options);
  REQUIRE(report.has_value());
  CHECK(report->thin_shape_count == 3);
  CHECK(row_named(*report, tool::stands_criterion).verdict == Agreement::agree);
}

}  // namespace ticktrue::test
